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
from twin.model.motion import Motion
from twin.model.port import ground_inputs
from twin.model.twin import Twin
from twin.signals.low_pass import anti_alias, decimate

Array = NDArray[np.float64]

ALLOWED = 1.0
"""Largest difference over a channel's noise: there it doubles the variance of what is unexplained.
"""

NOTED = 0.1
"""Difference over the noise that is worth a note: it adds a hundredth to the variance."""

NOISE = 0.01
"""Noise of a channel as a share of its RMS where none is given."""

EXPLAINS = 0.1
"""An element is named where its effect is at least this share of the difference."""

SMALL = 0.01
"""Largest rotation [rad] to which inputs are scaled down to see whether a difference comes from
large motion; a tenth of the inputs where that is less."""


@dataclass(frozen=True)
class SelfCheck:
    """A prediction beside MuJoCo's simulation with the same inputs.

    Attributes:
        source: the model's name.
        differences: channel -> RMS of the difference over the RMS of the simulated channel.
        of_noise: channel -> RMS of the difference over the channel's noise.
        allowed: largest difference over the noise.
        cause: what makes the worst channel differ, a clause; empty where that is not worth a note.
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

    def __str__(self) -> str:
        text = (
            f"the equations miss MuJoCo's own motion at {self.worst} by "
            f"{100 * self.differences[self.worst]:.3g} % of its RMS, "
            f"{self.of_noise[self.worst]:.3g} times its noise"
        )
        return f"{text}: {self.cause}" if self.cause else text

    def require(self) -> None:
        """Raise ModelError, naming the element or mode, where the prediction is not MuJoCo's."""
        if not self.passed:
            raise ModelError(f"{self.source}: {self}")


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
    decimation: int = 1,
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
        allowed: how many times its noise a channel may differ.
        band_hz: as in ``Twin.linear``.
        decimation: factor by which an analyser decimates, behind its filter; differences are those
            of what it shows: a jump a little late is nothing there, and much as it is.

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
    if decimation > 1:
        rate_hz, low_pass = rate_hz / decimation, anti_alias(rate_hz / decimation, decimation)
        true, found = (decimate(x, decimation, low_pass) for x in (true, found))
        u = u[low_pass.reach :: decimation][: len(true)]
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
    if of_noise[worst] > min(allowed, NOTED):
        cause = _element(sized, share[worst]) or _geometry(
            twin, model, inputs, motion, rate_hz * decimation, float(share[worst])
        )
        cause = cause or _mode(model, difference[:, worst], rate_hz)
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


def _element(sized: Sequence[Effect], share: float) -> str:
    """Say which element makes the difference, or may do so as far as is known."""
    known = [effect for effect in sized if effect.share > EXPLAINS * share]
    unknown = [effect for effect in sized if np.isnan(effect.share)]
    return str([*known, *unknown][0]) if known or unknown else ""


def _geometry(
    twin: Twin,
    model: LinearModel,
    inputs: Mapping[str, Array],
    motion: Motion,
    rate_hz: float,
    share: float,
) -> str:
    """Say which joint turns too far, where the linear equations hold for gentler inputs."""
    name, turned = _largest_rotation(motion)
    if not turned:
        return ""
    factor = min(0.1, SMALL / turned)

    def missed(scale: float, moved: Motion) -> float:
        u = scale * np.column_stack(list(inputs.values()))
        true = np.column_stack([moved.column(output) for output in model.outputs])
        size = _rms(true - model.rest)
        off = _rms(linear_prediction(model, u, rate_hz) - true)
        return float(np.max(off / np.where(size > 0, size, np.inf)))

    scaled = {key: factor * np.asarray(values, float) for key, values in inputs.items()}
    gentle = missed(factor, simulated(twin, model, scaled, rate_hz))
    strong = missed(1.0, motion)
    apart = strong < EXPLAINS * share or share < EXPLAINS * strong  # what was predicted knows it
    if apart or gentle > strong / 2:
        return ""
    return (
        f"joint {name} turns by up to {turned:.3g} rad, too far for linear equations; at "
        f"{factor:.2g} of the inputs they miss {100 * gentle:.2g} %"
    )


def _mode(model: LinearModel, difference: Array, rate_hz: float) -> str:
    """Say at which mode a channel differs."""
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
