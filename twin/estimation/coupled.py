"""The forces of several laws over a part of a sample, which act on one another, and derivatives."""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np

from twin.estimation.implicit import (
    flow_slopes,
    force_slopes,
    memory_of,
    middle_memory,
    rate_share,
    seen_rate,
    solve_force,
    until_zero,
)
from twin.estimation.products import add_row, set_slopes

SWEEPS = 20
"""Gauss-Seidel sweeps at most over laws that act on one another."""

SETTLED = 1e-11
"""Change of every force, as a share of its scale, with which these sweeps have converged."""

WIDER = 1e3
"""How much wider the differences of a difference are: between rounding, (1e-16 / 1e-7) / 1e-4, and
curvature, 1e-4."""


@numba.njit(nogil=True, cache=True, forceinline=True)
def solve_forces(
    laws, numbers, push, begun, free, z, solved, t, scales, c, first, part_s
):  # fmt: skip
    """Set c[first:], (l,), to the laws' forces in the middle of a part of a sample.

    Args:
        laws: addresses of forces and flows, and parts of memory, (l, 3).
        numbers: of the laws, (l, most).
        push: what the forces add to displacements and rates at the ports, (2 l, l).
        begun: displacements, then rates, at the ports where the part begins, (2 l,).
        free: the same at its end without the laws, (2 l,).
        z: memories where it begins, (l, parts).
        solved: slope of each force's equation; kept from part to part, (l,).
        t: time of the middle [s].
        scales: of force, displacement and rate at each port, and how far it yields, (l, 4).
        c: holds forces near to them, with which it begins.
        first: where in c they are.
        part_s: length of the part [s].
    """
    count = len(laws)
    for _ in range(SWEEPS):
        settled = True
        for j in range(count):
            d, v = free[j], free[count + j]
            for b in range(count):
                if b != j:
                    d += push[j, b] * c[first + b]
                    v += push[count + j, b] * c[first + b]
            kept = c[first + j]
            c[first + j], solved[j] = solve_force(
                laws[j], numbers[j].ctypes.data, begun[j], begun[count + j], d, v, z[j],
                push[j, j], push[count + j, j], kept, solved[j], t, scales[j], part_s,
            )  # fmt: skip
            size = max(scales[j, 0], abs(kept))
            settled = settled and abs(c[first + j] - kept) <= SETTLED * size
        if count == 1 or settled:
            break


