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


@cache
def _compiled(law: Law) -> tuple[Any, Any]:
    """Return the compiled force and flow; they are kept, because only their addresses travel."""
    force = _with_one_signature(law.force, "d, v, z, t", law.count, FORCE)
    if law.flow is None:
        return force, None
    return force, _with_one_signature(law.flow, "z, before, after", law.count, FLOW)


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
    """Return where each law's compiled force and flow lie, (l, 2); 0 without memory."""
    out = np.zeros((len(laws), 2), np.int64)
    for row, law in zip(out, laws, strict=True):
        force, flow = _compiled(law)
        row[0] = force.address
        row[1] = flow.address if flow is not None else 0
    return out


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
def call_flow(context, address, z, before, after, numbers):
    """Call a compiled flow; ``numbers`` is the address of its numbers."""
    return _caller(3)(context, address)


def memory_along(law: Law, numbers: Array, drift: Array) -> Array:
    """Return a law's memory along a displacement that begins without memory, (samples,).

    Args:
        law: the law.
        numbers: of the law, (count,).
        drift: displacement at its port [m or rad], (samples,).
    """
    flow = addresses((law,))[0, 1]
    if not flow:
        return np.zeros(len(drift))
    return np.asarray(_followed(flow, np.array(numbers, float), np.ascontiguousarray(drift)))


@numba.njit(nogil=True, cache=True)
def _followed(flow, numbers, drift):
    out = np.zeros(len(drift))
    z = 0.0
    for k in range(1, len(drift)):
        z = call_flow(flow, z, drift[k - 1], drift[k], numbers.ctypes.data)
        out[k] = z
    return out
