"""Laws compiled to one signature, so that the stepping loop is compiled once for all of them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numba

MOST_NUMBERS = 24
"""Numbers that a law may have."""

# pointers to compiled functions are old enough, whatever Numba calls them
warnings.filterwarnings("ignore", "First-class function type feature")

REAL = numba.float64
NUMBERS = numba.types.CPointer(REAL)
FORCE = REAL(REAL, REAL, REAL, REAL, NUMBERS)
FLOW = REAL(REAL, REAL, REAL, NUMBERS)


@dataclass(frozen=True)
class Law:
    """f(d, v, z, t, *numbers), and what its memory z becomes as the displacement changes.

    Attributes:
        force: of displacement, rate, memory, time and ``count`` numbers; opposes positive d [N].
        flow: of memory, displacement before and after, and the numbers; None without memory.
        count: numbers that it takes.
    """

    force: Callable[..., Any]
    flow: Callable[..., Any] | None
    count: int


def _compiled(function: Any, arguments: str, count: int, fallback: str, signature: Any) -> Any:
    """Return a pointer to the compiled function; numbers in one array give all one type."""
    if function is None:
        line, names = fallback, {}
    else:
        numbers = "".join(f", p[{i}]" for i in range(count))
        line, names = f"law({arguments}{numbers})", {"law": numba.njit(nogil=True)(function)}
    exec(f"def chosen({arguments}, p):\n    return {line}", names)
    return numba.cfunc(signature)(names["chosen"])


@lru_cache(maxsize=256)
def _pair(law: Law | None) -> tuple[Any, Any]:
    force, flow, count = (law.force, law.flow, law.count) if law else (None, None, 0)
    return (
        _compiled(force, "d, v, z, t", count, "0.0 * d", FORCE),
        _compiled(flow, "z, before, after", count, "z", FLOW),
    )


def pointers(laws: tuple[Law, ...]) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Return forces and flows for the stepping loop, each compiled once a process."""
    # the type of an empty tuple says nothing of its members
    pairs = [_pair(law) for law in laws] or [_pair(None)]
    forces, flows = zip(*pairs, strict=True)
    return forces, flows
