"""Edits of a MuJoCo model along its ports, and of its masses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError, available
from twin.mechanisms.rest import Motion, Rest, free_name

Array = NDArray[np.float64]

FRICTION_SOLREF = (-1.0, -1.5e4)
FRICTION_SOLIMP = (0.999, 0.999, 0.001, 0.5, 2.0)
FRICTION_STEP = 1e-4
"""Solver settings of dry friction and the longest step [s] at which what sticks stays at rest.

MuJoCo brings what sticks to rest as fast as it would stop in 1/15000 s, and lets its force change
sign by as much too early: at 50 Hz 2 % of it. Runge-Kutta steps of more than 2.8/15000 s make it
chatter, at accelerations as large as those of the frame.
"""

SLIP_DAMPING = 2e-4
"""Damping ratio that springs which yield one after the other may have besides.

MuJoCo moves the rest of a spring that yields once a step, and within the step the spring goes on:
while it slips it is a dashpot besides, of half a step h times its stiffness k. In a mode of the
angular frequency w that has the share s of its stiffness in these springs that is a damping ratio
of h w s / 4, and w s is at most sqrt(k / m) with the mass m that the port has by itself.
"""

SLIP_STEP = 1e-5
"""Step [s] that is fine enough for any such springs: a ratio of 0.02 % at 10 Hz. By the bound a
light port, which moves by itself far above a recording's band, would ask for much less."""

STABLE = 2.0
"""Longest step times the fastest pole: Runge-Kutta (fourth order) is stable up to 2.6 at least, in
whatever direction of the left half-plane the pole lies."""

FAR = 1000.0
"""Where a spring that acts on one side only has its other end [m, rad]."""


@dataclass(frozen=True)
class Line:
    """A port of a model that is being edited: tendons along it, whose forces act there.

    Attributes:
        spec: the model.
        place: name of the port.
        motion: how it moves with the joints.
    """

    spec: mujoco.MjSpec
    place: str
    motion: Motion

    @classmethod
    def of(cls, spec: mujoco.MjSpec, place: str) -> Line:
        """Find a port. Raises ModelError: there is none; the message lists those there are."""
        return cls(spec, place, Rest(spec).motion(place))

    def tendon(self, name: str) -> Any:
        """Add the fixed tendon "PLACE_NAME" along the port, its springs at ease at rest."""
        taken = {tendon.name for tendon in self.spec.tendons}
        tendon = self.spec.add_tendon(name=free_name(f"{self.place}_{name}", taken))
        for joint, coefficient in self.motion.terms.items():
            tendon.wrap_joint(joint, coefficient)
        tendon.springlength = [self.motion.length] * 2
        return tendon

    def dead_range(self, tendon: Any, low: float, high: float) -> None:
        """Let a tendon's spring bear only beyond ``low`` and ``high``, from rest [m, rad]."""
        tendon.springlength = [self.motion.length + low, self.motion.length + high]


def driven_joint(spec: mujoco.MjSpec, place: str) -> Any:
    """Return the joint that a place of a motor means.

    It is the joint of that name, the one that the actuator of that name drives, or the one whose
    position the sensor "angle_PLACE" measures.

    Raises:
        ModelError: there is none; the message lists the joints that motors drive.
    """
    joint = spec.joint(place)
    if joint is not None:
        return joint
    of_joint = mujoco.mjtTrn.mjTRN_JOINT
    drives = {a.name: a.target for a in spec.actuators if a.trntype == of_joint}
    measured = {s.name: s.objname for s in spec.sensors if spec.joint(s.objname) is not None}
    found = spec.joint(drives.get(place) or measured.get(f"angle_{place}") or "")
    if found is None:
        there = dict.fromkeys(drives.values())
        raise ModelError(f"no place '{place}': no motor drives it; there are {available(there)}")
    return found


def body_named(spec: mujoco.MjSpec, name: str) -> Any:
    """Return a body; "body 3" is the third where it has none, and is called so then.

    Raises:
        ModelError: there is none; the message lists those there are.
    """
    bodies = {b.name or f"body {number}": b for number, b in enumerate(spec.bodies) if number}
    if name not in bodies:
        raise ModelError(f"no place '{name}'; there are {available(bodies)}")
    bodies[name].name = name
    return bodies[name]


def add_friction(spec: mujoco.MjSpec, element: Any, force: float) -> None:
    """Give a joint or a tendon dry friction [N, N m], and the model steps that it can stick in."""
    if force:
        step_finely(spec)
    element.frictionloss = force
    element.solref_friction = FRICTION_SOLREF
    element.solimp_friction = FRICTION_SOLIMP


def step_finely(spec: mujoco.MjSpec, longest: float = FRICTION_STEP) -> None:
    """Let the model step at most ``longest`` [s]: as dry friction needs that sticks."""
    spec.option.timestep = min(spec.option.timestep, longest)


