"""What a user's model already holds that is not linear, element by element.

The linear equations take only the slope of an element at rest. What is left is stated here: as a
mechanism of the vocabulary with its values where there is one, and always as a law whose size can
be judged at given amplitudes (``twin.model.amplitudes``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Law = Callable[[Array, Array], Array]
_OBJ = mujoco.mjtObj

IDEAL = 20.0
"""Sharpness that stands for an ideal elasto-plastic spring in the law of Bouc and Wen: its force at
the yield drift is within 3.5 % of the yield force."""

EDGE = 1e-9
"""A dead band that ends nearer to the rest than this share of its width ends at the rest."""

STOP = 1e6
"""Slope of a stop's law, over the least that bears on it [N/m or N m/rad]: a stop's stiffness is a
constraint solver's and has no place in a linear model; so steep, it cannot be overlooked."""


@dataclass(frozen=True)
class NonlinearElement:
    """One element's force beyond its slope at rest.

    Attributes:
        element: what it is in the MJCF ("joint storey2", "tendon cable", "actuator drive").
        port: the port it acts along, or the channel; empty for an element without a name.
        mechanism: its name in the vocabulary; empty where that has none.
        values: the mechanism's parameter values, SI.
        words: what it is, with its numbers.
        law: force that opposes a displacement from rest and its rate, beyond the slope at rest
            [N or N m], of arrays (samples,); None for what is no force along a port.
        limit: largest magnitude that an actuator passes on or a sensor reads; infinite without.
    """

    element: str
    port: str
    mechanism: str
    values: Mapping[str, float]
    words: str
    law: Law | None = None
    limit: float = field(default=np.inf)

    def __str__(self) -> str:
        return f"{self.element}: {self.words}"


@dataclass(frozen=True)
class _Spring:
    """A spring of a joint or tendon: polynomial beyond a band of lengths, and where it yields."""

    k: tuple[float, float, float]
    low: float
    high: float
    rest: float
    yields: float

    def force(self, length: Array | float) -> Array:
        x = length - np.clip(length, self.low, self.high)
        return np.asarray(self.k[0] * x + self.k[1] * x**2 + self.k[2] * x**3)

    def slope(self) -> float:
        x = self.rest - np.clip(self.rest, self.low, self.high)
        bears = self.low == self.high or x != 0
        return float(self.k[0] + 2 * self.k[1] * x + 3 * self.k[2] * x**2) if bears else 0.0

    def law(self, drift: Array, rate: Array) -> Array:
        """Force beyond the slope; a yielding spring as on its first loading."""
        if self.yields:
            drift_held = np.clip(self.rest + drift, -self.yields, self.yields) - self.rest
            return np.asarray(self.k[0] * (drift_held - drift))
        linear = self.force(self.rest) + self.slope() * drift
        return np.asarray(self.force(self.rest + drift) - linear)


def structural_elements(
    model: mujoco.MjModel, data: mujoco.MjData, weights: bool = True
) -> Iterator[NonlinearElement]:
    """Yield the elements of a structure that are not linear about its rest.

    Args:
        model: as it was compiled.
        data: at rest.
        weights: whether what hangs on a joint counts, a matter of geometry.
    """
    heavy = (_weights,) if weights else ()
    for part in (_joints, _tendons, *heavy, _couplings, _surroundings):
        yield from part(model, data)


def _joints(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[NonlinearElement]:
    scalar = (int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE))
    for index in range(model.njnt):
        name, port = _named(model, _OBJ.mjOBJ_JOINT, index, "joint")
        dof, at = int(model.jnt_dofadr[index]), int(model.jnt_qposadr[index])
        if int(model.jnt_type[index]) not in scalar:
            if np.any(model.jnt_stiffnesspoly[index]) or np.any(model.dof_frictionloss[dof]):
                yield NonlinearElement(name, "", "", {}, "a ball or free joint that is not linear")
            continue
        ref = float(model.qpos_spring[at])
        spring = _Spring(
            _three(model.jnt_stiffness[index], model.jnt_stiffnesspoly[index]),
            *(ref, ref),
            float(data.qpos[at]),
            float(model.jnt_springyield[index]),
        )
        damping = model.dof_dampingpoly[dof]
        limits = model.jnt_range[index] if model.jnt_limited[index] else None
        yield from _along(name, port, spring, damping, model.dof_frictionloss[dof], limits)


