"""What the true rig with its true parameters reaches when the measured forces drive it.

That is the floor under every explanation: the measured force is noisy and known at its samples
only, and impacts magnify the little that is missing. An unmeasured force is unknown to the free
run; two seconds ahead it goes on as the oscillator that a filter has estimated (undamped for a
sine, damped for a random force).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import resample_poly

from twin.formats import read_recording
from twin.recording import Recording

from .case import Case, from_truth
from .chain import Chain, at_sensor, delayed, highpass
from .integrator import simulate
from .laws import inner_limit
from .mechanisms import build
from .motions import loads
from .observer import states_before
from .plans import SAMPLING_HZ, Test
from .rig import Array, System, enlarged

STEPS = 8
"""Steps of the integrator in one sampling interval."""

FILTER_STEPS = 4
"""The same, within the filter."""

WINDOW_S = 2.0
CLIPPED = 0.97
"""Samples beyond this share of the clipping level tell a filter nothing."""

PAD = 512
PASSED = 0.25
"""The filter is undone where it lets this share through."""

UNKNOWN = 1e6
DAMPED = {"sine": 0.0, "narrow": 0.15, "broad": 0.7}
"""Damping ratio of the oscillator that stands for an unmeasured force."""


def reference(truth: dict[str, Any], folder: Path, kind: str = "test") -> dict[str, float]:
    """Return the true model's NRMSE, pooled over channels and recordings.

    Args:
        truth: opened.
        folder: of the case's recordings.
        kind: "test" or "train".

    Returns:
        ``fit``, running free from rest, and ``fit_ahead``, over windows of two seconds, each from
        the state estimated from the samples before it. Both take the recording at its word: the
        anti-alias filter is unknown. ``fit_through_chain`` runs free too, but knows the filter:
        the force before it is recovered, the accelerations pass through it. Dry friction's
        jumps make the difference.
    """
    case = from_truth(truth)
    sums = np.zeros((3, 2))
    for test in case.plan:
        if test.name.startswith(kind):
            recording = read_recording(folder / case.name / f"{test.name}.csv")
            sums += residuals(case, test, recording)
    found = np.sqrt(sums[:, 0] / sums[:, 1])
    return dict(zip(("fit", "fit_ahead", "fit_through_chain"), map(float, found), strict=True))


def residuals(case: Case, test: Test, recording: Recording) -> Array:
    """Return the sums of squares of residual and output, a row each for free, ahead, chain."""
    measured = recording.matrix([f"acc_floor{floor}" for floor in case.recorded])
    drive = _drive(case, test, recording)
    given = (
        _free(case, test, _between(case, drive)),
        _ahead(case, test, measured, _between(case, drive)),
        _free(case, test, _between(case, _before_filter(case, drive)), case.chain),
    )
    outputs = np.sum(measured**2)
    return np.array([[np.sum((one - measured) ** 2), outputs] for one in given])


def _drive(case: Case, test: Test, recording: Recording) -> Array:
    """Return the measured force [N] or ground acceleration [m/s^2], a known gain taken out."""
    gains = [m["gain"] for m in case.effects
             if m.name == "sensor_gain" and m.location == test.input]  # fmt: skip
    return np.asarray(recording.column(test.input) / np.prod(gains))


def _between(case: Case, force: Array) -> Array:
    """Return the force between its samples, as the chain defines it: band-limited or linear."""
    count = (len(force) - 1) * STEPS + 1
    if case.chain.fine:
        return np.asarray(resample_poly(force, STEPS, 1, window=("kaiser", 8.0))[:count])
    return np.interp(np.arange(count) / STEPS, np.arange(len(force)), force)


def _before_filter(case: Case, force: Array) -> Array:
    """Return the force as it was before the anti-alias filter, where that lets enough through."""
    padded = np.pad(force, PAD)
    response = case.chain.response(np.arange(len(padded) // 2 + 1) * SAMPLING_HZ / len(padded))
    spectrum = np.fft.rfft(padded)
    passed = np.abs(response) > PASSED
    spectrum[passed] /= response[passed]
    spectrum[~passed] = 0
    return np.asarray(np.fft.irfft(spectrum, len(padded))[PAD:-PAD])


def _columns(case: Case) -> Array:
    return np.array(case.recorded) - 1


def _free(case: Case, test: Test, drive: Array, chain: Chain | None = None) -> Array:
    """Return the true model's outputs at the samples, from rest, through a chain if given."""
    rate = STEPS * SAMPLING_HZ
    system = build(case.rig, *case.effects)
    seen, _ = simulate(system, loads(system, test, drive), 1 / rate)
    given = at_sensor(_with_ground(test, drive, seen), *case.effects, rate=rate)
    return (chain.filtered(given, rate) if chain is not None else given)[::STEPS, _columns(case)]


def _with_ground(test: Test, drive: Array, seen: Array) -> Array:
    """Return the absolute accelerations where the ground is shaken."""
    return seen + drive[:, None] if test.floor == 0 else seen


