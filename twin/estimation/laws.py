"""Laws compiled to one signature and called by address, so that the stepping is compiled once."""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_NUMBERS = 24
"""Numbers that a law may have."""

REAL = types.float64
NUMBERS = types.CPointer(REAL)
FORCE = REAL(REAL, REAL, REAL, REAL, NUMBERS)
FLOW = REAL(REAL, REAL, REAL, REAL, NUMBERS)


@dataclass(frozen=True)
class Law:
    """f(d, v, z, t, *numbers), and what its memory becomes as the displacement changes.

    Attributes:
        force: of displacement, rate, memory, time and ``count`` numbers; opposes positive d [N].
            The memory is the sum of its parts.
        flow: of one part of the memory, which part it is, displacement before and after, and the
            numbers; None without memory.
        count: numbers that it takes.
        parts: of its memory.
    """

    force: Callable[..., Any]
    flow: Callable[..., Any] | None
    count: int
    parts: int = 1


@cache
def _compiled(law: Law) -> tuple[Any, Any]:
    """Return the compiled force and flow; they are kept, because only their addresses travel."""
    force = _with_one_signature(law.force, "d, v, z, t", law.count, FORCE)
    if law.flow is None:
        return force, None
    return force, _with_one_signature(law.flow, "z, part, before, after", law.count, FLOW)


def _with_one_signature(function: Any, arguments: str, count: int, signature: Any) -> Any:
    """Compile a law; the machine code is kept on disk beside the law's file, as numba keeps it."""
    file = inspect.getsourcefile(function)
    kept = file is not None and os.path.isfile(file)
    # the cache knows a function by file and name, and is stale as soon as the file changes
    name = "_".join([*function.__qualname__.replace("<", "").replace(">", "").split("."), "called"])
    names = {"law": numba.njit(nogil=True, cache=kept)(function), "__name__": function.__module__}
    numbers = "".join(f", p[{i}]" for i in range(count))
    source = f"def {name}({arguments}, p):\n    return law({arguments}{numbers})"
    exec(compile(source, file if kept and file else "<law>", "exec"), names)
    return numba.cfunc(signature, cache=kept)(names[name])


def addresses(laws: tuple[Law, ...]) -> NDArray[np.int64]:
    """Return where each law's compiled force and flow lie, and parts of memory, (l, 3); or 0."""
    out = np.zeros((len(laws), 3), np.int64)
    for row, law in zip(out, laws, strict=True):
        force, flow = _compiled(law)
        row[0] = force.address
        if flow is not None:
            row[1:] = flow.address, law.parts
    return out


def no_memory(laws: tuple[Law, ...]) -> Array:
    """Return the memories of laws that have not moved, (l, most parts)."""
    return np.zeros((len(laws), max((law.parts for law in laws), default=1)))


def _caller(reals: int) -> Any:
    """Return a function for compiled code that calls an address with that many real numbers."""

    def typed(context, address, *rest):
        def generate(context, builder, signature, args):
            real, pointer = ir.DoubleType(), ir.DoubleType().as_pointer()
            kind = ir.FunctionType(real, [real] * reals + [pointer])
            function = builder.inttoptr(args[0], kind.as_pointer())
            numbers = builder.inttoptr(args[-1], pointer)
            return builder.call(function, [*args[1:-1], numbers])

        return REAL(types.int64, *[REAL] * reals, types.int64), generate

    return typed


@intrinsic
def call_force(context, address, d, v, z, t, numbers):
    """Call a compiled force; ``numbers`` is the address of its numbers."""
    return _caller(4)(context, address)


@intrinsic
def call_flow(context, address, z, part, before, after, numbers):
    """Call a compiled flow; ``numbers`` is the address of its numbers, ``part`` a real number."""
    return _caller(4)(context, address)


def memory_along(law: Law, numbers: Array, drift: Array) -> Array:
    """Return a law's memory along a displacement that begins without memory, (samples,).

    It is the sum of its parts.

    Args:
        law: the law.
        numbers: of the law, (count,).
        drift: displacement at its port [m or rad], (samples,).
    """
    address = addresses((law,))[0]
    z = no_memory((law,))[0]
    return np.asarray(_followed(address, z, np.array(numbers, float), np.ascontiguousarray(drift)))


@numba.njit(nogil=True, cache=True)
def _followed(law, z, numbers, drift):
    out = np.zeros(len(drift))
    for k in range(1, len(drift)):
        for i in range(law[2]):
            z[i] = call_flow(law[1], z[i], float(i), drift[k - 1], drift[k], numbers.ctypes.data)
            out[k] += z[i]
    return out
