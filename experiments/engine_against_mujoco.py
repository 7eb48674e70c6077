"""Free runs of the exact linear equations beside MuJoCo's own, on ten models.

    python experiments/engine_against_mujoco.py

Each model is driven at all its inputs by noise that is linear between samples; what is compared is
every axis of every sensor that moves at first order. At 0.1 mm or mrad the geometry is linear and
what is left is the equations' and MuJoCo's own error: the claim is 0.1 %. At 10 mm or mrad geometry
matters: first the linear equations, then the same with the pseudo-forces of large motion, which the
diagnosis takes (none for ball joints, and where springs are not linear). Then models with laws that
have corners, by the estimator's stepping loop: the claim is 1 %.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.contract import names_in
from twin.frame import FrameDesign
from twin.mechanisms import vocabulary
from twin.mechanisms.rollout import rollout
from twin.model import Twin
from twin.model.free_run import free_run
from twin.model.geometry import geometry_of
from twin.model.linear import LinearModel
from twin.model.self_check import SelfCheck, linear_prediction, self_check
from twin.model.sensing import sensor_columns

RATE_HZ = 256.0
SAMPLES = 2048
GENTLE, STRONG = 1e-4, 1e-2
"""Largest displacement or rotation of a port in the linear free run [m, rad]."""

LIMIT, CORNER_LIMIT = 1e-3, 1e-2
"""Largest difference as a share of the RMS, of linear models and of those with corners."""

STEPS = 32
"""Parts of a sample for laws with corners: what is left of friction is MuJoCo's, which creeps."""

CORNERS = (
    # model, input, its RMS [N], outputs, mechanism, place, values
    ("two_storey_lumped", "force_floor2", 1.0, "acc", "coulomb_friction", "storey1", (0.1, 1e-5)),
    ("two_storey_lumped", "force_floor2", 1.0, "acc", "bumper", "storey1", (2000.0, 0.002)),
    ("two_storey_lumped", "force_floor2", 1.0, "acc", "clearance", "storey2", (300.0, 1e-3, 300.0)),
    ("two_storey", "force_floor2", 1.0, "acc", "bumper", "storey2", (2000.0, -0.001)),
    ("portal_3d", "force_floor2_y", 0.5, "acc", "coulomb_friction", "storey2_y", (0.05, 1e-5)),
    ("portal_3d", "force_floor2_y", 0.5, "acc", "bumper", "storey1_rz", (200.0, 3e-4)),
    ("drive", "force", 40.0, "position", "coulomb_friction", "slide", (3.0, 1e-5)),
)

CROOKED = """<mujoco><compiler angle="radian"/><option timestep="0.0005"/><worldbody>
<body name="post" pos="0 0 0.2"><joint name="lean" type="ball" stiffness="60" damping="0.02"/>
<inertial pos="0.05 0.02 0.2" mass="1.5" diaginertia="0.02 0.03 0.015"/>
<site name="head" pos="0.1 0.05 0.4" euler="0.3 0.5 0.7"/></body></worldbody>
<actuator><motor name="hit" site="head" gear="1 0 0 0 0 0"/></actuator>
<sensor><accelerometer name="acc" site="head"/><gyro name="gyro" site="head"/>
<framepos name="laser" objtype="site" objname="head"/></sensor></mujoco>"""

LOOP = """<mujoco><compiler angle="radian"/><option timestep="0.0005" jacobian="dense"
tolerance="1e-15"/><worldbody>
<body name="link" pos="0 0 0"><joint name="low" axis="0 1 0" stiffness="30" damping="0.01"/>
<inertial pos="0 0 0.15" mass="0.3" diaginertia="0.002 0.002 0.0005"/>
<body name="floor" pos="0 0 0.3"><joint name="high" axis="0 1 0" stiffness="30"/>
<inertial pos="0 0 0" mass="2" diaginertia="0.01 0.01 0.01"/><site name="s"/></body></body>
</worldbody><equality><joint joint1="high" joint2="low" polycoef="0 -1 0 0 0" solref="0.001 1"
solimp="0.9999 0.9999 0.001 0.5 2"/></equality>
<actuator><motor name="hit" site="s" gear="1 0 0 0 0 0"/></actuator>
<sensor><accelerometer name="acc" site="s"/><jointpos name="angle" joint="low"/></sensor>
</mujoco>"""


@dataclass(frozen=True)
class Line:
    """One model's result."""

    name: str
    freedoms: int
    check: SelfCheck

    @property
    def worst(self) -> float:
        """Largest difference of any channel over its RMS."""
        return self.check.differences[self.channel]

    @property
    def channel(self) -> str:
        """Where that is."""
        return max(self.check.differences, key=lambda name: self.check.differences[name])