@numba.njit(nogil=True, cache=True, forceinline=True)
def force_derivatives(
    laws, numbers, varied, push, begun, free, z, t, scales, c, first, part_s, dbegun,
    dfree, dz, dnumbers, df, memory_slopes, slopes, coupled,
):  # fmt: skip
    """Fill df, (l, p), the derivatives of these forces, by the implicit function theorem.

    The arguments are those of ``solve_forces``, their derivatives with respect to the unknowns,
    ``varied``, the steps of the numbers' differences (l, most), and ``dfree``, the derivatives of
    displacements and rates at the end at given forces, (2 l, p). The slopes of each memory's flow
    are left in ``memory_slopes``, (l, parts, 3 + most); ``slopes`` and ``coupled`` are room to
    work in.
    """
    count, p = len(laws), df.shape[1]
    coupled[:] = 0.0
    begin, shares = np.zeros(len(slopes)), np.zeros(numbers.shape[1])
    by_memory = np.zeros(z.shape[1])
    for j in range(count):
        d, v = free[j], free[count + j]
        for b in range(count):
            d += push[j, b] * c[first + b]
            v += push[count + j, b] * c[first + b]
        before, by, parts = begun[j], memory_slopes[j], laws[j, 2]
        remembered = memory_of(laws[j], z[j])
        memory = middle_memory(laws[j], z[j], before, d, numbers[j].ctypes.data)
        flow_slopes(laws[j], numbers[j], varied[j], z[j], before, d, scales[j], by)
        yielding, ev, s = scales[j, 3], push[count + j, j], begun[count + j]
        held = 1.0 - yielding
        a = rate_share(laws[j], numbers[j].ctypes.data, before, remembered, held * ev, t,
                       scales[j, 2])  # fmt: skip
        rate = seen_rate(before, s, v, d, a, yielding, part_s)
        force_slopes(laws[j], numbers[j], varied[j], 0.5 * (before + d), rate, memory, t, scales[j],
                     slopes)  # fmt: skip
        shares[:] = 0.0
        for q in range(numbers.shape[1]):
            if varied[j, q] != 0.0:  # the share depends on the numbers, too
                kept, step = numbers[j, q], WIDER * varied[j, q]
                numbers[j, q] = kept + step
                moved = rate_share(laws[j], numbers[j].ctypes.data, before, remembered, held * ev,
                                   t, scales[j, 2])  # fmt: skip
                numbers[j, q] = kept
                shares[q] = (moved - a) / step
                slopes[3 + q] += held * slopes[1] * (v - s) * shares[q]
        half_d, half_z, end_v = 0.5 * slopes[0], 0.5 * slopes[2], held * a * slopes[1]
        moving = yielding / part_s * slopes[1]
        by_start, by_end, without = half_d - moving, half_d + moving, 0.0
        for i in range(parts):
            by_memory[i] = half_z * (1.0 + by[i, 0])
            by_start += half_z * by[i, 1]
            by_end += half_z * by[i, 2]
            for q in range(3, len(slopes)):
                slopes[q] += half_z * by[i, q]
        slopes[0], slopes[1], slopes[2] = by_start, held * slopes[1] - end_v, 0.0
        f = c[first + j]
        w, f1, e1 = until_zero(laws[j], numbers[j].ctypes.data, before, s, v - ev * f, remembered,
                               ev, t, a, yielding)  # fmt: skip
        if 0.0 < w < 1.0:  # the force that the part begins with, and until when
            by_end, end_v = (1.0 - w) * by_end, (1.0 - w) * end_v
            late = held * (2.0 * a - 1.0) * (f1 - f) / ((1.0 - w) * (s - e1) ** 2)
            without = late * s
            force_slopes(laws[j], numbers[j], varied[j], before, s, remembered, t, scales[j],
                         begin)  # fmt: skip
            for q in range(len(slopes)):
                slopes[q] = (1.0 - w) * slopes[q] + (w + without * ev) * begin[q]
            for i in range(parts):
                by_memory[i] = (1.0 - w) * by_memory[i] + slopes[2]
            slopes[1], slopes[2] = slopes[1] - late * e1, 0.0
            for q in range(len(shares)):
                slopes[3 + q] += held * 2.0 * shares[q] * s / (s - e1) * (f1 - f) / (1.0 - w)
        set_slopes(df[j], slopes, dbegun[j], dbegun[count + j], dz[j, 0], dnumbers[j])
        add_row(df[j], by_memory, 0, dz[j], parts)
        for q in range(p):
            df[j, q] += by_end * dfree[j, q] + (end_v + without) * dfree[count + j, q]
        coupled[j, j] += 1.0
        for b in range(count):
            coupled[j, b] -= by_end * push[j, b] + end_v * push[count + j, b]
            if b != j:
                coupled[j, b] -= without * push[count + j, b]
    _eliminate(coupled, df)


@numba.njit(nogil=True, cache=True, forceinline=True)
def _eliminate(M, X):
    """Replace X by M^-1 X (Gauss-Jordan; the laws' own slopes make M diagonally heavy)."""
    count, p = X.shape
    for j in range(count):
        pivot = max(M[j, j], 1e-3)
        for b in range(count):
            M[j, b] /= pivot
        for a in range(p):
            X[j, a] /= pivot
        for i in range(count):
            g = M[i, j]
            if i != j and g != 0.0:
                for b in range(count):
                    M[i, b] -= g * M[j, b]
                for a in range(p):
                    X[i, a] -= g * X[j, a]