def slip_finely(spec: mujoco.MjSpec, line: Line, stiffness: float) -> None:
    """Let the model step as finely as springs along a port that slip [N/m] need.

    It steps a round number of times in a second: 1, 2 or 5 times a power of ten.
    """
    longest = 4 * SLIP_DAMPING / float(np.sqrt(stiffness * line.motion.mobility))
    power = 10.0 ** np.floor(np.log10(longest))
    rounded = max(part * power for part in (1, 2, 5) if part * power <= longest)
    step_finely(spec, max(float(rounded), SLIP_STEP))


def follow(spec: mujoco.MjSpec, mass: float, damping: float, stiffness: float) -> None:
    """Let the model step as finely as an oscillator of its own needs [kg, N s/m, N/m]."""
    poles = np.roots([mass, damping, stiffness])
    spec.option.timestep = min(spec.option.timestep, STABLE / float(max(abs(poles))))


def set_mass(
    spec: mujoco.MjSpec,
    body: Any,
    change: float = 0.0,
    total: float | None = None,
    in_proportion: float = 0.0,
) -> None:
    """Change a body's mass [kg] by ``change``, or make it ``total``.

    Its inertia stays, or grows as much as the mass where ``in_proportion`` is 1.

    What counts is the compiled mass, whether it was written or came from geoms.

    Raises:
        ModelError: nothing would be left.
    """
    _write_inertias(spec, body)
    mass = body.mass + change if total is None else total
    if not (np.isfinite(mass) and mass > 0):
        raise ModelError(f"{body.name}: a mass of {mass:.4g} kg would be left, it must be positive")
    body.inertia = np.array(body.inertia) * (1 + in_proportion * (mass / body.mass - 1))
    body.mass = mass


def add_point_mass(spec: mujoco.MjSpec, site: Any, change: float) -> None:
    """Change the mass at a site [kg]: the body's mass, centre and inertia change with it.

    Raises:
        ModelError: what would be left is no rigid body.
    """
    body = site.parent
    _write_inertias(spec, body)
    before, centre = float(body.mass), np.array(body.ipos)
    mass = before + change
    if not mass > 0:
        raise ModelError(f"{body.name}: a mass of {mass:.4g} kg would be left, it must be positive")
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.array(body.iquat))
    turn = flat.reshape(3, 3)
    inertia = turn @ np.diag(body.inertia) @ turn.T
    moved = (before * centre + change * np.array(site.pos)) / mass
    inertia = inertia + _about(moved, before, centre) + _about(moved, change, np.array(site.pos))
    values, axes = np.linalg.eigh(inertia)
    if values[0] <= 0 or values[2] > (values[0] + values[1]) * (1 + 1e-9):
        raise ModelError(f"{body.name}: {change:.4g} kg at {site.name} leave no rigid body")
    if np.linalg.det(axes) < 0:
        axes = axes[:, [1, 0, 2]]
        values = values[[1, 0, 2]]
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(axes).ravel())
    body.mass, body.ipos, body.inertia, body.iquat = mass, moved, values, quaternion


def add_slide(spec: mujoco.MjSpec, body: Any, name: str, axis: Array) -> Any:
    """Let a body slide along a world axis, on top of the joints that it has."""
    taken = {joint.name for joint in spec.joints}
    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    turned = data.xmat[_index(model, body)].reshape(3, 3).T @ axis
    return body.add_joint(
        name=free_name(name, taken), type=mujoco.mjtJoint.mjJNT_SLIDE, axis=turned
    )


def fixed_mass(spec: mujoco.MjSpec, body: Any) -> float:
    """Return the mass of the bodies that are welded onto a body without joints [kg]."""
    model = spec.copy().compile()
    index = _index(model, body)
    others = (np.arange(model.nbody) != index) & (model.body_weldid == model.body_weldid[index])
    inside = [i for i in np.flatnonzero(others) if _descends(model, int(i), index)]
    return float(model.body_mass[inside].sum())


def _descends(model: mujoco.MjModel, body: int, root: int) -> bool:
    while body > root:
        body = int(model.body_parentid[body])
    return body == root


def _index(model: mujoco.MjModel, body: Any) -> int:
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body.name))


def _about(point: Array, mass: float, centre: Array) -> Array:
    """Return what a mass away from a point adds to the inertia about it [kg m^2], (3, 3)."""
    arm = centre - point
    return np.asarray(mass * (arm @ arm * np.eye(3) - np.outer(arm, arm)))


def _write_inertias(spec: mujoco.MjSpec, body: Any) -> None:
    """Write down the compiled inertia of a body, so that it can be changed."""
    compiled = spec.copy().compile()
    automatic = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        for other in spec.bodies[1:]:
            _write_inertia(other, compiled)
    spec.compiler.inertiafromgeom = automatic
    _write_inertia(body, compiled)


def _write_inertia(body: Any, compiled: mujoco.MjModel) -> None:
    index = mujoco.mj_name2id(compiled, mujoco.mjtObj.mjOBJ_BODY, body.name)
    if index < 0:
        return
    body.explicitinertial = True
    body.mass = compiled.body_mass[index]
    body.inertia = compiled.body_inertia[index]
    body.ipos = compiled.body_ipos[index]
    body.iquat = compiled.body_iquat[index]
    body.fullinertia = [np.nan, 0, 0, 0, 0, 0]
