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
from .mechanisms import Mechanism, build
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
    measured = recording.matrix([f"acc_floor{i + 1}" for i in range(case.rig.storeys)])
    force = _force(case, test, recording)
    given = (
        _free(case, test, _between(case, force)),
        _ahead(case, test, measured, _on_floors(case, test, _between(case, force))),
        _free(case, test, _between(case, _before_filter(case, force)), case.chain),
    )
    outputs = np.sum(measured**2)
    return np.array([[np.sum((one - measured) ** 2), outputs] for one in given])


def _force(case: Case, test: Test, recording: Recording) -> Array:
    """Return the measured force [N], a known gain taken out."""
    name = f"force_floor{test.floor}"
    if case.mechanism.name == "sensor_gain" and case.mechanism.location == name:
        return recording.column(name) / case.mechanism["gain"]
    return recording.column(name)


def _between(case: Case, force: Array) -> Array:
    """Return the force between its samples, as the chain defines it: band-limited or linear."""
    count = (len(force) - 1) * STEPS + 1
    if case.chain.fine:
        return np.asarray(resample_poly(force, STEPS, 1, window=("kaiser", 8.0))[:count])
    return np.interp(np.arange(count) / STEPS, np.arange(len(force)), force)


def _on_floors(case: Case, test: Test, force: Array) -> Array:
    return np.outer(force, np.eye(case.rig.storeys)[test.floor - 1])


def _before_filter(case: Case, force: Array) -> Array:
    """Return the force as it was before the anti-alias filter, where that lets enough through."""
    padded = np.pad(force, PAD)
    response = case.chain.response(np.arange(len(padded) // 2 + 1) * SAMPLING_HZ / len(padded))
    spectrum = np.fft.rfft(padded)
    passed = np.abs(response) > PASSED
    spectrum[passed] /= response[passed]
    spectrum[~passed] = 0
    return np.asarray(np.fft.irfft(spectrum, len(padded))[PAD:-PAD])


def _free(case: Case, test: Test, force: Array, chain: Chain | None = None) -> Array:
    """Return the true model's outputs at the samples, from rest, through a chain if given."""
    rate = STEPS * SAMPLING_HZ
    seen, _ = simulate(build(case.rig, case.mechanism), _on_floors(case, test, force), 1 / rate)
    given = at_sensor(seen, case.mechanism, rate)
    return (chain.filtered(given, rate) if chain is not None else given)[::STEPS]


def _ahead(case: Case, test: Test, measured: Array, forces: Array) -> Array:
    """Return the accelerations as predicted in windows, each from the state before it."""
    m = case.mechanism
    system = _with_hidden_force(build(case.rig, m), case)
    clean, channels = _undone(measured, m)
    states = _states(case, test, system, measured, clean, channels, forces)
    length = round(WINDOW_S * SAMPLING_HZ)
    lag = int(np.ceil(m["delay"] * SAMPLING_HZ)) if m.name == "sensor_delay" else 0
    predicted = np.empty_like(measured)
    for first in range(0, len(measured), length):
        last = min(first + length, len(measured))
        start = max(first - lag, 0)
        pieces = slice(start * STEPS, (last - 1) * STEPS + 1)
        seen, _ = simulate(
            system, forces[pieces], 1 / (STEPS * SAMPLING_HZ), states[start], start / SAMPLING_HZ
        )
        if m.name == "sensor_highpass":
            whole = np.vstack([clean[:start], seen[::STEPS]])
            given = at_sensor(whole, m, SAMPLING_HZ)[start:]
        else:
            given = at_sensor(seen, m, STEPS * SAMPLING_HZ)[::STEPS]
        predicted[first:last] = given[first - start :]
    return predicted


def _with_hidden_force(system: System, case: Case) -> System:
    """Return the system with the oscillator that stands for an unmeasured force, if there is one.

    Its displacement is the force [N] (of a floor) or the acceleration [m/s^2] (of the ground).
    """
    m = case.mechanism
    if m.name != "unmeasured_force":
        return system
    n, omega = len(system.mass), 2 * np.pi * m["frequency"]
    columns, rows = np.zeros((3, n + 1)), np.zeros((2, n + 1))
    if m.location == "ground":
        columns[0, :n] = case.rig.masses
        columns[2, :n] = 1.0
    else:
        columns[0, m.index] = -1.0
    columns[0, n] = rows[0, n] = omega**2
    columns[1, n] = rows[1, n] = 2 * DAMPED[m.form] * omega
    return enlarged(system, 1.0, columns, rows)


def _undone(measured: Array, m: Mechanism) -> tuple[Array, Array]:
    """Return measured accelerations less what can be undone, and what each channel sees."""
    clean, channels = measured.copy(), np.eye(measured.shape[1])
    if m.name == "sensor_delay":
        clean[:, m.index] = delayed(measured[:, m.index], -m["delay"], SAMPLING_HZ)
    elif m.name == "sensor_highpass":
        clean[:, m.index] = highpass(measured[:, m.index], m["corner"], SAMPLING_HZ, inverse=True)
    elif m.name == "sensor_clipping":
        pass  # the filter leaves the clipped samples out
    elif m.in_sensor:  # gain, polarity, swap: what the sensors give of each floor's unit motion
        channels = at_sensor(channels, m).T
    return clean, np.ascontiguousarray(channels)


def _states(
    case: Case, test: Test, system: System, measured: Array, clean: Array, channels: Array,
    forces: Array,
) -> Array:  # fmt: skip
    """Return the states before each sample, the stated noise levels given."""
    m, n, interval = case.mechanism, len(system.mass), 1 / SAMPLING_HZ
    floor = test.floor - 1
    of_force = case.chain.noise * np.sqrt(np.mean(forces[::STEPS] ** 2))
    of_output = case.chain.noise * np.sqrt(np.mean(measured**2, axis=0))
    passed = channels[:, floor] * of_force / system.mass[floor]
    variance = np.tile(of_output**2 + passed**2, (len(measured), 1))
    if m.name == "sensor_clipping":
        lost = np.abs(measured[:, m.index]) >= CLIPPED * m["level"]
        variance[lost, m.index] *= UNKNOWN
    process, initial = np.zeros((2, 2 * n + 1))
    process[n : 2 * n] = (1e-3 * interval * np.sqrt(np.mean(measured**2))) ** 2
    process[n + floor] += (interval * of_force / system.mass[floor]) ** 2
    initial[: 2 * n] = 1e-16
    if m.name == "unmeasured_force":
        omega, last = 2 * np.pi * m["frequency"], n - 1
        initial[last], initial[n + last] = m["rms"] ** 2, (omega * m["rms"]) ** 2
        process[n + last] = 4 * DAMPED[m.form] * omega**3 * m["rms"] ** 2 * interval
    if m.name == "hysteresis":
        process[2 * n] = (1e-4 * m["yield_force"]) ** 2
    stride = STEPS // FILTER_STEPS
    step = interval / FILTER_STEPS
    return states_before(
        system, forces[::stride], FILTER_STEPS, step, clean, variance, channels, process, initial
    )
