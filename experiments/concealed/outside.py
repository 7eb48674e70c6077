"""Effects that no vocabulary names: strong enough that none of its mechanisms stands in for them.

Every mechanism of the vocabulary is laid beside the effect, at every place and over a grid of what
enters it nonlinearly, with all masses, stiffnesses and dampings free besides; the best of them must
leave many nats.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .columns import change, columns, frame
from .concealed import Concealed
from .likelihood import Left, Likelihood, nats
from .mechanisms import FLOOR, SENSOR, Mechanism
from .motions import Run
from .plans import log_uniform
from .rehearsal import Rehearsal
from .rig import Rig
from .strengths import Motion
from .tables import Combination

LEFT_NATS = 150.0
"""What the best mechanism of the vocabulary leaves, at least."""

LEFT_SHARE = 0.02
"""The same as a share of what the effect does beyond a calibration."""

VISIBLE = 5.0
"""The effect changes the outputs of some training recording by at least this many times noise."""

TRIES = 25
GAPS = np.geomspace(0.1, 0.95, 7)
"""Grid of gaps and yield drifts, as shares of the largest drift."""


def draw_one(
    rng: np.random.Generator, combination: Combination, rehearsal: Rehearsal
) -> Concealed | None:
    """Draw one effect that no mechanism of the vocabulary takes up."""
    likelihood = Likelihood(rehearsal)
    for _ in range(TRIES):
        effect = draw(rng, *combination[0], rehearsal.rig, rehearsal.scale)
        runs = rehearsal.moved([effect])
        if not rehearsal.physical(runs):
            continue
        shift = rehearsal.effect([effect], runs)
        if shift < VISIBLE * rehearsal.chain.noise:
            continue
        beyond, left, rival = weighed(likelihood, effect, runs)
        if left > max(LEFT_NATS, LEFT_SHARE * beyond):
            found = (("beyond_calibration_nats", beyond), (f"left_by_{rival}_nats", left))
            return Concealed((effect,), shift, found)
    return None


def weighed(
    likelihood: Likelihood, effect: Mechanism, runs: tuple[Run, ...]
) -> tuple[float, float, str]:
    """Return the nats beyond a calibration, those that the best rival leaves, and its name."""
    calibration = Left(frame(likelihood, runs))
    beyond = calibration.of(change(likelihood, [effect], runs))
    least, name = nats(beyond), "nothing"
    for rival in rivals(likelihood.rehearsal, runs):
        column = calibration.of(columns(likelihood, rival, runs))
        length = float(column @ column)
        left = nats(beyond) - float(column @ beyond) ** 2 / (2 * length) if length else least
        if left < least:
            least, name = left, rival.name
    return nats(beyond), least, name


def rivals(rehearsal: Rehearsal, runs: tuple[Run, ...]) -> Iterator[Mechanism]:
    """Yield the mechanisms of the vocabulary at every place, over their grids."""
    rig, n = rehearsal.rig, rehearsal.rig.storeys
    peaks = np.max([np.abs(s[:, :n] @ rig.drifts.T).max(axis=0) for _, s in runs], axis=0)
    for i, peak in enumerate(peaks):
        yield from _of_storey(f"storey{i + 1}", rig.stiffnesses[i], peak)
        floor = f"floor{i + 1}"
        yield Mechanism(FLOOR[1], floor, (("coefficient", 1.0),))
        for frequency in np.geomspace(1.0, 15.0, 8):
            small = (("mass", 0.01), ("frequency", float(frequency)), ("damping_ratio", 0.02))
            yield Mechanism("appendage", floor, small)
    yield Mechanism("base_compliance", "ground", (("stiffness", 1e5), ("damping", 0.0)))
    for floor_number in rehearsal.recorded:
        channel = f"acc_floor{floor_number}"
        for name, parameter, value in (
            (SENSOR[0], "gain", 1.1), (SENSOR[1], "delay", 0.004), (SENSOR[4], "corner", 0.3),
        ):  # fmt: skip
            yield Mechanism(name, channel, ((parameter, value),))
        largest = max(float(np.abs(seen[:, floor_number - 1]).max()) for seen, _ in runs)
        for share in GAPS[2:]:
            yield Mechanism("sensor_clipping", channel, (("level", float(share * largest)),))


def _of_storey(place: str, stiffness: float, peak: float) -> Iterator[Mechanism]:
    yield Mechanism("coulomb_friction", place, (("force", 1.0),))
    yield Mechanism("cubic_stiffness", place, (("stiffness", 1.0),))
    yield Mechanism("quadratic_stiffness", place, (("stiffness", 1.0),))
    yield Mechanism("stiffness_drift", place, (("rate", 1e-3),))
    for share in GAPS:
        gap = float(share * peak)
        yield Mechanism("clearance", place, (("gap", gap), ("stiffness", stiffness)))
        slip = (("stiffness", stiffness), ("yield_force", stiffness * gap))
        yield Mechanism("hysteresis", place, slip, "jenkins")
        for side in (-1, 1):
            yield Mechanism("bumper", place, (("gap", side * gap), ("stiffness", stiffness)))


def draw(rng: np.random.Generator, name: str, place: str, rig: Rig, motion: Motion) -> Mechanism:
    """Draw the strength of an effect outside the vocabulary."""
    i = int(place[-1]) - 1
    values = _values(rng, name, rig, motion, i)
    return Mechanism(name, place, tuple((k, float(v)) for k, v in values.items()))


def _values(
    rng: np.random.Generator, name: str, rig: Rig, motion: Motion, i: int
) -> dict[str, float]:
    k, d, largest = rig.stiffnesses[i], motion.drift[i], motion.largest[i]
    side = float(rng.choice([-1.0, 1.0]))
    if name == "tanh_spring":  # saturates well inside the motion
        return {"stiffness": k * rng.uniform(0.3, 1.5), "width": d * log_uniform(rng, 0.1, 0.5)}
    if name == "sine_spring":  # several detents inside the motion
        return {"stiffness": k * rng.uniform(0.2, 0.8), "width": d * log_uniform(rng, 0.1, 0.3)}
    if name == "exponential_spring":  # e times stiffer a third to a ninth of the way
        width = side * largest * rng.uniform(0.11, 0.33)
        return {"stiffness": k * log_uniform(rng, 0.02, 0.2), "width": width}
    if name == "magnet":  # poles repel, near where the storey turns back
        gap, exponent = side * largest * rng.uniform(0.75, 1.15), float(rng.choice([2.0, 3.0, 4.0]))
        slope = k * log_uniform(rng, 0.03, 0.3)  # of the linear part that is taken off
        return {"force": -slope * abs(gap) / exponent * side, "gap": gap, "exponent": exponent}
    if name in ("breathing_gap", "moving_stop"):
        stop = name == "moving_stop"
        return {
            "gap": d * (side * rng.uniform(0.4, 0.8) if stop else log_uniform(rng, 0.2, 0.6)),
            "stiffness": k * (log_uniform(rng, 2.0, 10.0) if stop else rng.uniform(0.3, 0.6)),
            "opening": rng.uniform(0.4, 0.8),
            "period": rng.uniform(8.0, 20.0),
            "phase": rng.uniform(0, 2 * np.pi),
        }
    return _of_cross_axis(rng, rig, motion, i)


def _of_cross_axis(rng: np.random.Generator, rig: Rig, motion: Motion, i: int) -> dict[str, float]:
    """Draw a mode of another axis near twice a mode of the frame, so that energy goes there."""
    omega = rig.modes[0]
    frequency = 2 * omega[rng.integers(min(2, len(omega)))] / (2 * np.pi) * rng.uniform(0.93, 1.07)
    mass = rig.masses[i] * rng.uniform(0.1, 0.3)
    stiffness = mass * (2 * np.pi * frequency) ** 2
    # the share of the storey's stiffness that the other axis takes when it follows at rest
    taken = rng.uniform(0.05, 0.4)
    coupling = np.sqrt(taken * rig.stiffnesses[i] * stiffness / 2) / motion.largest[i]
    return {
        "mass": mass, "frequency": frequency, "damping_ratio": log_uniform(rng, 0.005, 0.03),
        "coupling": coupling,
    }  # fmt: skip
