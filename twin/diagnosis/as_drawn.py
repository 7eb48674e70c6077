"""Which law is worth a fit beside the twin as it is drawn, where the calibrated one is far from it.

A twin that lacks a strong law has moved far to stand for it, and no straight line leads back from
there (``twin.diagnosis.screening``). Beside the nominal twin a law shows in the simulation itself:
by how much nearer the recordings it is with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.drawing import far_off, with_tolerance
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import ROUGH, beginning_of
from twin.diagnosis.screening import directions_of
from twin.estimation.laws import no_memory
from twin.estimation.parallel import each
from twin.estimation.passing import run, silent, simulated
from twin.estimation.sensitivities import no_slopes, numbers_of, plants_of
from twin.mechanisms.mechanism import Law, Mechanism

Array = NDArray[np.float64]

STRONGER = 4.0
"""By which a first guess is made stronger while that brings the simulation nearer: guesses are made
for the motion of the calibrated twin, which has what is missing in its damping, and so for laws far
weaker than what it lacks; a fit finds a strength within a factor of four."""


@dataclass(frozen=True)
class Begun:
    """A hypothesis, where its fit begins, and what it promises.

    Attributes:
        hypothesis: with one more mechanism or several.
        z: values, (p,).
        gain: expected rise of the log likelihood [nat].
    """

    hypothesis: Hypothesis
    z: Array
    gain: float


def as_drawn(
    hypothesis: Hypothesis, z: Array, candidates: Sequence[Candidate], tolerance: float
) -> list[Begun]:
    """Return the nominal twin with each law that brings its simulation nearer to the recordings.

    The nearest first, each law with its best first guess. What is promised is the rise of the
    likelihood of the simulation's error, were it white. None where the calibrated twin is near its
    drawing, or something was found already.

    Args:
        hypothesis: what was fitted.
        z: its values, (p,).
        candidates: of any kind.
        tolerance: of the drawing, as the search began with it.
    """
    if hypothesis.mechanisms or not far_off(hypothesis.problem, z):
        return []
    drawn, nothing = with_tolerance(hypothesis, 0 * z, tolerance)
    short = beginning_of(drawn)
    before = _left(short, nothing)
    starts = [(c, law) for c in candidates for law in _weakest(c.starts)]

    def nearest(index: int) -> tuple[Law, float]:
        candidate, law = starts[index]
        best, strength = (law, 0.0), 1.0
        while True:
            start = law.scaled(strength)
            grown = added(short, candidate, start)
            gain = float(np.sum(before - _left(grown, moved_to(grown, short, nothing, start))))
            if strength > 1 and not gain > best[1] + ROUGH:
                return best
            best, strength = (start, gain), STRONGER * strength

    best = dict[tuple[str, str], Begun]()
    tried = each(nearest, len(starts))
    for (candidate, _), (start, found) in zip(starts, tried, strict=True):
        known = best.get(candidate.label)
        if np.isfinite(found) and found > (known.gain if known else 0.0):
            grown = added(drawn, candidate, start)
            best[candidate.label] = Begun(grown, moved_to(grown, drawn, nothing, start), found)
    return sorted(best.values(), key=lambda one: -one.gain)


def _weakest(starts: Sequence[Mechanism]) -> list[Law]:
    """Return first guesses of laws of which none is another one, only stronger: the weakest."""
    out = []
    for _, alike in directions_of(starts):
        for sign in (1, -1):
            along = [(abs(ratio), law) for law, ratio in alike if sign * ratio > 0]
            _, weakest = min(along, key=lambda one: one[0], default=(0.0, None))
            out += [weakest] if isinstance(weakest, Law) else []
    return out


def _left(hypothesis: Hypothesis, z: Array) -> Array:
    """Return minus the log likelihood of a simulation's error, of any level, (recordings, m)."""
    here = hypothesis.assemble(z)
    plants = plants_of(here, hypothesis)
    out = np.empty((len(here.trials), len(hypothesis.problem.model.outputs)))
    for index, trial in enumerate(here.trials):
        plant = plants[here.which[index]]
        n = len(plant.A)
        with np.errstate(all="ignore"):  # what runs away is told by its error
            if plant.driven is None:
                e = run(here, trial, plant, silent(plant)).e
            else:
                none = no_slopes(plant, silent(plant), numbers_of(here))
                e = simulated(plant, here, trial, np.zeros(n), np.zeros((n, 0)),
                              no_memory(here.laws), 0.0, none).e  # fmt: skip
            measured = np.sum(~np.isnan(trial.y), axis=0)
            out[index] = 0.5 * measured * np.log(np.sum(e**2, axis=0))
    return out
