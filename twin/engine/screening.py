"""Which mechanism is worth a fit: the score test of every candidate in one pass (Rao 1948).

A candidate of small strength changes the innovations along a direction c. With the present fit's
slopes projected out, s = c^T e and I = c^T c (both whitened), the log likelihood would rise by
s^2 / (2 I) at the strength s / I. That is a shortlist, not a verdict.
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.engine.beginning import added, moved_to
from twin.engine.candidates import Candidate
from twin.engine.hypothesis import Hypothesis
from twin.engine.problem import Motion
from twin.engine.response import force_along, respond
from twin.engine.valleys import Score, of_valleys
from twin.estimation.fit import Fit
from twin.estimation.likelihood import Value, evaluate, gaussian
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism

Array = NDArray[np.float64]

SMALL = 1e-4
"""Strength, as a share of a first guess, at which a linear candidate's direction is taken."""

REACH = (0.02, 50.0)
"""Strengths, as shares of a first guess, that a fit may start from: beyond, another first guess or
another law is nearer."""


def screen(
    fit: Fit, hypothesis: Hypothesis, candidates: Sequence[Candidate], moved: Sequence[Motion]
) -> list[Score]:
    """Return the best first guess of every candidate, the most promising first."""
    value = evaluate(hypothesis, fit.z)
    test = _ScoreTest(hypothesis, fit, value)
    laws = [(c, s) for c in candidates for s in c.starts if isinstance(s, Law)]
    rest = [c for c in candidates if not isinstance(c.starts[0], Law)]
    scores = _of_laws(test, laws, moved)
    least = float(np.log(max(len(candidates), 2)))
    valleys = []
    for candidate in rest:
        if not candidate.starts[0].parameters:  # it is there or not: a fit tells
            valleys.append(candidate)
            continue
        if candidate.starts[0].valleys == 1:
            scores += _of_linear(test, candidate)
            continue
        found = [s for s in candidate.starts if _promise(test, candidate, s) > least]
        scores.append(Score(candidate, candidate.starts[0], 0.0))
        if found and isinstance(found[0], Disturbance):
            found = list(candidate.starts)  # by itself each says little of the others
        if found:
            valleys.append(replace(candidate, starts=tuple(found)))
    scores += of_valleys(fit, hypothesis, valleys)
    best: dict[tuple[str, str], Score] = {}
    for score in scores:
        kept = best.get(score.candidate.label)
        if kept is None or score.gain > kept.gain:
            best[score.candidate.label] = score
    return sorted(best.values(), key=lambda s: -s.gain)


class _ScoreTest:
    """Innovations and slopes of the present fit, whitened, and what is projected out."""

    def __init__(self, hypothesis: Hypothesis, fit: Fit, value: Value) -> None:
        self.hypothesis, self.fit, self.value = hypothesis, fit, value
        self.runs = value.runs
        self.parts = []
        shared = [i for i, u in enumerate(hypothesis.unknowns) if u.role != "noise"]
        self.white, self.slopes = [], []
        total = np.eye(len(shared))
        for index, (run, trial) in enumerate(zip(self.runs, value.trials, strict=True)):
            part = gaussian(run, trial)
            columns = [
                i for i, u in enumerate(hypothesis.unknowns) if u.trial is None or u.trial == index
            ]
            keep = [columns.index(i) for i in shared]
            J = part.whitened(np.ascontiguousarray(run.de[:, :, keep]))
            self.parts.append(part)
            self.white.append(part.white.ravel())
            self.slopes.append(J)
            total += J.T @ J
        self.inverse = np.linalg.inv(total)
        self.names = [hypothesis.unknowns[i].name for i in shared]
        # the priors are rows like the samples: what is projected out is held to its prior
        self.pull = np.asarray(fit.z)[shared]

    def gains(self, directions: Sequence[Array]) -> tuple[Array, Array, Array]:
        """Return expected gains and strengths, and the others' shifts for unit strength, (p, c).

        Args:
            directions: whitened changes of the innovations, one (samples m, c) a recording.
        """
        left = [np.array(d) for d in directions]
        prior = np.zeros((len(self.pull), left[0].shape[1]))
        shift = np.zeros_like(prior)
        for _ in range(2):  # once more takes the first one's rounding off
            across = sum(J.T @ d for J, d in zip(self.slopes, left, strict=True)) + prior
            carried = self.inverse @ across
            for J, d in zip(self.slopes, left, strict=True):
                d -= J @ carried
            prior -= carried
            shift -= carried
        s = sum(d.T @ w for d, w in zip(left, self.white, strict=True)) + prior.T @ self.pull
        information = sum(np.einsum("ij,ij->j", d, d) for d in left)
        information = information + np.einsum("ij,ij->j", prior, prior)
        information = np.maximum(information, 1e-300)
        return 0.5 * s**2 / information, -s / information, shift


def _of_laws(
    test: _ScoreTest, pairs: Sequence[tuple[Candidate, Law]], moved: Sequence[Motion]
) -> list[Score]:
    if not pairs:
        return []
    hypothesis = test.hypothesis
    directions = []
    for index, (run, part, motion) in enumerate(zip(test.runs, test.parts, moved, strict=True)):
        model = hypothesis.problem.model
        forces = np.column_stack(
            [
                force_along(law, model.port(law.place), motion, hypothesis.problem.step_s)
                for _, law in pairs
            ]
        )
        rows = np.array([model.port(law.place) for _, law in pairs])
        directions.append(part.whitened(respond(run, hypothesis, index, rows, forces)))
    gains, strengths, shifts = test.gains(directions)
    return [
        _scaled(test, c, s, float(g), float(a), d)
        for (c, s), g, a, d in zip(pairs, gains, strengths, shifts.T, strict=True)
    ]


