"""A hypothesis with its laws linearised about the motion, for small changes and first guesses.

A law's force is what it does on the average, k d + c v (statistical linearisation), and a rest that
is known from the fit's own pass. The rest is an input; so what is added beside the laws is followed
by a linear predictor, whatever they cost and whatever states it has of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.problem import Problem
from twin.diagnosis.straight import prefiltered
from twin.estimation.acting import pushed
from twin.estimation.law_averages import LawAverages
from twin.estimation.model import Assembly, Trial, Unknown
from twin.estimation.passing import Run
from twin.estimation.system import System
from twin.mechanisms.mechanism import Law, Mechanism

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Linearised:
    """A hypothesis whose laws move as they did; it is a ``Model`` of the likelihood.

    Attributes:
        hypothesis: with the fit's laws, and further mechanisms that are none.
        averages: k and c of each law in each recording, and how much outputs are blurred.
        rest: the rest of the forces at the samples of each recording, (samples, l).
        pushed: what a unit force of each law that is held over a sample does to the state of the
            fit in each recording, (n, l).
    """

    hypothesis: Hypothesis
    averages: tuple[LawAverages, ...]
    rest: tuple[Array, ...]
    pushed: tuple[Array, ...]

    @classmethod
    def of(cls, hypothesis: Hypothesis, runs: Sequence[Run]) -> Linearised:
        """Return a hypothesis linearised about the passes of its fit."""
        rest, before = [], []
        for passed in runs:
            system = passed.sampled.system
            rest.append(passed.f - passed.x @ passed.averages.tangent(system).T)
            before.append(pushed(system, hypothesis.problem.step_s))
        return cls(hypothesis, tuple(r.averages for r in runs), tuple(rest), tuple(before))

    def beside(self, hypothesis: Hypothesis) -> Linearised:
        """Return another hypothesis with the same laws, linearised alike."""
        return replace(self, hypothesis=hypothesis)

    @property
    def problem(self) -> Problem:
        """The estimation problem."""
        return self.hypothesis.problem

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Those of the hypothesis."""
        return self.hypothesis.unknowns

    def at(self, z: Array) -> tuple[Mechanism, ...]:
        """Return the mechanisms at values z of all unknowns, (p,)."""
        return self.hypothesis.at(z)

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """Which unknowns may move: all but the laws' own, (p,)."""
        laws = [m for m in self.hypothesis.mechanisms if isinstance(m, Law)]
        held = {f"{m.name} {m.place} {name}" for m in laws for name in m.parameters}
        held |= {own.unknown.name for own in self.problem.of_known}
        return np.array([u.name not in held for u in self.unknowns])

    @property
    def filtered(self) -> bool:
        """Whether the rest is what an analyser shows of it, and so band-limited."""
        return self.hypothesis.simulated

    @property
    def laws(self) -> int:
        """How many laws there are."""
        return self.rest[0].shape[1]

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The recordings, the rest of the laws' forces beside the inputs."""
        return self._trials(self.hypothesis.trials)

    @property
    def blurred(self) -> bool:
        """No law is left that could blur; what the laws blurred is in the assembly."""
        return False

    def blur(self, forces: Array, system: System) -> Array:
        """Return nothing, (samples, m)."""
        return np.zeros((len(forces), len(system.C)))

    def assemble(self, z: Array) -> Assembly:
        """Return the linear systems, noise levels and recordings at values z, (p,)."""
        here = self.hypothesis.assemble(z)
        if not self.laws:
            return here
        pairs = zip(here.which, self.averages, strict=True)
        laws = len(here.laws)
        return replace(
            here,
            systems=tuple(_with_inputs(here.systems[k], averages) for k, averages in pairs),
            which=tuple(range(len(here.which))),
            laws=(),
            numbers=here.numbers[:0],
            scales=here.scales[:0],
            steps=1,
            own=(),
            ringing=None,
            held=np.concatenate([here.held, np.zeros(laws, bool)]),
            trials=self._trials(here.trials),
            blurs=tuple(
                None if a.blur is None else a.blur[: len(t.y)]
                for a, t in zip(self.averages, here.trials, strict=True)
            ),
            kicks=tuple(self._kicks(here.systems[k], t) for t, k in enumerate(here.which)),
            errors=(),
        )

    def _kicks(self, system: System, index: int) -> Mapping[int, Array]:
        """Return how much less certain laws leave the state, which may have got more states."""
        known, before = self.averages[index].kicks, self.pushed[index]
        if not known or len(system.A) == len(before):
            return known
        moved = pushed(system, self.problem.step_s) @ np.linalg.pinv(before)
        return {sample: moved @ kick @ moved.T for sample, kick in known.items()}

    def _trials(self, trials: Sequence[Trial]) -> tuple[Trial, ...]:
        out = []
        for own, whole in zip(trials, self.rest, strict=True):
            rest = whole[: len(own.y)]
            lines = prefiltered(rest) if self.filtered else rest
            u, between = np.hstack([own.u, rest]), np.hstack([own.between, lines])
            out.append(Trial(u, between, own.y, own.step_s, missed=own.missed))
        return tuple(out)


def _with_inputs(system: System, averages: LawAverages) -> System:
    """Return a system whose laws are linear, with the rest of their forces as further inputs."""
    tangent, n = averages.tangent(system), len(system.A)
    return replace(
        system,
        A=system.A + system.E @ tangent,
        C=system.C + system.F @ tangent,
        B=np.hstack([system.B, system.E]),
        D=np.hstack([system.D, system.F]),
        E=np.zeros((n, 0)),
        F=np.zeros((len(system.C), 0)),
        drift=np.zeros((0, n)),
        rate=np.zeros((0, n)),
    )
