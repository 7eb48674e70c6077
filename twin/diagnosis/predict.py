"""Simulate a hypothesis from the measured forces: two seconds ahead, and what noise alone does.

The same equations as the MuJoCo twin's, stepped by the compiled filter with its gain at zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench, steps_for
from twin.diagnosis.channels import as_recorded, corrected, limits_of
from twin.diagnosis.filtering import Gain, with_laws
from twin.diagnosis.fitting import lenient_gains
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import laws_of
from twin.diagnosis.trials import Trial
from twin.mechanisms.mechanism import ChannelFault, Disturbance

Array = NDArray[np.float64]

WINDOW_S = 2.0
"""Length of the windows [s]."""


def _open(gain: Gain) -> Gain:
    """Return the gain that listens to nothing."""
    return Gain(0 * gain.filtered, 0 * gain.carried, gain.predicted, gain.innovation)


def _run(
    bench: Bench, hypothesis: Hypothesis, trial: Trial, gain: Gain, start: Array,
    memory: Array | None = None, begin_s: float = 0.0,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Return innovations, states and memories of one hypothesis on a sound trial."""
    laws = laws_of(hypothesis.mechanisms)
    steps = steps_for(laws, bench.plant(trial, hypothesis.mechanisms))
    plant = bench.plant(trial, hypothesis.mechanisms, steps)
    limits = limits_of(hypothesis.mechanisms, trial.outputs)[None]
    e, x, z = with_laws(
        [plant], gain, [laws], trial.u[None], bench.smooth(trial.u)[None], trial.y[None],
        start, limits, steps, bench.step_s, memory, begin_s, bench.held,
    )  # fmt: skip
    return e[0], x[0], z[0]


def _piece(trial: Trial, first: int, last: int) -> Trial:
    return replace(trial, u=trial.u[first:last], y=trial.y[first:last])


def filtered(
    bench: Bench, hypothesis: Hypothesis, slack: float, starts: Sequence[Array]
) -> list[tuple[Trial, Gain, Array, Array]]:
    """Return sound trial, gain, states x(k|k-1) and memories for every trial of the bench."""
    gains = lenient_gains(bench, hypothesis, slack)
    out = []
    for number, (trial, gain) in enumerate(zip(bench.trials, gains, strict=True)):
        sound = corrected(trial, hypothesis.mechanisms)
        start = np.zeros(len(gain.filtered)) if not starts else starts[number]
        _, x, z = _run(bench, hypothesis, sound, gain, start)
        out.append((sound, gain, x, z))
    return out


def ahead(
    bench: Bench, hypothesis: Hypothesis, slack: float, starts: Sequence[Array] = ()
) -> list[Array]:
    """Return the outputs as simulated in windows, each from the state estimated before it.

    Args:
        bench: trials.
        hypothesis: the fitted one.
        slack: force noise that the estimator assumes.
        starts: initial states, or rest.

    Returns:
        One (samples, m) a trial, as the instruments would record it.
    """
    out = []
    length = round(WINDOW_S / bench.step_s)
    for trial, (sound, gain, x, z) in zip(
        bench.trials, filtered(bench, hypothesis, slack, starts), strict=True
    ):
        predicted = np.empty_like(trial.y)
        for first in range(0, trial.samples, length):
            last = min(first + length, trial.samples)
            piece = _piece(sound, first, last)
            e, _, _ = _run(
                bench, hypothesis, piece, _open(gain), x[first], z[first], first * bench.step_s
            )
            predicted[first:last] = piece.y - e
        out.append(_recorded(trial, sound, predicted, hypothesis))
    return out


def from_rest(bench: Bench, hypothesis: Hypothesis, slack: float) -> list[Array]:
    """Return the outputs as simulated from rest over the whole recording, one (samples, m) each."""
    out = []
    for trial, gain in zip(bench.trials, lenient_gains(bench, hypothesis, slack), strict=True):
        sound = corrected(trial, hypothesis.mechanisms)
        rest = np.zeros(len(gain.filtered))
        e, _, _ = _run(bench, hypothesis, sound, _open(gain), rest)
        out.append(_recorded(trial, sound, sound.y - e, hypothesis))
    return out


