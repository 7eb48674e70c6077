"""What is worth a fit beside the twin as it is drawn, where the calibrated one is far from it.

A twin that lacks something strong has moved far to stand for it, and no straight line leads back
from there (``twin.diagnosis.screening``). Beside the nominal twin what is missing shows in the
simulation itself: by how much nearer the recordings it is with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.directions import directions_of
from twin.diagnosis.drawing import far_off, with_tolerance
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import ROUGH, beginning_of
from twin.diagnosis.valleys import FIRST, LAPS, Score, half_of_each
from twin.estimation.fit import LONGEST
from twin.estimation.kalman import silent
from twin.estimation.laws import no_memory
from twin.estimation.parallel import each
from twin.estimation.passing import run, simulated
from twin.estimation.sensitivities import STEP, no_slopes, numbers_of, plants_of
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism

Array = NDArray[np.float64]
_Value = tuple[float, Array, Mechanism]
"""Rise of the log likelihood, values and the first guess."""

STRONGER = 4.0
"""By which a law's first guess is made stronger while that brings the simulation nearer: guesses
are made for the motion of the calibrated twin, which has what is missing in its damping, and so for
laws far weaker than what it lacks; a fit finds a strength within a factor of four."""


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
) -> list[Score]:
    """Return each mechanism with which the nominal twin's simulation comes nearer, nearest first.

    What is promised is the rise of the likelihood of the simulation's error, were it white. None
    where the calibrated twin is near its drawing, or something was found already.

    Args:
        hypothesis: what was fitted.
        z: its values, (p,).
        candidates: of any kind; those that no simulation shows are passed over.
        tolerance: of the drawing, as the search began with it.
    """
    if hypothesis.mechanisms or not far_off(hypothesis.problem, z):
        return []
    drawn, nothing = with_tolerance(hypothesis, 0 * z, tolerance)
    short = _without_noise(beginning_of(drawn))
    followed = replace(short.problem, low_pass=None)
    before = _left(_errors(short, nothing))

    def with_it(candidate: Candidate, start: Mechanism) -> Hypothesis:
        grown = added(short, candidate, start)
        # what no jump is, is told from others by what it does, not by how a filter shows it
        return grown if grown.jumps else replace(grown, problem=followed)

    def begun(candidate: Candidate, start: Mechanism) -> _Value:
        grown = with_it(candidate, start)
        at = moved_to(grown, short, nothing, start)
        value = before - _left(_errors(grown, at))
        return value if np.isfinite(value) else -np.inf, at, start

    def first(index: int) -> _Value:
        laws = [law.scaled(STRONGER) for law in weakest[index]]
        options = (begun(shown[index], start) for start in laws or shown[index].starts)
        return max(options, key=lambda v: v[0])

    def strongest(index: int) -> _Value:
        candidate, best = shown[index], firsts[index]
        if not best[0] > 0:
            return max((begun(candidate, law) for law in weakest[index]), key=lambda v: v[0])
        while True:
            found = begun(candidate, best[2].scaled(STRONGER))
            if not found[0] > best[0] + ROUGH:
                return best
            best = found

    def nearest(index: int) -> Score | None:
        candidate, (gain, at, start) = shown[index], firsts[index]
        if index in ahead and weakest[index]:
            gain, _, start = strongest(index)
        elif index in ahead and np.isfinite(gain):
            grown = with_it(candidate, start)
            at, left = _nearer(grown, at)
            gain, start = before - left, grown.at(at)[-1]
        return Score(candidate, start, gain) if gain > 0 else None

    shown = [c for c in candidates if seen_in_simulation(c.starts[0])]
    weakest = [_weakest(c.starts) for c in shown]
    firsts = each(first, len(shown))
    # where it begins tells already which places of a mechanism are unlikely
    ahead = set(half_of_each([c.label[0] for c in shown], [value for value, _, _ in firsts]))
    found = [one for one in each(nearest, len(shown)) if one is not None]
    return sorted(found, key=lambda one: -one.gain)


def beside_the_drawing(hypothesis: Hypothesis, score: Score, tolerance: float) -> Begun:
    """Return the nominal twin with what was promising.

    Args:
        hypothesis: what was fitted.
        score: of ``as_drawn``.
        tolerance: of the drawing, as the search began with it.
    """
    drawn, z = with_tolerance(hypothesis, np.zeros(len(hypothesis.unknowns)), tolerance)
    grown = added(drawn, score.candidate, score.start)
    return Begun(grown, moved_to(grown, drawn, z, score.start), score.gain)


def seen_in_simulation(mechanism: Mechanism) -> bool:
    """Return whether a simulation shows a mechanism: not a force, or a reading, by chance."""
    if not isinstance(mechanism, ChannelFault):
        return not isinstance(mechanism, Disturbance)
    through = mechanism.instrument(1.0)
    if through is None or not through.G.size:
        return True
    return bool(np.any(through.B)) or not np.array_equal(through.D, np.eye(len(through.D)))


def _without_noise(hypothesis: Hypothesis) -> Hypothesis:
    """Return a hypothesis without the states of inputs' noise, which no simulation hears."""
    problem = hypothesis.problem
    recordings = tuple(replace(r, bands=()) for r in problem.recordings)
    return replace(hypothesis, problem=replace(problem, recordings=recordings))


