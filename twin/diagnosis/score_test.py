"""The score test of small changes of a fitted model (Rao 1948).

A candidate of small strength a changes the whitened innovations w along a direction d, to w + a d.
With Q an orthonormal basis of the fit's own slopes (the priors are rows like the samples, so that
what is projected out is held to its prior), b = Q^T w and c = Q^T d,

    s = d^T w - c^T b,        I = d^T d - c^T c,

the log likelihood would rise by s^2 / (2 I) at the strength -s / I.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import added, beginnings, by_name, moved_to
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.linearised import Linearised
from twin.diagnosis.portion import on_a_part
from twin.diagnosis.scales import ROUNDING
from twin.estimation.density import Part
from twin.estimation.fit import Fit
from twin.estimation.likelihood import Value, evaluate, gaussian, passes
from twin.estimation.model import Trial, Unknown
from twin.estimation.parallel import each
from twin.estimation.passing import Run
from twin.mechanisms.mechanism import ChannelFault, Mechanism

Array = NDArray[np.float64]
Told = tuple[float, float, Array]
"""Expected gain [nat], strength of either sign, and the others' shifts for unit strength."""

SMALL = 1e-4
"""Strength, as a share of a first guess, at which a linear candidate's direction is taken."""

TOGETHER = 64
"""Directions at a time: one product of matrices instead of many with vectors, and no more memory
than so many recordings."""


class Profiled:
    """Whitened innovations, and the span of a fit's own slopes that is projected out of them.

    Args:
        slopes: of each recording, whitened as rows, (rows, p).
        white: the innovations alike, (rows,).
        pull: values of the fit's own unknowns in prior deviations, (p,).
    """

    def __init__(self, slopes: Sequence[Array], white: Sequence[Array], pull: Array) -> None:
        q, self.root = np.linalg.qr(np.vstack([*slopes, np.eye(len(pull))]))
        *self.basis, self.prior = np.split(q, np.cumsum([len(J) for J in slopes]))
        self.white, self.pull = white, pull
        self.told = self.prior.T @ pull + self.across(white)

    def across(self, directions: Sequence[Array]) -> Array:
        """Return what of directions, one a recording, lies in the span."""
        both = zip(self.basis, directions, strict=True)
        return np.asarray(sum(Q.T @ d for Q, d in both))

    def gains(self, directions: Sequence[Array]) -> tuple[Array, Array, Array]:
        """Return expected gains and strengths, and the others' shifts for unit strength, (p, c).

        Args:
            directions: whitened changes of the innovations, one (rows, c) a recording.
        """
        across = self.across(directions)
        along = sum(d.T @ w for d, w in zip(directions, self.white, strict=True))
        s = along - across.T @ self.told
        power = sum(np.einsum("ij,ij->j", d, d) for d in directions)
        left = power - np.einsum("ij,ij->j", across, across)
        information = np.maximum(np.maximum(left, ROUNDING * power), 1e-300)
        return 0.5 * s**2 / information, -s / information, -np.linalg.solve(self.root, across)

    def left(self, white: Sequence[Array], pull: Array) -> float:
        """Return half the squares of innovations and priors that no step of the fit's own takes."""
        told = self.across(white) + self.prior.T @ pull
        power = sum(float(w @ w) for w in white) + float(pull @ pull)
        return 0.5 * (power - float(told @ told))


