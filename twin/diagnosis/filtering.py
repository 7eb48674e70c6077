"""The analyser's filter that laws of which samples do not show all are seen through.

Nobody states it, so that its kind, order and edge are found by the likelihood. They matter: a jump
that is smeared otherwise looks like a delay of a channel, or like another law beside the first one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.estimation.fit import Fit
from twin.estimation.likelihood import evaluate
from twin.estimation.low_pass import LowPass

Array = NDArray[np.float64]

FILTERS = (
    *(LowPass(cut_off) for cut_off in (0.8, 0.9, 1.0, 2.0)),
    *(LowPass(cut_off, 7) for cut_off in (0.7, 0.8, 0.9)),
)
"""Where the search begins: filters of linear phase, the last one hardly a filter, and of
Butterworth of an order in the middle."""

ORDERS = range(2, 13)
"""Of Butterworth's filters that analysers have; what falls off still more steeply is like the
last."""

EDGES = (0.3, 2.0)
"""Between which shares of half the sampling rate a filter's edge is looked for: below, the
recordings show nothing of what they are said to show; above, hardly anything is filtered."""

COARSE, FINE = 0.05, 0.01
"""Steps of the edge at first, half of what the guesses lie apart, and at last: with that the
phase of Butterworth's filter changes by 0.003 rad at half its edge, and what a jump shows by three
thousandths of itself."""


def likeliest_filter(hypothesis: Hypothesis, found: Fit) -> LowPass:
    """Return the filter that is likeliest at the values of a fit, by steps in edge and order.

    Args:
        hypothesis: with laws that are seen through it.
        found: its fit, with another filter or none.
    """
    known: dict[LowPass, float] = {}
    averages = found.averages if hypothesis.problem.low_pass is not None else None

    def value(low_pass: LowPass) -> float:
        nonlocal averages
        if low_pass not in known:
            other = replace(hypothesis, problem=replace(hypothesis.problem, low_pass=low_pass))
            try:
                with np.errstate(all="ignore"):  # laws that run away behind another filter
                    here = evaluate(other, found.z, False, averages)
            except np.linalg.LinAlgError:
                return -np.inf
            # where simulations begin is found once, and serves other filters
            known[low_pass], averages = here.log_likelihood, here.averages
        return known[low_pass]

    present = hypothesis.problem.low_pass
    best = max((*FILTERS, *([present] if present is not None else [])), key=value)
    step = COARSE
    while step >= FINE:
        better = max(_neighbours(best, step), key=value)
        if value(better) > value(best):
            best = better
        else:
            step /= 2
    return best


def _neighbours(low_pass: LowPass, step: float) -> list[LowPass]:
    """Return filters whose edge is a step away, or whose order is the next one."""
    low, high = EDGES
    edges = {round(float(np.clip(low_pass.cut_off + s, low, high)), 6) for s in (-step, step)}
    orders = {low_pass.order - 1, low_pass.order + 1} & set(ORDERS) if low_pass.order else set()
    return [
        *(replace(low_pass, cut_off=edge) for edge in sorted(edges)),
        *(replace(low_pass, order=order) for order in sorted(orders)),
    ]
