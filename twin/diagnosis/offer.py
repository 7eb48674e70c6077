"""Every mechanism of the vocabulary at every place where the structure can have it.

Faults that are read off the samples (``read_off``) are not among them: nothing of them is fitted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.candidates import Candidate, priors_of, surroundings
from twin.diagnosis.motion import Motion
from twin.diagnosis.problem import Problem
from twin.estimation.passing import Run
from twin.mechanisms import places, vocabulary
from twin.mechanisms.mechanism import ChannelFault, Law, Mechanism

Array = NDArray[np.float64]

PEAKS = 3
"""Frequencies of the innovations' spectrum that are offered as first guesses of a frequency."""

SEGMENT_S = 8.0
"""Length of the spectrum's segments [s]: an eighth of a hertz apart, a lightly damped mode wide."""


def offer(
    problem: Problem, kinds: Mapping[str, str]
) -> Callable[[Sequence[Motion], Sequence[Run]], list[Candidate]]:
    """Return what makes the candidates, given motion and innovations of every recording.

    Args:
        problem: the estimation problem.
        kinds: channel -> quantity.
    """
    channels = {name: kinds.get(name, "other") for name in problem.model.inputs} | {
        name: kinds[name] for name in problem.model.outputs
    }
    by_class = {
        cls: places(cls, problem.model, channels)
        for cls in vocabulary().values()
        if not issubclass(cls, ChannelFault) or cls.fitted
    }

    def candidates(moved: Sequence[Motion], runs: Sequence[Run]) -> list[Candidate]:
        peaks = peaks_of(runs, problem.sampling_hz)

        @cache
        def around(place: str):  # type: ignore[no-untyped-def]
            return surroundings(problem, moved, place, _height(problem, place), peaks)

        out = []
        for cls, there in by_class.items():
            for place in there:
                if issubclass(cls, Law) and cls.shares and not _held(problem, place):
                    continue  # where no spring is, none can slip or have play
                candidate = _candidate(cls, place, around(place))
                if candidate is not None and _has_a_model(candidate.starts[0], problem):
                    out.append(candidate)
        return out

    return candidates


def _candidate(cls: type[Mechanism], place: str, around) -> Candidate | None:  # type: ignore[no-untyped-def]
    starts = cls.starts(place, around)
    sound = [s for s in starts if all(np.isfinite(v) for v in s.values.values())]
    return Candidate(tuple(sound), priors_of(sound)) if sound else None


def _has_a_model(mechanism: Mechanism, problem: Problem) -> bool:
    """Return whether what an instrument of inputs does can be taken back from what they read.

    One that passes nothing at once, or mixes inputs with outputs, cannot.
    """
    driven = set(problem.model.inputs)
    if not isinstance(mechanism, ChannelFault) or driven.isdisjoint(mechanism.channels):
        return True
    instrument = mechanism.instrument(0.0)
    through = np.eye(1) if instrument is None else instrument.D
    return driven.issuperset(mechanism.channels) and np.linalg.matrix_rank(through) == len(through)


def _held(problem: Problem, place: str) -> bool:
    """Return whether a spring holds a port: its motion along no free mode alone."""
    row = problem.model.port(place)
    return float(row @ problem.model.K @ row) > 0


def _height(problem: Problem, place: str) -> float:
    port = problem.model.ports.get(place)
    return 1.0 if port is None else port.height


def peaks_of(runs: Sequence[Run], rate_hz: float) -> tuple[float, ...]:
    """Return the frequencies at which the innovations stand out most [Hz], the strongest first."""
    total = np.zeros(0)
    frequencies = np.zeros(0)
    if not runs:
        return ()
    length = min(round(SEGMENT_S * rate_hz), *(len(run.e) for run in runs))
    for run in runs:
        noise = np.sqrt(np.diagonal(run.gains.innovation[-1]))
        frequencies, density = signal.welch(run.e / noise, rate_hz, nperseg=length, axis=0)
        whole = np.sum(density, axis=1)
        total = whole if not len(total) else total + whole
    places_at, _ = signal.find_peaks(total)
    strongest = sorted(places_at, key=lambda i: -total[i])[:PEAKS]
    return tuple(float(frequencies[i]) for i in strongest if frequencies[i] > 0)
