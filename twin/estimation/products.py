"""Compiled sums of products whose innermost, contiguous axis runs over the unknowns."""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba


@numba.njit(nogil=True, cache=True, forceinline=True)
def add_row(out, row, first, X, count):
    """Add sum_s row[first + s] X[s] to out, (p,), over the first ``count`` rows of X (., p).

    X may have fewer unknowns than out. Four rows at a time: out is loaded and stored once for them.
    """
    p = X.shape[1]
    whole = count - count % 4
    for s in range(0, whole, 4):
        g0, g1, g2, g3 = row[first + s], row[first + s + 1], row[first + s + 2], row[first + s + 3]
        for a in range(p):
            out[a] += g0 * X[s, a] + g1 * X[s + 1, a] + g2 * X[s + 2, a] + g3 * X[s + 3, a]
    for s in range(whole, count):
        g0 = row[first + s]
        for a in range(p):
            out[a] += g0 * X[s, a]


@numba.njit(nogil=True, cache=True, forceinline=True)
def add_product(out, M, first, X, count):
    """Add M[:, first : first + count] X[:count] to out, (rows, p)."""
    for i in range(len(out)):
        add_row(out[i], M[i], first, X, count)


@numba.njit(nogil=True, cache=True, forceinline=True)
def add_contracted(out, dM, c):
    """Add sum_s dM[i, s] c[s] to out[i], for as many unknowns as dM (rows, terms, .) has."""
    for i in range(len(dM)):
        add_row(out[i], c, 0, dM[i], dM.shape[1])


@numba.njit(nogil=True, cache=True, forceinline=True)
def add_sum(out, g, X, count):
    """Add g sum_s X[s] to out, (p,), over the first ``count`` rows of X (., p)."""
    for s in range(count):
        for a in range(len(out)):
            out[a] += g * X[s, a]


@numba.njit(nogil=True, cache=True, forceinline=True)
def along(row, c, count):
    """Return sum_i row[i] c[i] over the first ``count``."""
    total = 0.0
    for i in range(count):
        total += row[i] * c[i]
    return total


@numba.njit(nogil=True, cache=True, forceinline=True)
def set_slopes(out, slopes, first, second, third, dnumbers):
    """Set out, (p,), to the derivatives of a law by those of its arguments.

    Args:
        out: filled; it may be one of the arguments.
        slopes: by the three arguments, then by the numbers, (3 + most,).
        first: derivatives of the first argument, (p,).
        second: of the second.
        third: of the third.
        dnumbers: of the numbers, with respect to the first unknowns, (most, .).
    """
    s, t, u = slopes[0], slopes[1], slopes[2]
    for a in range(len(out)):
        out[a] = s * first[a] + t * second[a] + u * third[a]
    for q in range(len(dnumbers)):
        g = slopes[3 + q]
        if g != 0.0:
            for a in range(dnumbers.shape[1]):
                out[a] += g * dnumbers[q, a]