def _scaled(
    test: _ScoreTest, candidate: Candidate, start: Mechanism, gain: float, strength: float,
    shift: Array,
) -> Score:  # fmt: skip
    if not np.isfinite(gain) or strength <= 0:
        return Score(candidate, start, 0.0)
    if strength > REACH[1] or strength < REACH[0]:
        # so far from the guess the law would have another shape; what stays within reach counts
        inside = float(np.clip(strength, *REACH))
        ratio = inside / strength
        gain *= max(2 * ratio - ratio**2, 0.0)
        strength = inside
    moved = dict(zip(test.names, (strength * shift).tolist(), strict=True))
    return Score(candidate, start.scaled(strength), gain, moved)


def _of_linear(test: _ScoreTest, candidate: Candidate) -> list[Score]:
    """Return the expected gains of what is linear in its strength, or is the twin's own."""
    if (freed := _freed(test, candidate, candidate.starts[0])) is not None:
        return [freed]
    scores = []
    for first, alike in directions_of(candidate.starts):
        told = _direction(test, candidate, first)
        if told is not None:
            gain, strength, shift = told
            scores += [_scaled(test, candidate, start, gain, strength / ratio, shift * ratio)
                       for start, ratio in alike]  # fmt: skip
    return scores


def _promise(test: _ScoreTest, candidate: Candidate, start: Mechanism) -> float:
    """Return the rise of the log likelihood that the score test expects, of either sign [nat].

    A force that nobody measured changes the innovations' covariance alone: it is tried as it is.
    """
    if isinstance(start, Disturbance):
        whole = _near(test, candidate, start)
        return -np.inf if whole is None else whole.log_likelihood - test.fit.log_likelihood
    told = _direction(test, candidate, start)
    return -np.inf if told is None else told[0]


def _direction(
    test: _ScoreTest, candidate: Candidate, first: Mechanism
) -> tuple[float, float, Array] | None:
    """Return gain and strength, of either sign, along what a mechanism changes when it is small.

    An instrument with a memory has an unknown state before the first sample however little it
    does: its direction is that from little to twice as little.
    """
    near = _near(test, candidate, first.scaled(SMALL))
    if near is None:
        return None
    before = test.runs
    if isinstance(first, ChannelFault) and _remembers(first):
        twice = _near(test, candidate, first.scaled(2 * SMALL))
        if twice is None:
            return None
        before, near = near.runs, twice
    directions = []
    for run, here, part in zip(near.runs, before, test.parts, strict=True):
        change = (run.e - here.e)[:, :, None] / SMALL
        directions.append(part.whitened(np.ascontiguousarray(change)))
    gain, strength, shift = test.gains(directions)
    return float(gain[0]), float(strength[0]), shift[:, 0]


def _remembers(fault: ChannelFault) -> bool:
    instrument = fault.instrument(1.0)
    return instrument is not None and len(instrument.A) > 0


def _near(test: _ScoreTest, candidate: Candidate, start: Mechanism) -> Value | None:
    """Return the likelihood with a mechanism and everything else as it is, if there is one."""
    grown = added(test.hypothesis, candidate, start)
    z = moved_to(grown, test.hypothesis, test.fit.z, start)
    try:
        return evaluate(grown, z, derivatives=False, averages=[run.averages for run in test.runs])
    except (ValueError, np.linalg.LinAlgError):
        return None


def directions_of(
    starts: Sequence[Mechanism],
) -> list[tuple[Mechanism, list[tuple[Mechanism, float]]]]:
    """Return first guesses of which none is another one, only stronger.

    Each with all that are: (mechanism, strength as a share of the first one's, either sign).
    """
    out: list[tuple[Mechanism, list[tuple[Mechanism, float]]]] = []
    for start in starts:
        for first, alike in out:
            if (ratio := _stronger(first, start)) is not None:
                alike.append((start, ratio))
                break
        else:
            out.append((start, [(start, 1.0)]))
    return out


def _stronger(first: Mechanism, other: Mechanism) -> float | None:
    """Return by what factor one mechanism is another one's strength, None where it is no such.

    A strength is a multiple of the first parameter, of its distance from one, or a power of it.
    """
    if not first.parameters:
        return None
    name = next(iter(first.parameters))
    a, b, twice = first.values[name], other.values[name], first.scaled(2.0).values[name]
    ratios = []
    if np.isfinite(twice) and twice != a:
        ratios.append(1 + (b - a) / (twice - a))
    if a > 0 and b > 0 and a != 1:
        ratios.append(np.log(b) / np.log(a))
    for ratio in ratios:
        same = first.scaled(ratio).values
        if ratio and all(np.isclose(same[n], v, rtol=1e-9) for n, v in other.values.items()):
            return float(ratio)
    return None


def _freed(test: _ScoreTest, candidate: Candidate, start: Mechanism) -> Score | None:
    """Return what freeing a parameter of the twin from its prior brings, if it is one.

    What the calibration has moved it by becomes the change; the likelihood stays, the prior's cost
    goes.
    """
    name = f"{start.name} {start.place}"
    for unknown, z in zip(test.hypothesis.unknowns, test.fit.z, strict=True):
        if unknown.name == name:
            moved = unknown.value(float(z)) - unknown.value(0.0)
            change = start.with_values({next(iter(start.parameters)): moved})
            return Score(candidate, change, 0.5 * float(z) ** 2, {name: -float(z)})
    return None
