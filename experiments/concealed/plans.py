"""Test plans: hammer, shaker and multisine recordings at several levels, on several floors."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from .rig import Array

SAMPLING_HZ = 256.0
FINE = 16
"""Steps of the integrator in one sampling interval."""

FINE_HZ = SAMPLING_HZ * FINE
BAND_HZ = (0.5, 15.0)
PEAK_N = (3.0, 20.0)
RMS_N = (0.1, 1.5)
FADE_S = 0.5

PER_NEWTON, PER_NEWTON_SHOCK = 0.5, 0.08
"""Ground accelerations [m/s^2] that move the frame about as far as a newton on a floor does."""

SHOCK_WIDTH = 8.0
"""A shock of the ground lasts longer than a hammer's hit by this."""


@dataclass(frozen=True)
class Test:
    """One recording: what drives which floor, how hard, for how long.

    Attributes:
        name: of the file, "train_1".
        kind: hammer, random or multisine; shocks where the ground is shaken.
        floor: from 1; 0 for the ground.
        level: middle peak of the hits [N], or RMS [N]; of the ground in m/s^2.
        duration_s: length [s].
        seed: of the excitation.
    """

    __test__ = False

    name: str
    kind: str
    floor: int
    level: float
    duration_s: float
    seed: int

    @property
    def samples(self) -> int:
        """Number of samples at 256 Hz."""
        return round(self.duration_s * SAMPLING_HZ)

    @property
    def input(self) -> str:
        """Name of the recorded channel that drives."""
        return f"force_floor{self.floor}" if self.floor else "acc_ground"

    def as_json(self) -> dict[str, Any]:
        """Return plain types."""
        return asdict(self)


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw from [low, high], evenly in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_plan(rng: np.random.Generator, floors: int) -> tuple[Test, ...]:
    """Return four training and two test recordings.

    Training holds every kind, every floor (up to four) and both halves of the range of levels;
    the tests are one hammer and one shaker, inside the range of levels of their kind.
    """
    kinds = ["hammer", "random", "multisine", ("hammer", "random")[rng.integers(2)]]
    first = int(rng.integers(floors))
    where = [1 + (i + first) % floors for i in range(4)]
    high = np.array([True, False, True, False])
    order = rng.permutation(4)
    kinds = [kinds[i] for i in order]
    high = high[rng.permutation(4)]
    tests = [
        _test(rng, f"train_{i + 1}", kinds[i], where[i], (0.55, 1.0) if high[i] else (0.0, 0.45))
        for i in range(4)
    ]
    last = rng.permutation(floors)[:2] + 1
    last = last if len(last) == 2 else np.array([1, 1])
    tests.append(_test(rng, "test_1", "hammer", int(last[0]), (0.2, 0.8)))
    tests.append(_test(rng, "test_2", "random", int(last[1]), (0.2, 0.8)))
    return tuple(tests)


def _test(
    rng: np.random.Generator, name: str, kind: str, floor: int, part: tuple[float, float]
) -> Test:
    """Draw a test whose level stands in that part of its range, evenly in the logarithm."""
    low, high = np.log((5.0, 16.0) if kind == "hammer" else RMS_N)
    level = float(np.exp(low + (high - low) * rng.uniform(*part)))
    duration = rng.integers(24 * 4, 30 * 4 + 1) / 4
    return Test(name, kind, floor, level, float(duration), int(rng.integers(2**31)))


def on_ground(plan: tuple[Test, ...]) -> tuple[Test, ...]:
    """Return the plan with the ground shaken instead of a floor, levels in m/s^2.

    Shocks take the place of hits: half-sines of 40 to 120 ms.
    """
    return tuple(
        replace(
            test, kind="shocks" if test.kind == "hammer" else test.kind, floor=0,
            level=test.level * (PER_NEWTON_SHOCK if test.kind == "hammer" else PER_NEWTON),
        )
        for test in plan
    )  # fmt: skip


@lru_cache(maxsize=8)
def waveform(test: Test, fine: bool) -> Array:
    """Return the force [N] or the ground's acceleration [m/s^2] on the integrator's grid.

    It is read-only, and kept: the drawing of strengths asks for it again and again.

    Args:
        test: what drives.
        fine: made on the fine grid; else at 256 Hz, and linear between these samples.
    """
    rng = np.random.default_rng(test.seed)
    rate = FINE_HZ if fine else SAMPLING_HZ
    count = (test.samples - 1) * (FINE if fine else 1) + 1
    time = np.arange(count) / rate
    if test.kind in ("hammer", "shocks"):
        drive = _hits(rng, test, time)
    else:
        drive = _random(rng, time) if test.kind == "random" else _multisine(rng, time)
        drive *= np.minimum(time / FADE_S, 1.0)
        drive *= test.level / np.sqrt(np.mean(drive**2))
    if not fine:
        drive = np.interp(np.arange((count - 1) * FINE + 1) / FINE_HZ, time, drive)
    drive.setflags(write=False)
    return np.asarray(drive)


def _hits(rng: np.random.Generator, test: Test, time: Array) -> Array:
    force, at = np.zeros(len(time)), rng.uniform(0.5, 1.5)
    side = rng.choice([-1.0, 1.0])
    while at < test.duration_s - 2.0:
        width = rng.uniform(0.006, 0.014)
        peak = test.level * rng.uniform(0.6, 1.3)
        if test.kind == "shocks":
            width *= SHOCK_WIDTH
        else:
            peak = np.clip(peak, *PEAK_N)
        inside = (time > at) & (time < at + width)
        force[inside] += side * peak * np.sin(np.pi * (time[inside] - at) / width)
        at += rng.uniform(2.5, 8.0)
    return force


def band_limited(
    rng: np.random.Generator, count: int, rate: float, low: float, high: float
) -> Array:
    """Return Gaussian noise between two frequencies [Hz], RMS one."""
    spectrum = np.fft.rfft(rng.standard_normal(count))
    frequency = np.fft.rfftfreq(count, 1 / rate)
    spectrum[(frequency < low) | (frequency > high)] = 0
    noise = np.fft.irfft(spectrum, count)
    return np.asarray(noise / np.sqrt(np.mean(noise**2)))


def _random(rng: np.random.Generator, time: Array) -> Array:
    return band_limited(rng, len(time), 1 / (time[1] - time[0]), *BAND_HZ)


def _multisine(rng: np.random.Generator, time: Array) -> Array:
    lines = np.arange(np.ceil(BAND_HZ[0] * 8), BAND_HZ[1] * 8 + 1) / 8
    phases = rng.uniform(0, 2 * np.pi, len(lines))
    total = np.zeros(len(time))
    for line, phase in zip(lines, phases, strict=True):
        total += np.sin(2 * np.pi * line * time + phase)
    return total