def _tendons(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[NonlinearElement]:
    for index in range(model.ntendon):
        name, port = _named(model, _OBJ.mjOBJ_TENDON, index, "tendon")
        low, high = map(float, model.tendon_lengthspring[index])
        spring = _Spring(
            _three(model.tendon_stiffness[index], model.tendon_stiffnesspoly[index]),
            *(low, high),
            float(data.ten_length[index]),
            float(model.tendon_springyield[index]),
        )
        limits = model.tendon_range[index] if model.tendon_limited[index] else None
        damping, friction = model.tendon_dampingpoly[index], model.tendon_frictionloss[index]
        yield from _along(name, port, spring, damping, friction, limits)


def _along(
    name: str, port: str, spring: _Spring, damping: Array, friction: float, limits: Array | None
) -> Iterator[NonlinearElement]:
    if any(spring.k):
        yield from _of_spring(name, port, spring)
    square, cube = map(float, damping)
    if square:
        yield NonlinearElement(
            *(name, port, "quadratic_drag", {"coefficient": square}),
            f"damping c v|v| with c = {square:.4g}",
            lambda d, v: square * v * np.abs(v),
        )
    if cube:
        yield NonlinearElement(
            *(name, port, "", {}, f"damping c v^3 with c = {cube:.4g}"), lambda d, v: cube * v**3
        )
    if friction:
        force = float(friction)
        yield NonlinearElement(
            *(name, port, "coulomb_friction", {"force": force}, f"dry friction of {force:.4g}"),
            lambda d, v: force * np.sign(v),
        )
    if limits is not None:
        low, high = (float(end) - spring.rest for end in limits)
        slope = STOP * max(1.0, abs(spring.k[0]))
        yield NonlinearElement(
            *(name, port, "", {}, f"stops {low:.4g} and {high:.4g} from rest"),
            lambda d, v: slope * (d - np.clip(d, low, high)),
        )


def _of_spring(name: str, port: str, spring: _Spring) -> Iterator[NonlinearElement]:
    k, square, cube = spring.k
    low, high, law = spring.low - spring.rest, spring.high - spring.rest, spring.law

    def element(mechanism: str, values: dict[str, float], words: str) -> NonlinearElement:
        return NonlinearElement(name, port, mechanism, values, words, law)

    if spring.yields:
        words = f"a spring of {k:.4g} that yields at {spring.yields:.4g}"
        known = spring.low == spring.high == spring.rest and not (square or cube)
        values = {"stiffness": k, "yield_force": k * spring.yields, "sharpness": IDEAL}
        mechanism, values = ("hysteresis", values | {"replaced": k}) if known else ("", {})
        yield element(mechanism, values, words)
    elif spring.low == spring.high:
        even = square + 3 * cube * (spring.rest - spring.low)
        if abs(even) > EDGE * (abs(square) + abs(cube)):
            yield NonlinearElement(
                *(name, port, "quadratic_stiffness", {"stiffness": even}),
                f"a spring with {even:.4g} d^2 about its rest",
                lambda d, v: even * d**2,
            )
        if cube:
            yield NonlinearElement(
                *(name, port, "cubic_stiffness", {"stiffness": cube}),
                f"a spring with {cube:.4g} d^3",
                lambda d, v: cube * d**3,
            )
    else:
        words = f"a spring of {k:.4g} with a dead band from {low:.4g} to {high:.4g} from rest"
        inside = low < 0 < high and min(-low, high) > EDGE * (high - low)
        if not inside or square or cube:
            yield element("", {}, words)
        elif abs(low + high) < EDGE * (high - low):
            yield element("clearance", {"stiffness": k, "gap": high, "replaced": 0.0}, words)
        else:
            for gap, side in ((low, -1), (high, 1)):
                yield NonlinearElement(
                    *(name, port, "bumper", {"stiffness": k, "gap": gap}),
                    f"a spring of {k:.4g} that bears beyond {gap:.4g} from rest",
                    _stop(k, gap, side),
                )


def _stop(stiffness: float, gap: float, side: int) -> Law:
    return lambda d, v: stiffness * side * np.maximum(side * (d - gap), 0.0)


def _weights(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[NonlinearElement]:
    """Yield what the weight on a hinge does beyond its slope.

    The torque that it needs is P cos(d) + Q sin(d) exactly, as long as nothing else below or above
    turns. Where something does, the angles add up and no law of one hinge says it.
    """
    hinge = int(mujoco.mjtJoint.mjJNT_HINGE)
    turning = np.flatnonzero(model.jnt_type != int(mujoco.mjtJoint.mjJNT_SLIDE))
    if np.any(data.eq_active):
        return
    for index in turning:
        body = int(model.jnt_bodyid[index])
        others = [int(model.jnt_bodyid[other]) for other in turning if other != index]
        lines = any(other in _above(model, body) or body in _above(model, other)
                    for other in others)  # fmt: skip
        if int(model.jnt_type[index]) != hinge or lines:
            continue
        name, port = _named(model, _OBJ.mjOBJ_JOINT, int(index), "joint")
        even, odd = _torques(model, data, int(index))
        least = EDGE * model.body_subtreemass[body] * np.linalg.norm(model.opt.gravity)
        for mechanism, size, power, law in (
            ("quadratic_stiffness", -even / 2, 2, lambda d, v, p=even: p * (np.cos(d) - 1)),
            ("cubic_stiffness", -odd / 6, 3, lambda d, v, q=odd: q * (np.sin(d) - d)),
        ):
            if abs(size) > least:
                words = f"the weight on it, beyond its slope {size:.4g} d^{power}"
                yield NonlinearElement(name, port, mechanism, {"stiffness": size}, words, law)


def _above(model: mujoco.MjModel, body: int) -> set[int]:
    """Return a body and those that carry it."""
    out = {body}
    while body:
        body = int(model.body_parentid[body])
        out.add(body)
    return out


def _torques(model: mujoco.MjModel, data: mujoco.MjData, joint: int) -> tuple[float, float]:
    """Return the torque that holds the weight on a hinge at rest, and a quarter turn on [N m]."""
    moved = mujoco.MjData(model)
    found = []
    for angle in (0.0, np.pi / 2):
        moved.qpos[:] = data.qpos
        moved.qpos[model.jnt_qposadr[joint]] += angle
        mujoco.mj_forward(model, moved)
        found.append(float(moved.qfrc_bias[model.jnt_dofadr[joint]]))
    return found[0], found[1]


def _couplings(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[NonlinearElement]:
    kinds = (int(mujoco.mjtEq.mjEQ_JOINT), int(mujoco.mjtEq.mjEQ_TENDON))
    for index in range(model.neq):
        curved = np.any(model.eq_data[index, 2:5])
        if data.eq_active[index] and int(model.eq_type[index]) in kinds and curved:
            name, _ = _named(model, _OBJ.mjOBJ_EQUALITY, index, "equality")
            terms = ", ".join(f"{value:.4g}" for value in model.eq_data[index, 2:5])
            yield NonlinearElement(
                name, "", "", {}, f"a coupling with terms of second degree and more: {terms}"
            )


def _surroundings(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[NonlinearElement]:
    if model.opt.density or model.opt.viscosity:
        words = f"drag in a fluid of density {model.opt.density:.4g} kg/m^3"
        yield NonlinearElement("option", "", "", {}, words)
    if data.ncon:
        geoms = [
            mujoco.mj_id2name(model, _OBJ.mjOBJ_GEOM, int(g)) or f"geom {int(g)}"
            for g in data.contact[0].geom
        ]
        yield NonlinearElement("contact", "", "", {}, f"{' and '.join(geoms)} touch at rest")


def _named(model: mujoco.MjModel, kind: mujoco.mjtObj, index: int, what: str) -> tuple[str, str]:
    name = mujoco.mj_id2name(model, kind, index)
    return (f"{what} {name}", name) if name else (f"{what} {index + 1} (it has no name)", "")


def _three(first: float, more: Array) -> tuple[float, float, float]:
    return float(first), float(more[0]), float(more[1])