def _weakest(starts: Sequence[Mechanism]) -> list[Law]:
    """Return first guesses of laws of which none is another one, only stronger: the weakest."""
    out = []
    for _, alike in directions_of(starts):
        for sign in (1, -1):
            along = [(abs(ratio), law) for law, ratio in alike if sign * ratio > 0]
            _, weakest = min(along, key=lambda one: one[0], default=(0.0, None))
            out += [weakest] if isinstance(weakest, Law) else []
    return out


def _nearer(hypothesis: Hypothesis, z: Array) -> tuple[Array, float]:
    """Return values, (p,), from which the last mechanism's own have moved, and what is left there.

    Gauss-Newton steps, damped where they do not climb, as many at most as short fits take.
    """
    last = hypothesis.mechanisms[-1]
    titles = {f"{last.name} {last.place} {name}" for name in last.parameters}
    own = [i for i, u in enumerate(hypothesis.unknowns) if u.name in titles]
    reach = np.array([LONGEST / u.deviation if u.log else LONGEST for u in hypothesis.unknowns])
    errors, damping = _errors(hypothesis, z), 1e-3
    value = _left(errors)
    for _ in range(FIRST + sum(LAPS) if own else 0):
        white = _whitened(errors, errors)
        columns = []
        for i in own:
            near = z.copy()
            near[i] += STEP
            columns.append((_whitened(_errors(hypothesis, near), errors) - white) / STEP)
        slopes = np.nan_to_num(np.column_stack(columns))
        H = slopes.T @ slopes + np.eye(len(own))
        delta = -np.linalg.solve(H + damping * np.diag(np.diag(H)), slopes.T @ white)
        if np.max(np.abs(delta)) < STEP:
            break
        delta /= max(1.0, float(np.max(np.abs(delta) / reach[own])))
        moved = z.copy()
        moved[own] += delta
        there = _errors(hypothesis, moved)
        gained = value - _left(there)
        if np.isfinite(gained) and gained > 0:
            z, errors, value, damping = moved, there, value - gained, damping / 10
            if gained < ROUGH:
                break
        else:
            damping *= 100
    return z, value


def _whitened(errors: Sequence[Array], of: Sequence[Array]) -> Array:
    """Return errors over the RMS of others of the same channels, (N,); what is unknown is zero."""
    pairs = zip(errors, of, strict=True)
    return np.concatenate([np.nan_to_num(e / np.sqrt(_power(o))).ravel() for e, o in pairs])


def _left(errors: Sequence[Array]) -> float:
    """Return minus the log likelihood of errors of any level, each (samples, m)."""
    return float(sum(0.5 * len(e) * np.sum(np.log(_power(e))) for e in errors))


def _power(errors: Array) -> Array:
    """Return the mean square of what was measured of each channel, (m,); 1 where nothing was."""
    measured = np.sum(~np.isnan(errors), axis=0)
    total = np.nansum(errors**2, axis=0)
    return np.asarray(np.where(total > 0, total / np.maximum(measured, 1), 1.0))


def _errors(hypothesis: Hypothesis, z: Array) -> list[Array]:
    """Return the simulation's error in each recording, (samples, m), NaN where none was measured.

    Infinite where there is no such twin.
    """
    try:
        here = hypothesis.assemble(z)
        plants = plants_of(here, hypothesis)
    except np.linalg.LinAlgError:
        return [np.full(trial.y.shape, np.inf) for trial in hypothesis.trials]
    out = []
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
        e = np.where(np.isfinite(e), e, np.inf)
        out.append(np.where(np.isnan(trial.y), np.nan, e))
    return out
