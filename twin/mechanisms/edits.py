"""Edits of a MuJoCo model along the places of the contract: storeys, floors, ground, pendulum."""

from __future__ import annotations

import re
from typing import Any

import mujoco
import numpy as np

from twin.errors import ModelError, available

BASE_JOINT = "base_compliance"
"""The slide joint that gives a clamped ground its compliance."""

FRICTION_SOLREF = (-1.0, -3e3)
FRICTION_SOLIMP = (0.999, 0.999, 0.001, 0.5, 2.0)
FRICTION_STEP = 5e-4
"""Solver settings of dry friction and the longest step [s] at which what sticks stays at rest.

What sticks creeps at the rate that would stop in 1/3000 s; Runge-Kutta steps of more than
2.8/3000 s make it chatter, at accelerations as large as those of the frame.
"""

STABLE = 2.0
"""Longest step times the fastest pole: Runge-Kutta (fourth order) is stable up to 2.6 at least, in
whatever direction of the left half-plane the pole lies."""

_NUMBERED = re.compile(r"^(?:storey|floor)([1-9][0-9]*)$")


def storeys(spec: mujoco.MjSpec) -> list[str]:
    """Return "storey1", "storey2", ... as far as joints or tendons of those names go."""
    found: list[str] = []
    while _joint_or_tendon(spec, f"storey{len(found) + 1}") is not None:
        found.append(f"storey{len(found) + 1}")
    return found


def floors(spec: mujoco.MjSpec) -> list[str]:
    """Return "floor1", "floor2", ... as far as the bodies go."""
    found: list[str] = []
    while spec.body(f"floor{len(found) + 1}") is not None:
        found.append(f"floor{len(found) + 1}")
    return found


def body_of(spec: mujoco.MjSpec, place: str) -> Any:
    """Return the body "floorI" or "ground".

    Raises:
        ModelError: there is none; the message lists those there are.
    """
    there = floors(spec) + (["ground"] if spec.body("ground") is not None else [])
    if place not in there:
        raise ModelError(f"no place '{place}'; there are {available(there)}")
    return spec.body(place)


def add_drift_tendon(spec: mujoco.MjSpec, place: str, name: str) -> Any:
    """Add the fixed tendon "PLACE_NAME" whose length is the drift of a storey [m].

    Raises:
        ModelError: there is no such storey; the message lists those there are.
    """
    return _tendon(spec, f"{place}_{name}", _drift_terms(spec, place))


def add_floor_tendon(spec: mujoco.MjSpec, place: str, name: str) -> Any:
    """Add the fixed tendon "PLACE_NAME" whose length is the displacement of a floor [m].

    It is absolute: the drifts of the storeys below, and the ground's where that can move.

    Raises:
        ModelError: there is no such floor; the message lists those there are.
    """
    if place not in floors(spec):
        raise ModelError(f"no place '{place}'; there are {available(floors(spec))}")
    total: dict[str, float] = {}
    for number in range(1, number_of(place) + 1):
        for joint, coefficient in _drift_terms(spec, f"storey{number}").items():
            total[joint] = total.get(joint, 0.0) + coefficient
    for joint in ("ground", BASE_JOINT):
        if spec.joint(joint) is not None:
            total[joint] = 1.0
    return _tendon(spec, f"{place}_{name}", total)


def pendulum_joint(spec: mujoco.MjSpec) -> Any:
    """Return the hinge that ``angle_pendulum`` measures.

    Raises:
        ModelError: the model has no pendulum.
    """
    for sensor in spec.sensors:
        if sensor.name == "angle_pendulum" and spec.joint(sensor.objname) is not None:
            return spec.joint(sensor.objname)
    raise ModelError(
        "no place 'pendulum': nothing measures angle_pendulum; there are "
        f"{available(storeys(spec) + floors(spec))}"
    )


def add_friction(spec: mujoco.MjSpec, element: Any, force: float) -> None:
    """Give a joint or a tendon dry friction [N, N m], and the model steps that it can stick in."""
    if force:
        spec.option.timestep = min(spec.option.timestep, FRICTION_STEP)
    element.frictionloss = force
    element.solref_friction = FRICTION_SOLREF
    element.solimp_friction = FRICTION_SOLIMP


def follow(spec: mujoco.MjSpec, mass: float, damping: float, stiffness: float) -> None:
    """Let the model step as finely as an oscillator of its own needs [kg, N s/m, N/m]."""
    poles = np.roots([mass, damping, stiffness])
    spec.option.timestep = min(spec.option.timestep, STABLE / float(max(abs(poles))))


def set_mass(
    spec: mujoco.MjSpec, body: Any, change: float = 0.0, total: float | None = None
) -> None:
    """Change a body's mass [kg] by ``change``, or make it ``total``; its inertia stays.

    What counts is the compiled mass, whether it was written or came from geoms.

    Raises:
        ModelError: nothing would be left.
    """
    compiled = spec.copy().compile()
    automatic = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        for other in spec.bodies[1:]:
            _write_inertia(other, compiled)
    spec.compiler.inertiafromgeom = automatic
    _write_inertia(body, compiled)
    mass = body.mass + change if total is None else total
    if not (np.isfinite(mass) and mass > 0):
        raise ModelError(f"{body.name}: a mass of {mass:.4g} kg would be left, it must be positive")
    body.mass = mass


def number_of(place: str) -> int:
    """Return the number in "storeyI" or "floorI", 0 for any other place."""
    match = _NUMBERED.match(place)
    return int(match[1]) if match else 0


def _write_inertia(body: Any, compiled: mujoco.MjModel) -> None:
    index = mujoco.mj_name2id(compiled, mujoco.mjtObj.mjOBJ_BODY, body.name)
    if body.explicitinertial or index < 0:
        return
    body.explicitinertial = True
    body.mass = compiled.body_mass[index]
    body.inertia = compiled.body_inertia[index]
    body.ipos = compiled.body_ipos[index]
    body.iquat = compiled.body_iquat[index]


def _joint_or_tendon(spec: mujoco.MjSpec, name: str) -> Any:
    joint = spec.joint(name)
    return joint if joint is not None else spec.tendon(name)


def _drift_terms(spec: mujoco.MjSpec, place: str) -> dict[str, float]:
    """Return joint -> coefficient, whose sum is the drift of a storey."""
    if place not in storeys(spec):
        raise ModelError(f"no place '{place}'; there are {available(storeys(spec))}")
    if spec.joint(place) is not None:
        return {place: 1.0}
    path = spec.tendon(place).path
    if any(wrap.type != mujoco.mjtWrap.mjWRAP_JOINT for wrap in path):
        raise ModelError(f"{place}: the drift must be a joint or a fixed tendon, not a spatial one")
    return {wrap.target.name: float(wrap.coef) for wrap in path}


def _tendon(spec: mujoco.MjSpec, name: str, terms: dict[str, float]) -> Any:
    tendon = spec.add_tendon(name=name)
    for joint, coefficient in terms.items():
        tendon.wrap_joint(joint, coefficient)
    return tendon
