"""What a screening looks at: a fit, the motion behind it, and the candidates that it yields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit, covariances, gains_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import at_place
from twin.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]

PEAKS = 3
"""Frequencies at which what is unexplained stands out, at most."""


@dataclass(frozen=True)
class Candidate:
    """A mechanism at a place with first values, and the log likelihood that it promises to gain.

    Attributes:
        mechanism: with first values.
        gain: of the log likelihood.
        hypothesis: that of the scene with all parameters as they would move along.
    """

    mechanism: Mechanism
    gain: float
    hypothesis: Hypothesis | None = None

    @property
    def label(self) -> tuple[str, str]:
        """Mechanism and place."""
        return self.mechanism.name, self.mechanism.place


@dataclass(frozen=True)
class Scene:
    """What the screening starts from.

    Attributes:
        bench: with the forces of found laws as inputs.
        fit: of what was found before, on that bench.
        moved: smoothed states of every trial, (samples, n).
        heights: of the storeys [m].
    """

    bench: Bench
    fit: Fit
    moved: tuple[Array, ...]
    heights: Mapping[str, float]

    def peaks(self) -> tuple[float, ...]:
        """Return the frequencies at which the innovations stand out most [Hz]."""
        try:
            gains = gains_of(self.bench, self.fit.hypothesis, 1e-4)
        except np.linalg.LinAlgError:
            gains = self.fit.gains
        rows = self.bench.innovations([self.fit.hypothesis], gains, self.fit.starts)
        # one grid of frequencies for recordings of any length
        segment = min(2048, *(len(row[0]) for row in rows))
        total: list[Array] = []
        for row, S in zip(rows, covariances([r[0] for r in rows]), strict=True):
            e = row[0] / np.sqrt(np.diag(S))
            f, each = signal.welch(e, 1 / self.bench.step_s, nperseg=segment, axis=0)
            total.append(each.sum(axis=1))
        density = np.sum(total, axis=0)
        tops, _ = signal.find_peaks(density)
        tops = tops[np.argsort(-density[tops])][:PEAKS]
        return tuple(float(f[i]) for i in tops if f[i] > 0)

    def motion(self) -> dict[str, Array]:
        """Return the pooled motion: "storey1", "rate storey1", "floor1", ... -> (samples,)."""
        model = self.bench.model
        floors = [c for c in model.coordinates if c.startswith("floor")]
        places = [c.replace("floor", "storey") for c in floors] + list(model.coordinates)
        out = {}
        for place in places:
            pairs = [at_place(model, state, place) for state in self.moved]
            out[place] = np.concatenate([d for d, _ in pairs])
            out[f"rate {place}"] = np.concatenate([v for _, v in pairs])
        return out
