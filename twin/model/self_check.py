"""Whether a prediction of a model's motion is MuJoCo's own, and if not, what makes it differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError
from twin.model.amplitudes import Effect, effects
from twin.model.contents import nonlinear_elements
from twin.model.free_run import free_run
from twin.model.linear import LinearModel
from twin.model.port import ground_inputs
from twin.model.twin import Motion, Twin

Array = NDArray[np.float64]

ALLOWED = 0.1
"""Largest difference as a share of a channel's noise: it adds half a per cent to the variance."""

NOISE = 0.01
"""Noise of a channel as a share of its RMS where none is given."""

TURNS = 0.1
"""A joint is named where the error of taking its sine for its angle is this share of the whole."""


@dataclass(frozen=True)
class SelfCheck:
    """A prediction beside MuJoCo's simulation with the same inputs.

    Attributes:
        source: the model's name.
        differences: channel -> RMS of the difference over the RMS of the simulated channel.
        of_noise: channel -> RMS of the difference over the channel's noise.
        allowed: largest share of the noise.
        cause: what makes the worst channel differ, a clause; empty where nothing does.
        effects: what each nonlinear element changes by itself, the largest first.
    """

    source: str
    differences: Mapping[str, float]
    of_noise: Mapping[str, float]
    allowed: float
    cause: str
    effects: tuple[Effect, ...]

    @property
    def worst(self) -> str:
        """The channel that differs most, in terms of its noise."""
        return max(self.of_noise, key=lambda name: self.of_noise[name])

    @property
    def passed(self) -> bool:
        """Whether every channel is predicted within the allowed share of its noise."""
        return self.of_noise[self.worst] <= self.allowed

    def require(self) -> None:
        """Raise ModelError, naming the element or mode, where the prediction is not MuJoCo's."""
        if not self.passed:
            raise ModelError(
                f"{self.source}: the equations miss MuJoCo's own motion at {self.worst} by "
                f"{100 * self.differences[self.worst]:.3g} % of its RMS, "
                f"{self.of_noise[self.worst]:.3g} times its noise: {self.cause}"
            )


def self_check(
    twin: Twin,
    inputs: Mapping[str, Array],
    outputs: Sequence[str],
    rate_hz: float,
    *,
    noise: Mapping[str, float] | None = None,
    predicted: Mapping[str, Array] | None = None,
    allowed: float = ALLOWED,
    band_hz: float | None = None,
) -> SelfCheck:
    """Simulate a model with measured inputs and compare a prediction from rest.

    Args:
        twin: the model.
        inputs: actuator, "acc_ground" or "acc_ground.x", ... -> samples, linear in between.
        outputs: sensors, as ``Twin.linear`` takes them.
        rate_hz: samples per second.
        noise: channel -> standard deviation, SI; a hundredth of the channel's RMS where not given.
        predicted: channel -> samples, of an engine that knows more than the linear equations; the
            linear free run where None.
        allowed: share of the noise by which a channel may differ.
        band_hz: as in ``Twin.linear``.

    Raises:
        ModelError: no rest, a rest that is not stable, no such channel, or a motion that diverges.
    """
    model = twin.linear(tuple(inputs), outputs, band_hz)
    _stable(model, twin.source)
    u = np.column_stack([np.asarray(values, float) for values in inputs.values()])
    motion = simulated(twin, model, inputs, rate_hz)
    true = np.column_stack([motion.column(name) for name in outputs])
    if predicted is None:
        found = linear_prediction(model, u, rate_hz)
    else:
        found = np.column_stack([predicted[name] for name in outputs])
    difference = found - true
    size = _rms(true - model.rest)
    share = _rms(difference) / np.where(size > 0, size, np.inf)
    level = [(noise or {}).get(name, NOISE * rms) for name, rms in zip(outputs, size, strict=True)]
    of_noise = np.array(
        [
            d / n if n > 0 else (np.inf if d > 0 else 0.0)
            for d, n in zip(_rms(difference), level, strict=True)
        ]
    )
    sized = effects(model, nonlinear_elements(twin.compile()), u, rate_hz)
    worst = int(np.argmax(of_noise))
    cause = ""
    if of_noise[worst] > allowed:
        cause = _cause(model, sized, motion, difference[:, worst], share[worst], rate_hz)
    return SelfCheck(
        twin.source,
        dict(zip(outputs, map(float, share), strict=True)),
        dict(zip(outputs, map(float, of_noise), strict=True)),
        allowed,
        cause,
        sized,
    )


