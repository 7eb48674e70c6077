"""The missing force against the motion: what a person would look at first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.bench import Bench
from twin.diagnosis.channels import corrected
from twin.diagnosis.fitting import Fit
from twin.diagnosis.motion import at_place, force_histories, states
from twin.diagnosis.plant import place_vector
from twin.diagnosis.result import Finding, ForcePicture
from twin.mechanisms.mechanism import Law

Array = NDArray[np.float64]

MOST_POINTS = 6000
GRID = 201
CYCLE_S = 3.0


def force_pictures(
    bench: Bench, nothing: Fit, places: Sequence[str], findings: Sequence[Finding]
) -> tuple[ForcePicture, ...]:
    """Return the force that the calibrated twin lacks at each place, against the motion there.

    The force is what the smoothed motion needs beyond the measured forces; it is low-passed at
    four times the highest natural frequency, above which there is only noise.
    """
    moved = states(bench, nothing)
    model = bench.model
    n = len(model.coordinates)
    needed = [_needed(bench, nothing, i, x) for i, x in enumerate(moved)]
    out = []
    for place in places:
        b = place_vector(model, place)
        pairs = [at_place(model, x, place) for x in moved]
        drift = np.concatenate([d for d, _ in pairs])
        rate = np.concatenate([v for _, v in pairs])
        latent = np.concatenate([-(w @ b) / (b @ b) for w in needed])
        thin = max(1, len(drift) // MOST_POINTS)
        laws = [f for f in findings if isinstance(f.mechanism, Law) and f.location == place]
        edge = 1.02 * float(np.max(np.abs(drift)))
        grid = np.linspace(-edge, edge, GRID)
        law = std = cycle = None
        if laws:
            law, std = _law(laws[0], grid)
            cycle = _cycle(laws[0], bench, pairs)
        out.append(
            ForcePicture(place, drift[::thin], rate[::thin], latent[::thin], grid, law, std, cycle)
        )
    assert n
    return tuple(out)


def _needed(bench: Bench, nothing: Fit, number: int, x: Array) -> Array:
    """Return the forces on the coordinates that the motion needs besides the measured, (N, n)."""
    trial = bench.trials[number]
    sound = corrected(trial, nothing.hypothesis.mechanisms)
    plant = bench.plant(trial, nothing.hypothesis.mechanisms)
    smooth = bench.smooth(sound.u)
    following = np.concatenate([smooth[1:], smooth[-1:]])
    foreseen = x @ plant.A.T + smooth @ plant.B0.T + following @ plant.B1.T
    rest = np.vstack([x[1:] - foreseen[:-1], np.zeros((1, x.shape[1]))])
    force = rest @ np.linalg.pinv(plant.G).T
    highest = float(np.max(plant.plant.model.undamped_modes().natural_freq))
    corner = min(4 * highest, 0.4 * trial.sampling_hz)
    sos = signal.butter(4, corner, fs=trial.sampling_hz, output="sos")
    return np.asarray(signal.sosfiltfilt(sos, force, axis=0))


def _law(finding: Finding, grid: Array) -> tuple[Array, Array]:
    """Return the law's force over the grid, at zero rate and memory, and its deviation."""
    law = finding.mechanism
    assert isinstance(law, Law)
    zero = np.zeros_like(grid)
    speed = zero + (1e-3 if law.name.endswith("friction") else 0.0)

    def force(item: Law) -> Array:
        if item.memory:
            z = zero.copy()
            middle = len(grid) // 2
            for k in range(middle, len(grid) - 1):
                z[k + 1] = item.remember(z[k], grid[k], grid[k + 1])
            for k in range(middle, 0, -1):
                z[k - 1] = item.remember(z[k], grid[k], grid[k - 1])
            return np.asarray(item.force(grid, speed, z, 0.0)) + zero
        return np.asarray(item.force(grid, speed, zero, 1.0)) + zero

    centre, spread = force(law), zero.copy()
    for name, std in finding.std.items():
        if np.isfinite(std) and std > 0:
            value = law.values[name]
            spread = spread + (force(law.with_values({name: value + std})) - centre) ** 2
    return centre, np.sqrt(spread)


def _cycle(finding: Finding, bench: Bench, pairs: Sequence[tuple[Array, Array]]) -> Array:
    """Return drift and force of the law along its liveliest few seconds."""
    law = finding.mechanism
    assert isinstance(law, Law)
    number = int(np.argmax([np.sqrt(np.mean(d**2)) for d, _ in pairs]))
    drift, rate = pairs[number]
    force = force_histories([law], [(drift, rate)], bench.step_s)[0][0]
    length = min(len(drift), round(CYCLE_S / bench.step_s))
    power = np.convolve(drift**2, np.ones(length), mode="valid")
    first = int(np.argmax(power))
    piece = slice(first, first + length)
    return np.column_stack([drift[piece], force[piece]])