def models() -> dict[str, tuple[Twin, bool]]:
    """Return name -> model, and whether its ground is shaken instead of its motors driven."""
    design = FrameDesign
    return {
        "chain, lumped": (Twin.load("two_storey_lumped"), False),
        "chain, flexible": (Twin.load("two_storey"), False),
        "chain, absorber": (Twin.load("two_storey_absorber"), False),
        "chain, hinges": (Twin.of(design(kind="hinge_chain", segments=6)), False),
        "chain, shaken": (Twin.load("two_storey"), True),
        "portal, eccentric": (Twin.load("portal_3d"), False),
        "portal, shaken": (Twin.load("portal_3d"), True),
        "rotated sensors": (Twin.load("rotated_sensors"), False),
        "cantilever": (Twin.load("cantilever"), False),
        "drive": (Twin.load("drive"), False),
        "post on a ball": (Twin(CROOKED, "post"), False),
        "loop": (Twin(LOOP, "loop"), False),
    }


def line(name: str, twin: Twin, shaken: bool, reach: float = GENTLE, large: bool = False) -> Line:
    """Compare one model at a largest displacement, with what large motion adds if asked."""
    names = names_in(twin.compile())
    bare = twin.linear((), ())
    inputs = [f"acc_ground.{axis}" for axis in bare.base if axis != "z"] if shaken else []
    inputs = inputs or [n for n in names["actuator"] if np.any(twin.linear((n,), ()).B)]
    columns = sensor_columns(twin.compile())
    outputs = [n for n in columns if f"{n}.x" not in columns]
    model = twin.linear(inputs, outputs)
    size = np.linalg.norm(np.hstack([model.Cd, model.Cv, model.Ca, model.Cu]), axis=1)
    outputs = [n for n, s in zip(outputs, size, strict=True) if s > 1e-6 * size.max()]
    u = np.random.default_rng(1).standard_normal((SAMPLES, len(inputs)))
    u *= reach / _largest(model, u)
    driving, predicted = dict(zip(inputs, u.T, strict=True)), None
    model = twin.linear(inputs, outputs)
    if large and (geometry := geometry_of(twin, model)) is not None:
        moved = linear_prediction(model, u, RATE_HZ) + geometry.simulated(u, RATE_HZ)
        predicted = dict(zip(outputs, moved.T, strict=True))
    check = self_check(twin, driving, outputs, RATE_HZ, predicted=predicted)
    return Line(name, len(model.coordinates), check)


def _largest(model: LinearModel, u: np.ndarray) -> float:
    """Return the largest displacement of any port for inputs u [m, rad]."""
    rows = np.array([port.row for port in model.ports.values()])
    return float(np.max(np.abs(free_run(model.seeing(rows, 0 * rows), u, RATE_HZ))))


def with_corners() -> list[tuple[str, str, float]]:
    """Return model, law and place, and difference of models with laws that have corners.

    It is the RMS of the difference over that of the motion, over all channels together.
    """
    rows = []
    for name, force, size, kind, mechanism, place, values in CORNERS:
        twin, law = Twin.load(name), vocabulary()[mechanism](place, *values)
        u = {force: size * np.random.default_rng(1).standard_normal(SAMPLES)}
        motion = twin.including(law).simulate(u, RATE_HZ, SAMPLES)
        moving = [n for n, x in motion.columns.items() if n.startswith(kind) and np.ptp(x) > 1e-9]
        found = rollout(twin.linear([force], moving), [law], u, RATE_HZ, STEPS)
        true = np.array([motion.columns[n] for n in moving])
        off = np.array([found[n] for n in moving]) - true
        share = float(np.linalg.norm(off) / np.linalg.norm(true))
        rows.append((name, f"{mechanism} {place}", share))
    return rows


def main() -> None:
    print(f"{'model':20} freedoms  gentle [%]  at                 strong [%]  with geometry [%]")
    gentle = []
    for name, (twin, shaken) in models().items():
        first, strong = (line(name, twin, shaken, reach) for reach in (GENTLE, STRONG))
        bent = line(name, twin, shaken, STRONG, large=True)
        print(
            f"{name:20} {first.freedoms:8} {100 * first.worst:11.5f}  {first.channel:18}"
            f"{100 * strong.worst:11.4f} {100 * bent.worst:11.4f}"
        )
        gentle.append(first)
    worst = max(gentle, key=lambda one: one.worst)
    print(f"\nworst: {worst.name}, {100 * worst.worst:.4f} % of RMS at {worst.channel}")
    if worst.worst > LIMIT:
        raise SystemExit(f"above {100 * LIMIT:g} %: {worst.check.cause}")
    print(f"\n{'model':20} {'law':34} {'difference [%]':>20}")
    corners = with_corners()
    for name, law, share in corners:
        print(f"{name:20} {law:34} {100 * share:20.4f}")
    corner = max(share for _, _, share in corners)
    print(f"\nworst with corners: {100 * corner:.3f} % of RMS")
    if corner > CORNER_LIMIT:
        raise SystemExit(f"above {100 * CORNER_LIMIT:g} %")


if __name__ == "__main__":
    main()
