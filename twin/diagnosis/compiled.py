"""The stepping of a filter with laws, compiled for the laws at hand.

Numba compiles a law as it stands in its mechanism's file: the mathematics is written once, for
arrays and for numbers alike.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numba
import numpy as np

from twin.mechanisms.mechanism import Law

MOST_NUMBERS = 24
"""Fields that a law may have."""

SWEEPS = 12
"""Where several storeys stick, each feels what the others hold: so often in turn (Gauss-Seidel)."""


# pointers to compiled functions are old enough, whatever Numba calls them
warnings.filterwarnings("ignore", "First-class function type feature")

REAL = numba.float64
NUMBERS = numba.types.CPointer(REAL)
FORCE = REAL(REAL, REAL, REAL, REAL, NUMBERS)
FLOW = REAL(REAL, REAL, REAL, NUMBERS)


def _compiled(function: Any, arguments: str, count: int, fallback: str, signature: Any) -> Any:
    """Return a pointer to the compiled function; numbers in one array give all one type."""
    if function is None:
        line, names = fallback, {}
    else:
        numbers = "".join(f", p[{i}]" for i in range(count))
        line, names = f"law({arguments}{numbers})", {"law": numba.njit(nogil=True)(function)}
    exec(f"def chosen({arguments}, p):\n    return {line}", names)
    return numba.cfunc(signature)(names["chosen"])


@lru_cache(maxsize=128)
def _law(law: type[Law], count: int) -> tuple[Any, Any]:
    """Return force and flow of a law, compiled once a process."""
    return (
        _compiled(law.law, "d, v, z, t", count, "0.0 * d", FORCE),
        _compiled(law.flow, "z, before, after", count, "z", FLOW),
    )


@lru_cache(maxsize=1)
def _no_law() -> tuple[Any, Any]:
    return (
        _compiled(None, "d, v, z, t", 0, "0.0 * d", FORCE),
        _compiled(None, "z, before, after", 0, "z", FLOW),
    )


def stepper(laws: tuple[type[Law], ...], counts: tuple[int, ...]) -> Callable[..., Any]:
    """Return the compiled loop over one trial and all variants, for laws of these classes.

    The loop takes the laws as pointers, so that it is compiled once and kept on disk.

    Args:
        laws: the classes, in order.
        counts: how many numbers each law takes.
    """
    pairs = [_law(law, count) for law, count in zip(laws, counts, strict=True)]
    pairs = pairs or [_no_law()]  # the type of an empty tuple says nothing of its members
    forces, flows = (tuple(column) for column in zip(*pairs, strict=True))
    return partial(step_through, forces, flows)


@numba.njit(nogil=True, cache=True)
def hold(sticks, numbers, pull_x, pull_u, pull_f, rate, x, u, h, f, z):  # type: ignore[no-untyped-def]
    """Fill in the forces of what sticks or slides at this instant: at rest, what holds it there.

    A rate that is left decays over ``regular_rate`` / (F w) [s], or within a step ``h``.
    """
    for _ in range(SWEEPS if sticks.sum() > 1 else 1):
        for j in range(len(f)):
            if not sticks[j]:
                continue
            speed, free = 0.0, 0.0
            for i in range(len(x)):
                speed += rate[j, i] * x[i]
                free += pull_x[j, i] * x[i]
            for i in range(len(u)):
                free += pull_u[j, i] * u[i]
            for i in range(len(f)):
                if i != j:
                    free += pull_f[j, i] * f[i]
            w, most = -pull_f[j, j], numbers[j, 0]
            stop = min(most / numbers[j, 1], 1 / (w * h))
            f[j] = min(max(free / w + speed * stop, -most), most)
            z[j] = f[j]


@numba.njit(nogil=True, cache=True)
def hold_over(sticks, numbers, E0, E1, rate, x, free, f):  # type: ignore[no-untyped-def]
    """Add to the state after a step what friction, constant over it, does: at most it stops."""
    for j in range(len(f)):
        if sticks[j]:
            f[j] = 0.0
    for _ in range(SWEEPS if sticks.sum() > 1 else 1):
        for j in range(len(f)):
            if not sticks[j]:
                continue
            before, after, own = 0.0, 0.0, 0.0
            for i in range(len(x)):
                before += rate[j, i] * x[i]
                after += rate[j, i] * free[i]
                own -= rate[j, i] * (E0[i, j] + E1[i, j])
            most = numbers[j, 0]
            stop = min(most / numbers[j, 1], 1 / own)
            wanted = (after + own * f[j] - before) / own + before * stop
            wanted = min(max(wanted, -most), most)
            for i in range(len(x)):
                free[i] += (E0[i, j] + E1[i, j]) * (wanted - f[j])
            f[j] = wanted


@numba.njit(nogil=True, cache=True)
def step_through(  # type: ignore[no-untyped-def]
    forces, flows, A, B0, B1, E0, E1, C, D, F, drift, rate, pull_x, pull_u, pull_f, sticks, Kf, Kw,
    u, smooth, y, start, limits, numbers, memory, begin_s, steps, step_s, ramps,
    innovations, states, memories,
):  # fmt: skip
    """Fill innovations, states and memories of one trial, all variants.

    The memory of a law that sticks is its force.
    """
    count = F.shape[2]
    variants, n = A.shape[0], A.shape[1]
    samples, m = y.shape[1], y.shape[2]
    r = u.shape[2]
    h = step_s / steps
    x, xc, free, later = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    f, g, e = np.zeros(count), np.zeros(count), np.zeros(m)
    z, zl = np.zeros(count), np.zeros(count)
    for v in range(variants):
        w = v if u.shape[0] > 1 else 0
        x[:] = start
        z[:] = memory
        for j in range(count):
            d = 0.0
            s = 0.0
            for i in range(n):
                d += drift[v, j, i] * x[i]
                s += rate[v, j, i] * x[i]
            f[j] = forces[j](d, s, z[j], begin_s, numbers[v, j].ctypes)
        for k in range(samples):
            t = begin_s + k * step_s
            hold(sticks, numbers[v], pull_x[v], pull_u[v], pull_f[v], rate[v], x, u[w, k], h, f, z)
            for o in range(m):
                predicted = 0.0
                for i in range(n):
                    predicted += C[v, o, i] * x[i]
                for i in range(r):
                    predicted += D[v, o, i] * u[w, k, i]
                for j in range(count):
                    predicted += F[v, o, j] * f[j]
                limit = limits[v, o]
                predicted = min(max(predicted, -limit), limit)
                missing = np.isnan(y[w, k, o])
                e[o] = 0.0 if missing else y[w, k, o] - predicted
                innovations[v, k, o] = e[o]
            for j in range(count):
                memories[v, k, j] = z[j]
            for i in range(n):
                states[v, k, i] = x[i]
                add = 0.0
                for o in range(m):
                    add += Kf[i, o] * e[o]
                xc[i] = x[i] + add
            for j in range(count):
                d0 = 0.0
                d = 0.0
                s = 0.0
                for i in range(n):
                    d0 += drift[v, j, i] * x[i]
                    d += drift[v, j, i] * xc[i]
                    s += rate[v, j, i] * xc[i]
                z[j] = flows[j](z[j], d0, d, numbers[v, j].ctypes)
                f[j] = forces[j](d, s, z[j], t, numbers[v, j].ctypes)
            for i in range(n):
                x[i] = xc[i]
            last = min(k + 1, samples - 1)
            for q in range(steps):
                low = q / steps
                high = (q + 1) / steps
                for i in range(n):
                    total = 0.0
                    for l in range(n):  # noqa: E741
                        total += A[v, i, l] * x[l]
                    for l in range(r):  # noqa: E741
                        a = smooth[w, k, l]
                        b = ramps[l] * (smooth[w, last, l] - a)
                        total += B0[v, i, l] * (a + low * b) + B1[v, i, l] * (a + high * b)
                    if q == steps - 1:
                        for o in range(m):
                            total += Kw[i, o] * e[o]
                    for j in range(count):
                        if not sticks[j]:
                            total += (E0[v, i, j] + E1[v, i, j]) * f[j]
                    free[i] = total
                hold_over(sticks, numbers[v], E0[v], E1[v], rate[v], x, free, f)
                for j in range(count):
                    if sticks[j]:
                        g[j] = f[j]
                        continue
                    d0 = 0.0
                    d = 0.0
                    s = 0.0
                    for i in range(n):
                        d0 += drift[v, j, i] * x[i]
                        d += drift[v, j, i] * free[i]
                        s += rate[v, j, i] * free[i]
                    zl[j] = flows[j](z[j], d0, d, numbers[v, j].ctypes)
                    g[j] = forces[j](d, s, zl[j], t + (q + 1) * h, numbers[v, j].ctypes)
                for i in range(n):
                    total = free[i]
                    for j in range(count):
                        total += E1[v, i, j] * (g[j] - f[j])
                    later[i] = min(max(total, -1e6), 1e6)
                for j in range(count):
                    d0 = 0.0
                    d = 0.0
                    for i in range(n):
                        d0 += drift[v, j, i] * x[i]
                        d += drift[v, j, i] * later[i]
                    z[j] = flows[j](z[j], d0, d, numbers[v, j].ctypes)
                    # the force at the corrected end differs by the step's third order
                    f[j] = g[j]
                for i in range(n):
                    x[i] = later[i]


@numba.njit(nogil=True, cache=True)
def march(columns, g, x):  # type: ignore[no-untyped-def]
    """Fill x(k+1) = F x(k) + g(k) from x(0), (samples, n); F is given by its columns."""
    n = len(columns)
    for k in range(len(x) - 1):
        for i in range(n):
            x[k + 1, i] = g[k, i]
        for j in range(n):
            now = x[k, j]
            for i in range(n):
                x[k + 1, i] += columns[j, i] * now


@lru_cache(maxsize=64)
def innovator(n: int, m: int) -> Callable[..., Any]:
    """Return the compiled loop of several linear systems with n states and m outputs.

    It fills out(k) = e(k) - C x(k) along x(k+1) = F x(k) + g(k). Loops of known length are
    unrolled, and the state stays in registers.
    """

    @numba.njit(nogil=True, cache=True)
    def innovate(F, C, g, e, start, out):  # type: ignore[no-untyped-def]
        x, after = np.zeros(n), np.zeros(n)
        for v in range(len(F)):
            for i in range(n):
                x[i] = start[i]
            for k in range(len(g)):
                for o in range(m):
                    total = e[k, v, o]
                    for j in range(n):
                        total -= C[v, o, j] * x[j]
                    out[v, k, o] = total
                for i in range(n):
                    total = g[k, v, i]
                    for j in range(n):
                        total += F[v, i, j] * x[j]
                    after[i] = total
                for i in range(n):
                    x[i] = after[i]

    return innovate


def numbers_of(variants: list[tuple[Law, ...]]) -> Any:
    """Return the laws' numbers, (variants, laws, MOST_NUMBERS)."""
    count = max(len(variants[0]), 1)
    out = np.zeros((len(variants), count, MOST_NUMBERS))
    for v, laws in enumerate(variants):
        for j, law in enumerate(laws):
            out[v, j, : len(law.numbers)] = law.numbers
    return out
