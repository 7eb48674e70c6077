"""The predictor with its laws linearised about the motion, for small changes of the model.

A law's force is what it does on the average, k d + c v (statistical linearisation), and a rest that
is known from the fit's own pass. The rest is an input; so a change of the model is followed by the
linear predictor alone, whatever the laws cost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.estimation.kalman import gains
from twin.estimation.likelihood import gaussian
from twin.estimation.model import Assembly, Trial
from twin.estimation.parallel import each
from twin.estimation.passing import LawAverages, Run, run
from twin.estimation.system import System, sampled

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Linearised:
    """What a fit's laws do in each of its recordings.

    Attributes:
        averages: k and c of each law, and how much outputs are blurred.
        rest: the rest of the forces at the samples, (samples, l).
    """

    averages: tuple[LawAverages, ...]
    rest: tuple[Array, ...]

    @classmethod
    def of(cls, runs: Sequence[Run]) -> Linearised:
        """Return them from the fit's own passes."""
        rest = []
        for passed in runs:
            system, averages = passed.sampled.system, passed.averages
            rest.append(passed.f - passed.x @ averages.tangent(system).T)
        return cls(tuple(r.averages for r in runs), tuple(rest))

    def passes(self, model: Hypothesis, z: Array) -> tuple[tuple[Run, ...], float]:
        """Return the passes of a model with the same laws, and its log likelihood.

        Args:
            model: with other mechanisms beside the laws.
            z: values of its unknowns, (p,).

        Raises:
            ValueError: no stationary filter, or a model that cannot be.
        """
        here = model.assemble(z)
        found = each(lambda i: self._passed(here, i), len(here.trials))
        return tuple(r for r, _ in found), sum(value for _, value in found)

    def _passed(self, here: Assembly, index: int) -> tuple[Run, float]:
        averages, rest = self.averages[index], self.rest[index]
        own, laws = here.trials[index], rest.shape[1]
        trial = Trial(np.hstack([own.u, rest]), np.hstack([own.between, rest]), own.y, own.step_s)
        system = _with_inputs(here.systems[here.which[index]], averages)
        held = np.concatenate([here.held, np.zeros(laws, bool)])
        plant = sampled(system, own.step_s, 1, held)
        linear = replace(
            here, systems=(system,), laws=(), numbers=here.numbers[:0], scales=here.scales[:0],
            steps=1, held=held,
        )  # fmt: skip
        gain = gains(plant, here.noises[index], missing=trial.missing)
        passed = run(linear, trial, plant, gain, averages=LawAverages(None, averages.blur))
        return passed, gaussian(passed, trial).value


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
