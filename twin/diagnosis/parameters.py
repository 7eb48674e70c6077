"""Which stiffnesses of a twin are parameters: those that recordings could tell apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.scales import ROUNDING
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

TELLABLE = 1e-6
"""A stiffness pattern counts as another one where this share of it is not a sum of those before."""


def stiffnesses_of(model: LinearModel) -> tuple[tuple[str, Array, float], ...]:
    """Return ports whose stiffness is a parameter: name, row (n,), stiffness seen there [N/m].

    Ports that no recording could tell apart (their patterns row row^T are sums of others') are
    represented once.
    """
    try:
        compliance = np.linalg.inv(model.K)
    except np.linalg.LinAlgError:
        compliance = np.linalg.pinv(model.K)
    # a port that moves a rigid mode holds nothing back by itself
    rigid = np.diag(model.K) <= ROUNDING * np.max(np.diag(model.K), initial=1e-300)
    found: list[tuple[str, Array, float]] = []
    patterns: list[Array] = []
    for name in model.places("drift"):
        row = model.port(name)
        if np.any(np.abs(row[rigid]) > ROUNDING * np.linalg.norm(row)):
            continue
        seen = float(row @ compliance @ row)
        if not seen > 0:
            continue
        pattern = np.outer(row, row).ravel() / float(row @ row)
        rest = pattern.copy()
        for other in patterns:
            rest -= other * float(other @ rest)
        if float(rest @ rest) > TELLABLE:
            patterns.append(rest / np.linalg.norm(rest))
            found.append((name, row, 1 / seen))
    return tuple(found)
