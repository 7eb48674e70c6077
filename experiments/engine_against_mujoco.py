"""Free runs of the exact linear equations beside MuJoCo's own, on ten models.

Each model is driven at all its inputs by noise that is linear between samples, so gently that its
geometry stays linear; what is compared is every sensor's every axis that moves at first order.

Run: python experiments/engine_against_mujoco.py
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twin.contract import names_in
from twin.frame import FrameDesign
from twin.model import Twin
from twin.model.self_check import SelfCheck, self_check
from twin.model.sensing import sensor_columns

RATE_HZ = 256.0
SAMPLES = 4096
ROTATION = 1e-3
"""Largest displacement or rotation of a port in the linear free run [m, rad]."""

LIMIT = 1e-3
"""Largest difference as a share of the RMS."""

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
<sensor><accelerometer name="acc" site="s"/><jointpos name="angle" joint="low"/></sensor></mujoco>"""


@dataclass(frozen=True)
class Line:
    """One model's result."""

    name: str
    freedoms: int
    check: SelfCheck

    @property
    def worst(self) -> float:
        return self.check.differences[self.channel]

    @property
    def channel(self) -> str:
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


def line(name: str, twin: Twin, shaken: bool) -> Line:
    """Compare one model."""
    names = names_in(twin.compile())
    bare = twin.linear((), ())
    inputs = [f"acc_ground.{axis}" for axis in bare.base if axis != "z"] if shaken else []
    inputs = inputs or [n for n in names["actuator"] if np.any(twin.linear((n,), ()).B)]
    outputs = [n for n in sensor_columns(twin.compile()) if n not in names["sensor"] or _one(twin, n)]
    model = twin.linear(inputs, outputs)
    size = np.linalg.norm(np.hstack([model.Cd, model.Cv, model.Ca, model.Cu]), axis=1)
    outputs = [n for n, s in zip(outputs, size, strict=True) if s > 1e-6 * size.max()]
    rng = np.random.default_rng(1)
    u = rng.standard_normal((SAMPLES, len(inputs)))
    u *= ROTATION / _reach(twin, inputs, u)
    check = self_check(twin, dict(zip(inputs, u.T, strict=True)), outputs, RATE_HZ)
    return Line(name, len(model.coordinates), check)


def _one(twin: Twin, name: str) -> bool:
    return f"{name}.x" not in sensor_columns(twin.compile())


def _reach(twin: Twin, inputs: list[str], u: np.ndarray) -> float:
    """Return the largest displacement of a port for inputs u."""
    from dataclasses import replace

    from twin.model.free_run import free_run

    model = twin.linear(inputs, ())
    rows = np.array([p.row for p in model.ports.values()])
    zero = np.zeros_like(rows)
    seen = replace(
        model,
        outputs=tuple(model.ports),
        Cd=rows,
        Cv=zero,
        Ca=zero,
        Cu=np.zeros((len(rows), len(inputs))),
        rest=np.zeros(len(rows)),
    )
    return float(np.max(np.abs(free_run(seen, u, RATE_HZ))))


def main() -> None:
    lines = [line(name, *which) for name, which in models().items()]
    print(f"{'model':20} freedoms  worst difference  at")
    for one in lines:
        print(f"{one.name:20} {one.freedoms:8} {100 * one.worst:15.5f} %  {one.channel}  {one.check.cause}")
    worst = max(lines, key=lambda one: one.worst)
    print(f"\nworst: {worst.name}, {100 * worst.worst:.4f} % of RMS at {worst.channel}")
    if worst.worst > LIMIT:
        raise SystemExit(f"above {100 * LIMIT:g} %")


if __name__ == "__main__":
    main()
