"""Forces that jump within a part of a sample: what their means over it do not tell.

A force that is f1 until the share w of a part of length h and f2 from there on has the mean f of
both and, about the middle of the part, the first moment

    -h^2 (f1 - f2) w (1 - w) / 2 = -h^2 (f1 - f) w / 2.

It moves what is pushed further than the mean does, by as much as the part before would with
(f1 - f) w / 2 more and this one with as much less.

An analyser's filter is applied to means, and makes up for what smooth forces lose by them,
sinc(x / 2) at an angle x a part. Of the jump it makes so (f1 - f2) / (-i x) with 1/12 instead of
(w - 1/2)^2 in the second order of x. That is made good by

    (f1 - f2) (w (1 - w) - 1/6) / 4

more in the part before and as much less in the one behind (subcell resolution: Harten 1989).
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from twin.estimation.implicit import force_slopes, memory_of, rate_share
from twin.estimation.products import set_slopes

Array = NDArray[np.float64]

WIDER = 1e3
"""How much wider the differences of a difference are: between rounding, (1e-16 / 1e-7) / 1e-4, and
curvature, 1e-4."""


@numba.njit(nogil=True, cache=True)
def share_slopes(law, row, varied, d, z, ev, t, scale, a, out):
    """Fill the slopes of the share ``rate_share`` by the law's numbers, (most,).

    Args:
        law: addresses of force and flow.
        row: numbers of the law, (most,).
        varied: steps of the numbers' differences; zero where they do not vary, (most,).
        d: displacement.
        z: memory.
        ev: what the force adds to the rate at the end, a newton.
        t: time [s].
        scale: of rates at the port [m/s].
        a: the share.
        out: filled.
    """
    for q in range(len(row)):
        out[q] = 0.0
        if varied[q] != 0.0:
            kept, step = row[q], WIDER * varied[q]
            row[q] = kept + step
            out[q] = (rate_share(law, row.ctypes.data, d, z, ev, t, scale) - a) / step
            row[q] = kept


@numba.njit(nogil=True, cache=True)
def begin_derivatives(
    law, row, varied, begun, rate, end, z, ev, t, scales, dbegun, drate, dend, dz, dnumbers, df,
    first, f, dw, dfirst,
):  # fmt: skip
    """Fill the derivatives of the share w, (p,), and of the force f1, (p,), of a jump.

    Args:
        law: addresses of force and flow, and parts of memory, (3,).
        row: numbers of the law, (most,).
        varied: steps of the numbers' differences, (most,).
        begun: displacement where the part begins.
        rate: there.
        end: rate where it ends.
        z: memory where it begins, (parts,).
        ev: what the force adds to the rate at the end, a newton.
        t: time of the middle [s].
        scales: of force, displacement and rate at the port, and how far it yields, (4,).
        dbegun: derivatives of the displacement, (p,).
        drate: of the rate where the part begins.
        dend: of that where it ends.
        dz: of the memory, (parts, p).
        dnumbers: of the numbers, (most, .).
        df: of the mean force, (p,).
        first: the force f1.
        f: the mean.
        dw: filled.
        dfirst: filled.
    """
    held, remembered, most = 1.0 - scales[3], memory_of(law, z), len(row)
    a = rate_share(law, row.ctypes.data, begun, remembered, held * ev, t, scales[2])
    shares, slopes = np.zeros(most), np.zeros(3 + most)
    share_slopes(law, row, varied, begun, remembered, held * ev, t, scales[2], a, shares)
    force_slopes(law, row, varied, begun, rate, remembered, t, scales, slopes)
    dremembered = np.zeros_like(dfirst)
    for i in range(law[2]):
        dremembered += dz[i]
    set_slopes(dfirst, slopes, dbegun, drate, dremembered, dnumbers)
    stopped = end + ev * (first - f)  # with the force f1 throughout
    share = held * (2.0 * a - 1.0) / (rate - stopped) ** 2
    for k in range(len(dw)):
        dstopped = dend[k] + ev * (dfirst[k] - df[k])
        dw[k] = share * (rate * dstopped - stopped * drate[k])
    for q in range(most):
        by = held * 2.0 * shares[q] * rate / (rate - stopped)
        for k in range(dnumbers.shape[1]):
            dw[k] += by * dnumbers[q, k]


@numba.njit(nogil=True, cache=True)
def push_earlier(step, dstep, n, first_f):
    """Return what forces do more if they come a part earlier, (n, l), and derivatives, (n, l, q).

    Args:
        step: over one part, by the state, inputs and forces, (n, .).
        dstep: its derivatives, (n, ., q).
        n: states.
        first_f: where the forces are.
    """
    S, P = np.ascontiguousarray(step[:, :n]), np.ascontiguousarray(step[:, first_f:])
    earlier = S @ P - P
    dearlier = np.zeros((n, P.shape[1], dstep.shape[2]))
    for k in range(dstep.shape[2]):
        dP = np.ascontiguousarray(dstep[:, first_f:, k])
        dearlier[:, :, k] = np.ascontiguousarray(dstep[:, :n, k]) @ P + S @ dP - dP
    return earlier, dearlier


def as_early(f: Array, early: Array) -> Array:
    """Return forces over parts that a filter takes to jump as early within a part as they do.

    Args:
        f: means over the parts, or their derivatives, (parts, ...).
        early: what the part before each has more, and the one behind less, (parts, ...).
    """
    out = f.copy()
    out[:-1] += early[1:]
    out[1:] -= early[:-1]
    return out