def _ahead(case: Case, test: Test, measured: Array, drive: Array) -> Array:
    """Return the accelerations as predicted in windows, each from the state before it."""
    system = _with_hidden_force(build(case.rig, *case.effects), case)
    forces = loads(system, test, drive)
    clean, channels = _undone(case, measured)
    ground = drive[::STEPS, None] * channels.sum(axis=1) if test.floor == 0 else 0.0
    states = _states(case, test, system, measured, clean - ground, channels, drive, forces)
    length = round(WINDOW_S * SAMPLING_HZ)
    late = case.has("sensor_delay")
    lag = int(np.ceil(late["delay"] * SAMPLING_HZ)) if late else 0
    predicted = np.empty_like(measured)
    for first in range(0, len(measured), length):
        last = min(first + length, len(measured))
        start = max(first - lag, 0)
        pieces = slice(start * STEPS, (last - 1) * STEPS + 1)
        seen, _ = simulate(
            system, forces[pieces], 1 / (STEPS * SAMPLING_HZ), states[start], start / SAMPLING_HZ
        )
        seen = _with_ground(test, drive[pieces], seen)
        if case.has("sensor_highpass"):
            before = np.zeros((start, seen.shape[1]))
            before[:, _columns(case)] = clean[:start]
            whole = np.vstack([before, seen[::STEPS]])
            given = at_sensor(whole, *case.effects, rate=SAMPLING_HZ)[start:]
        else:
            given = at_sensor(seen, *case.effects, rate=STEPS * SAMPLING_HZ)[::STEPS]
        predicted[first:last] = given[first - start :, _columns(case)]
    return predicted


def _with_hidden_force(system: System, case: Case) -> System:
    """Return the system with the oscillator that stands for an unmeasured force, if there is one.

    Its displacement is the force [N] (of a floor) or the acceleration [m/s^2] (of the ground).
    """
    m = case.has("unmeasured_force")
    if m is None:
        return system
    n, omega = len(system.mass), 2 * np.pi * m["frequency"]
    columns, rows = np.zeros((3, n + 1)), np.zeros((2, n + 1))
    if m.location == "ground":
        columns[0, : case.rig.storeys] = case.rig.masses
        columns[2, : case.rig.storeys] = 1.0
    else:
        columns[0, m.index] = -1.0
    columns[0, n] = rows[0, n] = omega**2
    columns[1, n] = rows[1, n] = 2 * DAMPED[m.form] * omega
    return enlarged(system, 1.0, columns, rows)


def _undone(case: Case, measured: Array) -> tuple[Array, Array]:
    """Return measured accelerations less what can be undone, and what each channel sees."""
    clean, floors = measured.copy(), np.eye(case.rig.storeys)
    for m in case.effects:
        if not m.in_sensor or m.location.startswith("force_"):
            continue
        if m.name == "sensor_delay":
            at = case.recorded.index(m.index + 1)
            clean[:, at] = delayed(measured[:, at], -m["delay"], SAMPLING_HZ)
        elif m.name == "sensor_highpass":
            at = case.recorded.index(m.index + 1)
            clean[:, at] = highpass(measured[:, at], m["corner"], SAMPLING_HZ, inverse=True)
        elif m.name != "sensor_clipping":  # the filter leaves clipped samples out
            # gain, polarity, swap: what the sensors give of each floor's unit motion
            floors = at_sensor(floors, m)
    return clean, np.ascontiguousarray(floors.T[_columns(case)])


def _states(
    case: Case, test: Test, system: System, measured: Array, clean: Array, channels: Array,
    drive: Array, forces: Array,
) -> Array:  # fmt: skip
    """Return the states before each sample, the stated noise levels given."""
    n, interval = len(system.mass), 1 / SAMPLING_HZ
    of_output = case.chain.noise * np.sqrt(np.mean(measured**2, axis=0))
    # what the noise of the input does to each velocity in a second; shaken, the whole frame is one
    noisy = case.chain.noise * np.sqrt(np.mean(drive[::STEPS] ** 2))
    pushed = np.abs(loads(system, test, np.ones(1))[0])
    pushed = noisy * np.pad(pushed, (0, n - len(pushed))) / system.mass
    passed = channels[:, test.floor - 1] * pushed[test.floor - 1] if test.floor else 0.0
    variance = np.tile(of_output**2 + passed**2, (len(measured), 1))
    clipping = case.has("sensor_clipping")
    if clipping is not None:
        at = case.recorded.index(clipping.index + 1)
        lost = np.abs(measured[:, at]) >= CLIPPED * clipping["level"]
        variance[lost, at] *= UNKNOWN
    process, initial = np.zeros((2, system.size))
    process[n : 2 * n] = (1e-3 * interval * np.sqrt(np.mean(measured**2))) ** 2
    process[n : 2 * n] += (interval * pushed) ** 2
    initial[: 2 * n] = 1e-16
    unknown = case.has("unmeasured_force")
    if unknown is not None:
        omega, last, rms = 2 * np.pi * unknown["frequency"], n - 1, unknown["rms"]
        initial[last], initial[n + last] = rms**2, (omega * rms) ** 2
        process[n + last] = 4 * DAMPED[unknown.form] * omega**3 * rms**2 * interval
    if system.slip >= 0:
        code, parameters = system.laws[system.slip, 0], system.parameters[system.slip]
        most = [inner_limit(code, parameters, i) for i in range(system.inner)]
        process[2 * n :] = (1e-4 * np.array(most)) ** 2
    stride = STEPS // FILTER_STEPS
    step = interval / FILTER_STEPS
    return states_before(
        system, forces[::stride], FILTER_STEPS, step, clean, variance, channels, process, initial
    )
