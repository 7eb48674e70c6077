"""Which mechanism is worth a fit: the score test of every candidate in one pass.

That is a shortlist, not a verdict.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.candidates import Candidate
from twin.diagnosis.directions import directions_of, nearest
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.missing_force import along_motion
from twin.diagnosis.motion import Motion
from twin.diagnosis.portion import SURE
from twin.diagnosis.pull import pull_of
from twin.diagnosis.response import respond
from twin.diagnosis.score_test import ScoreTest
from twin.diagnosis.valleys import Score, first_of_each, of_valleys
from twin.estimation.fit import Fit
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange

Array = NDArray[np.float64]
_Direction = tuple[Candidate, Mechanism, list[tuple[Mechanism, float]]]
"""A candidate, a first guess, and those that are only stronger, with their strengths."""

BEYOND, SPACED = 2.0, 0.03
"""How far beyond the natural frequencies light resonances are looked for, and the steps of the
logarithm between them: a resonance with 2 % of damping is 4 % wide."""

REACH = 50.0
"""Greatest strength, as a multiple of a first guess, that a fit may start from: what is so much
stronger moves the structure in another way than the twin without it moved."""


@dataclass(frozen=True)
class Screened:
    """What small changes tell of every candidate, and what they do not tell.

    Attributes:
        candidates: all of them.
        test: the score test.
        scores: first guesses, those of a candidate in any order.
        valleys: candidates that promise something, and of which short fits tell more.
        hidden: those that may promise nothing although they are there.
        by_chance: whether chance may promise as much as the most promising does.
    """

    candidates: tuple[Candidate, ...]
    test: ScoreTest
    scores: tuple[Score, ...]
    valleys: tuple[Candidate, ...]
    hidden: tuple[Candidate, ...]
    by_chance: bool

    def best(self, more: Sequence[Score] = ()) -> list[Score]:
        """Return the best first guess of every candidate, the most promising first."""
        best = {c.label: Score(c, c.starts[0], 0.0) for c in self.candidates}
        for score in (*self.scores, *more):
            if score.gain > best[score.candidate.label].gain:
                best[score.candidate.label] = score
        return sorted(best.values(), key=lambda s: -s.gain)

    def followed(self, *asked: Candidate, more: Sequence[Score] = ()) -> list[Score]:
        """Return the same, with what short fits of the candidates tell that are asked for."""
        return self.best([*more, *of_valleys(self.test.fit, self.test.linear, asked)])


def screen(
    fit: Fit, hypothesis: Hypothesis, candidates: Sequence[Candidate], moved: Sequence[Motion]
) -> Screened:
    """Return what the score test tells of every candidate.

    Args:
        fit: the present one.
        hypothesis: what was fitted.
        candidates: what may be added to it.
        moved: the motion of each recording.
    """
    test = ScoreTest(hypothesis, fit)
    laws = [(c, s) for c in candidates for s in c.starts if isinstance(s, Law)]
    scores = _of_laws(test, laws, moved) + _of_pulls(test, candidates, moved)
    least = float(np.log(max(len(candidates), 2)))
    directions, valleys, shifting = list[_Direction](), list[Candidate](), list[Candidate]()
    promised, ways = list[float](), dict[tuple[str, str], float]()
    for candidate in candidates:
        first = candidate.starts[0]
        if isinstance(first, Law):
            continue
        if first.shifts_resonance:
            shifting.append(candidate)
        elif isinstance(first, Disturbance) or not first.parameters:
            # a force that nobody measured changes the innovations' covariance alone; what is there
            # or not has no strength
            rises = [test.whole(candidate, start) for start in candidate.starts]
            promised.append(max(rises))
            if promised[-1] > least:
                likelier = np.argsort(rises)[len(rises) // 2 :]
                kept = tuple(candidate.starts[i] for i in sorted(likelier))
                valleys.append(replace(candidate, starts=kept))
        elif isinstance(first, ChannelFault) and first.ranged:
            # what only adds to a channel changes the covariance as well
            rises = [test.whole(candidate, start) for start in candidate.starts]
            at = int(np.argmax(rises))
            scores.append(Score(candidate, candidate.starts[at], max(rises[at], 0.0)))
        elif first.valleys == 1 and (freed := _freed(test, candidate, first)) is not None:
            scores.append(freed)
        else:
            several = directions_of(candidate.starts)
            directions += [(candidate, *alike) for alike in several]
            ways[candidate.label] = float(np.log(len(several)))
    promising, flat = (dict[tuple[str, str], list[Mechanism]]() for _ in range(2))
    told = test.along([(candidate, first) for candidate, first, _ in directions])
    for (candidate, first, alike), found in zip(directions, told, strict=True):
        if found is None:
            continue
        gain, strength, shift = found
        if first.valleys == 1:
            scores += [_scaled(test, candidate, start, gain, strength / ratio, shift * ratio)
                       for start, ratio in alike]  # fmt: skip
            continue
        # one of several directions has a part of the odds of all of them
        gain -= candidate.width(first.scaled(strength), gain) + ways[candidate.label]
        promised.append(gain)
        if gain > least:
            promising.setdefault(candidate.label, []).extend(nearest(alike, strength))
        else:
            flat.setdefault(candidate.label, []).extend(start for start, _ in alike)
    for candidate in candidates:
        if candidate.label in promising:
            valleys.append(replace(candidate, starts=tuple(promising[candidate.label])))
    if not hypothesis.laws:  # with laws they would be followed beside laws that are held
        valleys += _followed([s for s in scores if s.candidate.label not in promising], least)
    most = max([*promised, *(score.gain for score in scores)], default=0.0)
    # no small change tells of a resonance that comes from where there is none, nor of a delay to
    # which the twin has adjusted itself; but where it matters, something nearer does not fit either
    silent = [c for c in candidates if c.label in flat and c.label not in promising]
    beyond = [*shifting, *(replace(c, starts=tuple(flat[c.label])) for c in silent)]
    hidden = beyond if most > least else []
    by_chance = most < least + SURE
    return Screened(
        tuple(candidates), test, tuple(scores), tuple(valleys), tuple(hidden), by_chance
    )


def _followed(scores: Sequence[Score], least: float) -> list[Candidate]:
    """Return changes of the structure that short fits follow: the likeliest places of each.

    A twin that lacks one has moved far to stand for it: straight lines tell of less than there is.
    """
    worth = dict[tuple[str, str], Score]()
    for score in sorted(scores, key=lambda score: -score.gain):
        if score.gain > least and isinstance(score.start, StructuralChange):
            worth.setdefault(score.candidate.label, score)
    told = list(worth.values())
    first = first_of_each([name for name, _ in worth])
    return [replace(told[i].candidate, starts=(told[i].start,)) for i in first]


def _of_laws(
    test: ScoreTest, pairs: Sequence[tuple[Candidate, Law]], moved: Sequence[Motion]
) -> list[Score]:
    if not pairs:
        return []
    hypothesis = test.hypothesis
    problem = hypothesis.problem

    def changes(index: int, some: slice) -> Array:
        rows = np.array([problem.model.port(law.place) for _, law in pairs[some]])
        forces = [along_motion(law, problem, moved[index]) for _, law in pairs[some]]
        return respond(test.runs[index], hypothesis, rows, np.column_stack(forces))

    gains, strengths, shifts = test.of_changes(changes, len(pairs))
    return [
        _scaled(test, c, s, float(g), float(a), d)
        for (c, s), g, a, d in zip(pairs, gains, strengths, shifts.T, strict=True)
    ]


def _of_pulls(
    test: ScoreTest, candidates: Sequence[Candidate], moved: Sequence[Motion]
) -> list[Score]:
    """Return what has a resonance of its own and is weak, at all frequencies."""
    problem = test.hypothesis.problem
    inside = problem.frequencies[problem.frequencies > 0]
    inside = inside[inside < problem.sampling_hz / 2]
    if not len(inside):
        return []
    low, high = inside[0] / BEYOND, min(inside[-1] * BEYOND, problem.sampling_hz / 2)
    grid = np.geomspace(low, high, int(np.log(high / low) / SPACED) + 2)[:-1].tolist()
    firsts = ((c, c.starts[0]) for c in candidates)
    changes = [(c, s.scaled(1 / REACH)) for c, s in firsts if isinstance(s, StructuralChange)]
    pairs = [(c, light) for c, weak in changes for light in weak.light(grid)]
    if not pairs:
        return []
    model = problem.base(test.fit.z[: len(problem.base_unknowns)])
    motion = [replace(m, a=m.acceleration(problem.step_s)) for m in moved]
    there = [(light.edit(model), model.port(light.place)) for _, light in pairs]

    def responses(index: int, some: slice) -> Array:
        rows = np.array([row for _, row in there[some]])
        pulls = [pull_of(grown, model, row, motion[index], problem.step_s)
                 for grown, row in there[some]]  # fmt: skip
        return respond(test.runs[index], test.hypothesis, rows, np.column_stack(pulls))

    gains, strengths, shifts = test.of_changes(responses, len(pairs))
    best = dict[tuple[str, str], int]()
    for k, (candidate, _) in enumerate(pairs):
        if strengths[k] > 0 and gains[k] >= gains[best.get(candidate.label, k)]:
            best[candidate.label] = k
    return [
        _scaled(test, *pairs[k], float(gains[k]), float(strengths[k]), shifts[:, k])
        for k in best.values()
    ]


def _scaled(
    test: ScoreTest, candidate: Candidate, start: Mechanism, gain: float, strength: float,
    shift: Array,
) -> Score:  # fmt: skip
    if not np.isfinite(gain) or strength <= 0:
        return Score(candidate, start, 0.0)
    if strength > REACH:
        ratio = REACH / strength
        gain *= 2 * ratio - ratio**2
        strength = REACH
    moved = dict(zip(test.names, (strength * shift).tolist(), strict=True))
    begun = start.scaled(strength)
    return Score(candidate, begun, gain - candidate.width(begun, gain), moved)


def _freed(test: ScoreTest, candidate: Candidate, start: Mechanism) -> Score | None:
    """Return what freeing a parameter of the twin from its prior brings, if it is one.

    The twin's own goes back towards its mean, and the change takes its place.
    """
    name = f"{start.name} {start.place}"
    for unknown in test.hypothesis.unknowns:
        if unknown.name == name:
            (parameter,) = start.parameters
            nominal = unknown.value(0.0)
            wide = candidate.priors[parameter][1] / (unknown.deviation * nominal)
            gain, strength, shift = test.freed(name, wide)
            change = unknown.value(strength) - nominal
            moved = dict(zip(test.names, (strength * shift).tolist(), strict=True))
            begun = start.with_values({parameter: change})
            return Score(candidate, begun, gain - candidate.width(begun, gain), moved)
    return None