def unmeasured(
    bench: Bench, hypothesis: Hypothesis, slack: float, starts: Sequence[Array] = ()
) -> dict[int, list[Array]]:
    """Return the disturbances as the recordings show them, one (samples,) a trial.

    By their index in ``found``; the first quarter, in which the filter finds them, is left out.
    """
    shapes: dict[int, tuple[int, Array]] = {}
    at = 2 * len(bench.plant(bench.trials[0], hypothesis.mechanisms).plant.model.coordinates)
    for mechanism in hypothesis.mechanisms:
        if isinstance(mechanism, Disturbance):
            shape = mechanism.shaping()[2]
            shapes[hypothesis.found.index(mechanism)] = at, shape
            at += len(shape)
        elif isinstance(mechanism, ChannelFault) and mechanism.filter_hz() is not None:
            at += 1
    if not shapes:
        return {}
    seen = [x[len(x) // 4 :] for _, _, x, _ in filtered(bench, hypothesis, slack, starts)]
    return {i: [x[:, p : p + len(c)] @ c for x in seen] for i, (p, c) in shapes.items()}


def strength_of(bench: Bench, hypothesis: Hypothesis, slack: float) -> dict[int, float]:
    """Return the RMS of every disturbance as the recordings show it, by its index in ``found``."""
    return {
        i: float(np.sqrt(np.mean(np.concatenate(histories) ** 2)))
        for i, histories in unmeasured(bench, hypothesis, slack).items()
    }


def _recorded(trial: Trial, sound: Trial, predicted: Array, hypothesis: Hypothesis) -> Array:
    """Take predictions of sound outputs back to what the faulty instruments record."""
    faults = [
        m
        for m in hypothesis.mechanisms
        if isinstance(m, ChannelFault) and m.filter_hz() is None and m.limit() is None
    ]
    columns = dict(zip(trial.outputs, predicted.T, strict=True))
    inputs = dict(zip(trial.inputs, sound.u.T, strict=True))
    for fault in faults:
        columns = {**columns, **fault.distort({**inputs, **columns}, trial.sampling_hz)}
    return np.column_stack([columns[name] for name in trial.outputs])


def nrmse(trials: Sequence[Trial], simulated: Sequence[Array]) -> float:
    """Return RMS of the residual over RMS of the output, pooled over channels and recordings."""
    error = float(np.sum(squared_errors(trials, simulated)))
    power = sum(float(np.sum(t.y**2)) for t in trials)
    return float(np.sqrt(error / power))


def squared_errors(trials: Sequence[Trial], simulated: Sequence[Array]) -> Array:
    """Return the squared residuals of every trial, summed over channels and samples, (trials,)."""
    return np.array([np.sum((t.y - s) ** 2) for t, s in zip(trials, simulated, strict=True)])


def noise_floors(
    bench: Bench, hypothesis: Hypothesis, slack: float, starts: Sequence[Array] = (), seed: int = 0
) -> tuple[float, float]:
    """Return the NRMSE that a perfect model would reach: free run, and two seconds ahead.

    The measured force is not the true one: another draw of its noise on top of it shows what that
    does to the simulated motion, with the motion's own sensitivity; in windows the state's
    uncertainty comes on top. The outputs' noise is added.
    """
    rng = np.random.default_rng(seed)
    length = round(WINDOW_S / bench.step_s)
    free = near = power = 0.0
    for trial, (sound, gain, x, z) in zip(
        bench.trials, filtered(bench, hypothesis, slack, starts), strict=True
    ):
        scale = as_recorded(trial, hypothesis.mechanisms)
        noise = float(np.sum(trial.output_noise**2)) * trial.samples
        shaken = _shaken(sound, rng)
        still = _open(gain)
        first = _run(bench, hypothesis, sound, still, x[0])[0]
        second = _run(bench, hypothesis, shaken, still, x[0])[0]
        free += float(np.sum(((first - second) * scale) ** 2)) + noise
        root = _root(gain.predicted)
        for begin in range(0, trial.samples, length):
            end = min(begin + length, trial.samples)
            blur = root @ rng.standard_normal(len(root)) if begin else 0 * x[0]
            at = begin * bench.step_s
            a = _run(bench, hypothesis, _piece(sound, begin, end), still, x[begin], z[begin], at)
            b = _run(
                bench, hypothesis, _piece(shaken, begin, end), still, x[begin] + blur, z[begin], at
            )
            near += float(np.sum(((a[0] - b[0]) * scale) ** 2))
        near += noise
        power += float(np.sum(trial.y**2))
    return float(np.sqrt(free / power)), float(np.sqrt(near / power))


def _shaken(trial: Trial, rng: np.random.Generator) -> Trial:
    return replace(trial, u=trial.u + rng.standard_normal(trial.u.shape) * trial.input_noise)


def _root(covariance: Array) -> Array:
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0)))
