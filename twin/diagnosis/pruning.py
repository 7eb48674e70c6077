"""What was found on the way and is not needed any more, dropped: backward elimination.

What is found early is fitted to what is still missing then. Found in turn, the rest may explain all
of it, and better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.refining import refined
from twin.diagnosis.stage import DECISIVE, Stage


def pruned(
    bench: Bench, best: Fit, stages: Sequence[Stage], slack: float
) -> tuple[Fit, tuple[Stage, ...], tuple[float, ...]]:
    """Return the fit without what it can do without, its stages, and what the rest is worth.

    Args:
        bench: model and trials.
        best: the fit of all that was found.
        stages: one for each finding, in their order, and perhaps one that found nothing more.
        slack: of a fit that knows nothing, from which what is left begins.

    Returns:
        The fit; the stages that are left, the last of them after the fit where it came before; and
        for each finding by how much the BIC is worse without it, the others fitted anew.
    """
    kept = list(stages)
    fits = _without_each(bench, best, slack)
    while fits:
        lost = [np.inf if f is None else f.bic - best.bic for f in fits]
        least = int(np.argmin(lost))
        fit = fits[least]
        if fit is None or lost[least] >= DECISIVE:
            return best, tuple(kept), tuple(lost)
        del kept[least]
        kept[-1] = replace(kept[-1], before=fit) if kept[-1].before is best else kept[-1]
        best = fit
        fits = _without_each(bench, best, slack)
    return best, tuple(kept), (np.inf,) * len(best.hypothesis.found)


def _without_each(bench: Bench, best: Fit, slack: float) -> list[Fit | None]:
    """Return fits without each finding in turn; none where there is but one."""
    whole = best.hypothesis
    if len(whole.found) < 2:
        return []
    out: list[Fit | None] = []
    for number in range(len(whole.found)):
        rest = tuple(m for i, m in enumerate(whole.found) if i != number)
        try:
            out.append(refined(bench, [replace(whole, found=rest)], slack, rounds=2))
        except np.linalg.LinAlgError:
            out.append(None)
    return out
