"""Test plans on any structure: hits, one or several shakers, a shaken ground, a drive's motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..plans import FADE_S, FINE, FINE_HZ, SAMPLING_HZ, band_limited
from .structure import Array


@dataclass(frozen=True)
class Kit:
    """What a table's tests are made of.

    Attributes:
        band_hz: of shakers.
        peak_n: of the hits.
        rms_n: of each shaker.
        ground: RMS of a shaken ground's acceleration [m/s^2].
        axes: along which the ground is shaken; none for no such test.
        softness: how much longer a hit lasts than that of a hard tip on a frame (6 to 14 ms).
        substeps: of the integrator in a step of its grid.
        loop: stiffness and damping of a position loop, for a drive; None for force tests.
    """

    band_hz: tuple[float, float]
    peak_n: tuple[float, float]
    rms_n: tuple[float, float]
    ground: tuple[float, float] = (0.1, 0.6)
    axes: tuple[str, ...] = ()
    softness: float = 1.0
    substeps: int = 1
    loop: tuple[float, float] | None = None


@dataclass(frozen=True)
class Trial:
    """One recording.

    Attributes:
        name: of the file, "train_1".
        kind: hammer, random, multisine, ground or motion (a drive follows a path).
        inputs: actuators that act, or axes of the shaken ground; each with a signal of its own.
        level: peak [N], RMS [N] or [m/s^2], or largest travel [m].
        duration_s: length [s].
        seed: of the signals.
    """

    name: str
    kind: str
    inputs: tuple[str, ...]
    level: float
    duration_s: float
    seed: int

    @property
    def fine_samples(self) -> int:
        """Samples on the integrator's grid."""
        return (round(self.duration_s * SAMPLING_HZ) - 1) * FINE + 1

    def as_json(self) -> dict[str, Any]:
        """Return plain types."""
        return {**asdict(self), "inputs": list(self.inputs)}

    @classmethod
    def from_json(cls, entry: dict[str, Any]) -> Trial:
        """Undo ``as_json``."""
        return cls(**{**entry, "inputs": tuple(entry["inputs"])})


def draw_trials(rng: np.random.Generator, kit: Kit, drives: Sequence[str]) -> tuple[Trial, ...]:
    """Return four training and two test recordings.

    Training holds hits, shakers alone and together, both halves of the levels and, where the
    ground can be shaken, one such recording; the tests are hits and shakers.
    """
    if kit.loop is not None:
        kinds = ["motion"] * 6
    else:
        kinds = ["hammer", "random", "multisine", "ground" if kit.axes else "random"]
        kinds = [kinds[i] for i in rng.permutation(4)] + ["hammer", "random"]
    high = rng.permutation([True, False, True, False])
    trials = []
    for i, kind in enumerate(kinds):
        part = (0.2, 0.8) if i > 3 else (0.55, 1.0) if high[i] else (0.0, 0.45)
        name = f"train_{i + 1}" if i < 4 else f"test_{i - 3}"
        trials.append(_trial(rng, kit, tuple(drives), name, kind, part))
    return tuple(trials)


def _trial(
    rng: np.random.Generator, kit: Kit, drives: tuple[str, ...], name: str, kind: str,
    part: tuple[float, float],
) -> Trial:  # fmt: skip
    if kind == "hammer":
        inputs, levels = (str(rng.choice(drives)),), kit.peak_n
    elif kind == "ground":
        inputs, levels = (str(rng.choice(kit.axes)),), kit.ground
    elif kind == "motion":
        inputs, levels = drives, (0.05, 0.2)
    else:
        count = int(rng.integers(1, len(drives) + 1)) if kind == "random" else len(drives)
        chosen = sorted(rng.permutation(len(drives))[:count])
        inputs, levels = tuple(drives[i] for i in chosen), kit.rms_n
    low, high = np.log(levels)
    level = float(np.exp(low + (high - low) * rng.uniform(*part)))
    return Trial(name, kind, inputs, level, float(rng.integers(20, 25)), int(rng.integers(2**31)))


@lru_cache(maxsize=12)
def signals(trial: Trial, kit: Kit) -> Array:
    """Return what drives on the integrator's grid, (samples, inputs); read-only.

    Forces [N] or ground accelerations [m/s^2]; for a drive the path [m].
    """
    rng = np.random.default_rng(trial.seed)
    time = np.arange(trial.fine_samples) / FINE_HZ
    columns = []
    for _ in trial.inputs:
        if trial.kind == "hammer":
            columns.append(_hits(rng, trial, kit, time))
        elif trial.kind == "motion":
            columns.append(_path(rng, trial, time))
        else:
            columns.append(_shaking(rng, trial, kit, time))
    found = np.column_stack(columns)
    found.setflags(write=False)
    return found


def _hits(rng: np.random.Generator, trial: Trial, kit: Kit, time: Array) -> Array:
    force, at = np.zeros(len(time)), rng.uniform(0.5, 1.5)
    side = rng.choice([-1.0, 1.0])
    while at < trial.duration_s - 2.0:
        width = kit.softness * rng.uniform(0.006, 0.014)
        peak = trial.level * rng.uniform(0.6, 1.3)
        inside = (time > at) & (time < at + width)
        force[inside] += side * peak * np.sin(np.pi * (time[inside] - at) / width)
        at += rng.uniform(2.5, 6.0)
    return force


def _shaking(rng: np.random.Generator, trial: Trial, kit: Kit, time: Array) -> Array:
    low, high = kit.band_hz
    if trial.kind == "multisine":
        lines = np.arange(np.ceil(low * 8), high * 8 + 1) / 8
        phases = rng.uniform(0, 2 * np.pi, len(lines))
        force = np.zeros(len(time))
        for line, phase in zip(lines, phases, strict=True):
            force += np.sin(2 * np.pi * line * time + phase)
    else:
        force = band_limited(rng, len(time), FINE_HZ, low, high)
    force *= np.minimum(time / FADE_S, 1.0)
    return np.asarray(force * trial.level / np.sqrt(np.mean(force**2)))


def _path(rng: np.random.Generator, trial: Trial, time: Array) -> Array:
    """Return smooth moves between random places, with rests: fifth-order steps."""
    path, place, at = np.zeros(len(time)), 0.0, rng.uniform(0.3, 0.8)
    while at < trial.duration_s - 1.0:
        target = trial.level * rng.uniform(-1.0, 1.0)
        length = max(rng.uniform(0.5, 2.0), 0.3)
        s = np.clip((time - at) / length, 0.0, 1.0)
        path += (target - place) * s**3 * (10 - 15 * s + 6 * s**2)
        place, at = target, at + length + rng.uniform(0.0, 0.8)
    return path