def profiled(
    unknowns: Sequence[Unknown], free: NDArray[np.bool_], value: Value, z: Array
) -> tuple[list[str], list[Part], Profiled]:
    """Return a fit whose unknowns, but for those of one recording, can be projected out.

    Args:
        unknowns: of the fit.
        free: those that its derivatives are with respect to, (p,).
        value: the likelihood there, with derivatives.
        z: its values, (p,).

    Returns:
        Their names, what whitens the innovations of each recording, and both profiled.
    """
    shared = [i for i, u in enumerate(unknowns)
              if free[i] and u.role != "noise" and u.trial is None]  # fmt: skip
    parts = [gaussian(r, t) for r, t in zip(value.runs, value.trials, strict=True)]
    slopes = []
    for index, (part, run) in enumerate(zip(parts, value.runs, strict=True)):
        columns = [i for i, u in enumerate(unknowns)
                   if free[i] and (u.trial is None or u.trial == index)]  # fmt: skip
        own = run.de[:, :, [columns.index(i) for i in shared]]
        slopes.append(part.whitened(np.ascontiguousarray(own)))
    white = [part.white.ravel() for part in parts]
    names = [unknowns[i].name for i in shared]
    return names, parts, Profiled(slopes, white, np.asarray(z)[shared])


class ScoreTest:
    """A fit of the innovations likelihood, beside which small changes are followed."""

    def __init__(self, hypothesis: Hypothesis, fit: Fit) -> None:
        self.hypothesis, self.fit = hypothesis, fit
        value = evaluate(hypothesis, fit.z, averages=fit.averages, filtered=True)
        self.linear = Linearised.of(hypothesis, value.runs)
        self._without = passes(self.linear, fit.z)
        # where laws began with an estimated state, what is added may have begun with another one
        self.runs = tuple(
            own if own.averages.start is None else replace(own, e=linear.e, gains=linear.gains)
            for own, linear in zip(value.runs, self._without, strict=True)
        )
        value = replace(value, runs=self.runs)
        self._part = on_a_part(hypothesis)
        every_part = (hypothesis, *([self._part] if self._part else []))
        self._likelihood = {h.problem.samples: _density(value.runs, h.trials) for h in every_part}
        every = np.ones(len(fit.z), bool)
        self.names, self.parts, self.profiled = profiled(hypothesis.unknowns, every, value, fit.z)

    def whitened(self, index: int, change: Array) -> Array:
        """Return changes of a recording's innovations, (samples, m, c), whitened as rows."""
        return self.parts[index].whitened(np.ascontiguousarray(change))

    def of_changes(
        self, changes: Callable[[int, slice], Array], count: int
    ) -> tuple[Array, Array, Array]:
        """Return ``Profiled.gains`` of many directions, so many at a time.

        Args:
            changes: index of a recording and which directions -> how its innovations change,
                (samples, m, c).
            count: of directions.
        """
        out = []
        for first in range(0, count, TOGETHER):
            some = slice(first, min(first + TOGETHER, count))
            whitened = partial(self._whitened, changes, some)
            out.append(self.profiled.gains(each(whitened, len(self.runs))))
        gains, strengths, shifts = zip(*out, strict=True)
        return np.concatenate(gains), np.concatenate(strengths), np.hstack(shifts)

    def _whitened(self, changes: Callable[[int, slice], Array], some: slice, i: int) -> Array:
        return self.whitened(i, changes(i, some))

    def freed(self, name: str, wide: float) -> Told:
        """Return what a second unknown that does as one of the fit's own does would bring.

        Its direction is that one's but for its row of the prior: what the samples say of it, others
        can in part say as well, and while it is held to its prior they do.

        Args:
            name: of the fit's own.
            wide: the second one's prior deviation in the first one's, the unit of its strength.
        """
        index = self.names.index(name)
        own = self.profiled
        row = own.prior[index]
        pull = float(own.pull[index]) - float(row @ own.told)
        information = max(1.0 - float(row @ row), ROUNDING) + wide**-2
        shift = np.linalg.solve(own.root, row)
        shift[index] -= 1.0
        return 0.5 * pull**2 / information, pull / information, shift

    def along(self, pairs: Sequence[tuple[Candidate, Mechanism]]) -> list[Told | None]:
        """Return what is told along the changes that mechanisms make when they are small.

        None where there is no such model.
        """
        out: list[Told | None] = [None] * len(pairs)
        for first in range(0, len(pairs), TOGETHER):
            found = {}
            for at, (candidate, start) in enumerate(pairs[first : first + TOGETHER], first):
                if (change := self._change(candidate, start)) is not None:
                    found[at] = change
            if not found:
                continue
            stacked = [
                self.whitened(i, np.stack([c[i] for c in found.values()], axis=-1))
                for i in range(len(self.runs))
            ]
            gains, strengths, shifts = self.profiled.gains(stacked)
            for column, at in enumerate(found):
                out[at] = float(gains[column]), float(strengths[column]), shifts[:, column]
        return out

    def _change(self, candidate: Candidate, first: Mechanism) -> list[Array] | None:
        """Return the innovations' slopes with respect to a mechanism's strength, at little of it.

        An instrument with a memory has an unknown state before the first sample however little it
        does: its direction is that from little to twice as little.
        """
        before: Sequence[Run] | None = self._without
        near = self._passes(candidate, first.scaled(SMALL))
        if isinstance(first, ChannelFault) and _remembers(first):
            before, near = near, self._passes(candidate, first.scaled(2 * SMALL))
        if near is None or before is None:
            return None
        pairs = zip(near, before, strict=True)
        with np.errstate(all="ignore"):  # what runs away is no small change
            change = [(run.e - here.e) / SMALL for run, here in pairs]
        return change if all(np.all(np.isfinite(c)) for c in change) else None

    def _passes(self, candidate: Candidate, start: Mechanism) -> Sequence[Run] | None:
        grown = added(self.hypothesis, candidate, start)
        z = moved_to(grown, self.hypothesis, self.fit.z, start)
        try:
            return passes(self.linear.beside(grown), z)
        except np.linalg.LinAlgError:
            return None

    def whole(self, candidate: Candidate, start: Mechanism) -> float:
        """Return the rise of the log likelihood with a mechanism as it is [nat].

        Where it has no parameters the others adjust themselves, to first order and with the noise
        as it is, from where they are or from the nominal twin. What is steady, and lowers the
        likelihood of a part, is not followed on.
        """
        grown = added(self.hypothesis, candidate, start)
        z = moved_to(grown, self.hypothesis, self.fit.z, start)
        if not start.parameters:
            return max(max(self._rise(grown, begun)) for begun in beginnings(grown, z))
        if self._part is not None:
            there = self._rise(added(self._part, candidate, start), z)[0]
            if there < 0:
                return there
        return self._rise(grown, z)[0]

    def _rise(self, grown: Hypothesis, z: Array) -> tuple[float, float]:
        """Return the rise of the log likelihood, and that with the others adjusted.

        What the linearised laws miss is no matter of what is added: only changes count.
        """
        try:
            value = evaluate(self.linear.beside(grown), z, derivatives=False, filtered=True)
        except np.linalg.LinAlgError:
            return -np.inf, -np.inf
        triples = zip(self.runs, value.runs, self._without, strict=True)
        runs = [replace(near, e=own.e[: len(near.e)] + near.e - here.e[: len(near.e)])
                for own, near, here in triples]  # fmt: skip
        rise = _density(runs, value.trials) - self._likelihood[grown.problem.samples]
        if grown.problem.samples < self.hypothesis.problem.samples:
            return rise, rise
        known = by_name(grown, z)
        # another law at a port may put another discrepancy there: what is gone pulls no more
        pull = np.array([known.get(name, 0.0) for name in self.names])
        white = [self.whitened(i, run.e[:, :, None])[:, 0] for i, run in enumerate(runs)]
        own = self.profiled
        return rise, own.left(own.white, own.pull) - own.left(white, pull)


def _density(runs: Sequence[Run], trials: Sequence[Trial]) -> float:
    pairs = zip(runs, trials, strict=True)
    return sum(gaussian(replace(run, e=run.e[: len(trial.y)]), trial).value for run, trial in pairs)


def _remembers(fault: ChannelFault) -> bool:
    instrument = fault.instrument(1.0)
    return instrument is not None and len(instrument.A) > 0
