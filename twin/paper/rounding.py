"""Can rounding explain a difference? The one test by which printed numbers agree or contradict.

Printed numbers stand for intervals of half a unit of their last digit on either side. Two sets of
numbers contradict each other when no inputs inside their intervals give outputs inside theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import optimize

from twin.paper.printed import Array, Printed, half_units, values


def misfit(
    function: Callable[[Array, Array], Array],
    inputs: Sequence[Printed],
    outputs: Sequence[Printed],
    free: Sequence[float] = (),
) -> float:
    """Return how far the outputs stay from the printed ones, in half units of their last digit.

    The inputs are moved inside their rounding intervals, and the ``free`` numbers without limits,
    until the largest miss is as small as a bounded least-squares search makes it: at most 1 means
    that the printed outputs follow from the printed inputs.

    Args:
        function: (inputs, free) -> outputs.
        inputs: printed numbers that the outputs are computed from.
        outputs: printed numbers to be met.
        free: start values of numbers that the paper does not print.
    """
    start, spread = values(inputs), half_units(inputs)
    target, unit = values(outputs), half_units(outputs)
    count = len(start)
    scale = np.array([abs(value) or 1.0 for value in free])

    def miss(x: Array) -> Array:
        return (function(start + spread * x[:count], scale * x[count:]) - target) / unit

    def beyond(x: Array) -> Array:
        excess = miss(x)
        return np.asarray(np.sign(excess) * np.maximum(np.abs(excess) - 1, 0))

    limit = np.concatenate([np.ones(count), np.full(len(scale), np.inf)])
    x = np.concatenate([np.zeros(count), np.asarray(free, float) / scale])
    if not len(x):
        return float(np.abs(miss(x)).max())
    for residual in (miss, beyond):
        fit = optimize.least_squares(residual, x, bounds=(-limit, limit), max_nfev=1000)
        x = fit.x
    return float(np.abs(miss(x)).max())