def simulated(
    twin: Twin, model: LinearModel, inputs: Mapping[str, Array], rate_hz: float
) -> Motion:
    """Simulate a twin in MuJoCo with inputs as ``model`` has them."""
    shaken = ground_inputs(tuple(inputs), model.base)
    columns = list(inputs.values())
    ground = {axis: np.asarray(columns[at], float) for axis, at in shaken.items()}
    forces = {
        name: np.asarray(values, float)
        for index, (name, values) in enumerate(inputs.items())
        if index not in shaken.values()
    }
    return twin.simulate(forces, rate_hz, len(columns[0]), ground or None)


def linear_prediction(model: LinearModel, inputs: Array, rate_hz: float) -> Array:
    """Return the linear free run, sensors of absolute position reading with a shaken ground's."""
    found = free_run(model, inputs, rate_hz)
    for axis, column in ground_inputs(model.inputs, model.base).items():
        base = model.base[axis]
        a, step = inputs[:, column], 1 / rate_hz
        slope = np.diff(a)
        v = np.concatenate([[0.0], np.cumsum(step * (a[:-1] + slope / 2))])
        moved = step * v[:-1] + step**2 * (a[:-1] / 2 + slope / 6)
        x = np.concatenate([[0.0], np.cumsum(moved)])
        found = found + np.outer(x, base.disp) + np.outer(v, base.vel)
    return np.asarray(found)


def _stable(model: LinearModel, source: str) -> None:
    stiffness = np.linalg.eigvals(np.linalg.solve(model.M, model.K)).real
    lowest = int(np.argmin(stiffness))
    if stiffness[lowest] < -1e-9 * np.max(np.abs(stiffness)):
        raise ModelError(
            f"{source}: the rest is not stable, a push grows e-fold in "
            f"{1 / np.sqrt(-stiffness[lowest]):.3g} s: {_mover(model, lowest)} gives way"
        )


def _mover(model: LinearModel, mode: int) -> str:
    """Name the joint or tendon that moves most in a coordinate, else the port."""
    drifts = {n: p for n, p in model.ports.items() if p.kind == "drift"} or model.ports
    if not drifts:
        return "the structure"
    port = max(drifts.values(), key=lambda p: abs(p.row[mode]) / np.linalg.norm(p.row))
    return port.element


def _cause(
    model: LinearModel,
    sized: Sequence[Effect],
    motion: Motion,
    difference: Array,
    share: float,
    rate_hz: float,
) -> str:
    """Say what makes a channel differ: an element, a rotation, or the mode it differs at."""
    if sized and (np.isnan(sized[0].share) or sized[0].share > TURNS * share):
        return str(sized[0])
    name, turned = _largest_rotation(motion)
    if turned**2 / 6 > TURNS * min(share, 1.0):
        return f"joint {name} turns by up to {turned:.3g} rad, too far for linear equations"
    without_law = [effect for effect in sized if np.isnan(effect.share)]
    if without_law:
        return str(without_law[0])
    power = np.abs(np.fft.rfft(difference - difference.mean())) ** 2
    at = float(np.fft.rfftfreq(len(difference), 1 / rate_hz)[int(np.argmax(power))])
    natural = np.sqrt(np.maximum(np.diag(model.K) / np.diag(model.M), 0)) / (2 * np.pi)
    mode = int(np.argmin(np.abs(natural - at)))
    return (
        f"the difference is largest at {at:.3g} Hz, near mode {mode + 1} ({natural[mode]:.4g} Hz), "
        f"in which {_mover(model, mode)} moves most"
    )


def _largest_rotation(motion: Motion) -> tuple[str, float]:
    """Return the hinge that turns most and its largest angle from the first sample [rad]."""
    best, model = ("", 0.0), motion.model
    for index in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE):
        angle = motion.qpos[:, model.jnt_qposadr[index]]
        turned = float(np.max(np.abs(angle - angle[0])))
        if turned > best[1]:
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, int(index))
            best = (name or f"{index + 1}", turned)
    return best


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
