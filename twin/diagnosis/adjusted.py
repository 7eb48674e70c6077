"""Steps of what is added to a fit, the fit's own unknowns adjusted to first order.

Variable projection (Golub and Pereyra 1973) with the fit's slopes as they are: of the whitened
innovations w and of their slopes D by the new unknowns only what the fit's own cannot take up
counts, so that a step costs a pass for each new unknown. Noise stays as the fit has it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.linearised import Linearised
from twin.diagnosis.score_test import profiled
from twin.estimation.fit import ENOUGH, LONGEST, Fit
from twin.estimation.likelihood import evaluate, passes
from twin.estimation.sensitivities import STEP

Array = NDArray[np.float64]


class Adjusted:
    """A fit, its own unknowns ready to adjust themselves to what is added.

    Args:
        model: what was fitted, its laws linearised.
        fit: the fit.
    """

    def __init__(self, model: Linearised, fit: Fit) -> None:
        value = evaluate(model, fit.z, free=model.free, filtered=True)
        self._names, self._parts, own = profiled(model.unknowns, model.free, value, fit.z)
        self._profiled, self.log_posterior = own, -own.left(own.white, own.pull)

    def steps(self, model: Linearised, z: Array, most: int) -> tuple[float, Array]:
        """Return where so many steps lead: the log posterior, as that of the fit, and values.

        Args:
            model: the fit's with one more mechanism.
            z: where to begin, (p,).
            most: steps.

        Raises:
            NoLikelihoodError: no such model.
        """
        own, shared = self._of(model)
        white = self._white(model, z)
        value = self._value(white, z, own, shared)
        for _ in range(most if own else 0):
            slopes = self._slopes(model, z, own, white)
            told = self._profiled.prior.T @ z[shared] + self._profiled.across(white)
            across = self._profiled.across(slopes)
            g = across.T @ told - sum(d.T @ w for d, w in zip(slopes, white, strict=True)) - z[own]
            H = sum(d.T @ d for d in slopes) - across.T @ across + np.eye(len(own))
            delta = np.linalg.solve(H, g)
            delta /= max(1.0, float(np.max(np.abs(delta))) / LONGEST)
            gained = -np.inf
            while gained < 0 and np.max(np.abs(delta)) > STEP:
                near = z.copy()
                near[own] += delta
                moved = self._white(model, near)
                gained = self._value(moved, near, own, shared) - value
                delta /= 4
            if gained < ENOUGH:
                break
            z, white, value = near, moved, value + gained
        z = z.copy()
        told = self._profiled.prior.T @ z[shared] + self._profiled.across(white)
        z[shared] -= np.linalg.solve(self._profiled.root, told)
        return value, z

    def _of(self, model: Linearised) -> tuple[list[int], list[int]]:
        """Return where the last mechanism's unknowns stand, and the fit's own."""
        last = model.hypothesis.mechanisms[-1]
        titles = {f"{last.name} {last.place} {name}" for name in last.parameters}
        at = {u.name: i for i, u in enumerate(model.unknowns)}
        return [i for name, i in at.items() if name in titles], [at[name] for name in self._names]

    def _white(self, model: Linearised, z: Array) -> list[Array]:
        with np.errstate(all="ignore"):  # a step may lead where nothing is finite: it is not taken
            runs = passes(model, z)
        return [part.whitened(run.e[:, :, None])[:, 0]
                for part, run in zip(self._parts, runs, strict=True)]  # fmt: skip

    def _slopes(
        self, model: Linearised, z: Array, own: Sequence[int], white: Sequence[Array]
    ) -> list[Array]:
        columns = []
        for i in own:
            near = z.copy()
            near[i] += STEP
            pairs = zip(self._white(model, near), white, strict=True)
            columns.append([(moved - here) / STEP for moved, here in pairs])
        return [np.column_stack(of_one) for of_one in zip(*columns, strict=True)]

    def _value(
        self, white: Sequence[Array], z: Array, own: Sequence[int], shared: Sequence[int]
    ) -> float:
        value = -self._profiled.left(white, z[shared]) - 0.5 * float(z[own] @ z[own])
        return value if np.isfinite(value) else -np.inf
