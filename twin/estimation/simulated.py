"""Forces of laws along a simulation, seen through an analyser's filter, and their sensitivities.

An analyser's low-pass h shows a linear structure as it is, for it filters inputs and outputs
alike: h*y = G (h*u). A law's force, which nobody measures, it shows filtered as well:
h*y = G (h*u + h*f). Where a law jumps that is far from f itself. The filter reaches to both sides,
so it needs forces of instants that the outputs have not told of yet: those of a simulation,

    x+ = step (x, u, u+, f),    f = law(x),    over a part of a sample,

and the predictor takes h*f as an input beside the measured ones. Predictions so made are as honest
as any (Dawid 1984): nothing of them knows the outputs that they are compared with.
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from twin.estimation.coupled import force_derivatives, solve_forces
from twin.estimation.implicit import number_steps
from twin.estimation.low_pass import around
from twin.estimation.products import add_contracted, add_product, add_row, along
from twin.estimation.stepping import FAR, derivatives_at_ports, ports_at, remember

Array = NDArray[np.float64]


@numba.njit(nogil=True, cache=True)
def simulate(
    laws, step, near, ports, numbers, fine, x0, z0, begin_s, steps, step_s, scales, dstep,
    dnumbers, dx0, f_out, df_out, z_out, moved_out,
):  # fmt: skip
    """Fill the forces of the laws, and their derivatives, over the parts of the samples.

    Shapes: n states, r inputs, l laws, p unknowns.

    In the order of the arguments:
        laws: addresses of forces and flows, and parts of memory, (l, 3).
        step: over one part of a sample, by (x, u, u+, f), (n, n + 2 r + l).
        near: the first state that moves each state, and that behind the last one, (n, 2).
        ports: displacements, then rates, at the laws' ports, (2 l, n).
        numbers: of the laws, (l, most).
        fine: inputs where each part of a sample begins, (samples steps, r); the last ones stay.
        x0, z0: state (n,) and memories (l, parts) before the first sample.
        begin_s, steps, step_s: time of the first sample, parts of a sample, sampling interval.
        scales: of force, displacement and rate at each port, and how far it yields, (l, 4).
        dstep, dnumbers: derivatives with respect to the first of the unknowns, in the last axis.
        dx0: of the first state, (n, p).
        f_out, df_out: filled, (parts, l), (parts, l, p).
        z_out: memories before each sample, filled, (samples, l, parts).
        moved_out: displacements, then rates, at the ports where each part begins and where the last
            one ends, filled, (parts + 1, 2 l).
    """
    last, r = len(fine) - 1, fine.shape[1]
    n, p, count = len(x0), dx0.shape[1], len(laws)
    first_f, part_s = n + 2 * r, step_s / steps
    c, free = np.zeros(step.shape[1]), np.zeros(n)
    X, dfree = dx0.copy(), np.zeros((n, p))
    z, dz, df = z0.copy(), np.zeros((*z0.shape, p)), np.zeros((count, p))
    # displacements, then rates, at the ports: where a part begins, where it ends, derivatives
    begun, ended = np.zeros(2 * count), np.zeros(2 * count)
    dbegun, dended = np.zeros((2 * count, p)), np.zeros((2 * count, p))
    solved = np.ones(count)
    slopes, coupled = np.zeros(3 + numbers.shape[1]), np.zeros((count, count))
    memory_slopes = np.zeros((*z0.shape, 3 + numbers.shape[1]))
    push = ports @ np.ascontiguousarray(step[:, first_f:])
    varied = number_steps(dnumbers)
    c[:n] = x0
    ports_at(ports, c, n, begun)
    derivatives_at_ports(ports, X, n, dended)
    for place in range(len(f_out)):
        k, part = place // steps, place % steps
        if part == 0 and place <= last:
            z_out[k] = z
        moved_out[place] = begun
        for i in range(r):
            c[n + i] = fine[min(place, last), i]
            c[n + r + i] = fine[min(place + 1, last), i]
        for i in range(n):
            free[i] = along(step[i, n:], c[n:], 2 * r)
            for s in range(near[i, 0], near[i, 1]):
                free[i] += step[i, s] * c[s]
        t = begin_s + (k + (part + 0.5) / steps) * step_s
        ports_at(ports, free, n, ended)
        solve_forces(laws, numbers, push, begun, ended, z, solved, t, scales, c, first_f, part_s)
        if p:
            dfree[:] = 0.0
            for i in range(n):
                low, high = near[i]
                add_row(dfree[i], step[i], low, X[low:], high - low)
            add_contracted(dfree, dstep, c)
            dbegun[:] = dended
            derivatives_at_ports(ports, dfree, n, dended)
            force_derivatives(laws, numbers, varied, push, begun, ended, z, t, scales, c, first_f,
                              part_s, dbegun, dended, dz, dnumbers, df, memory_slopes, slopes,
                              coupled)  # fmt: skip
            add_product(dfree, step, first_f, df, count)
            add_product(dended, push, 0, df, count)
            X[:] = dfree
            df_out[place] = df
        for j in range(count):
            f_out[place, j] = c[first_f + j]
        for i in range(n):
            for j in range(count):
                free[i] += step[i, first_f + j] * c[first_f + j]
            c[i] = min(max(free[i], -FAR), FAR)
        ports_at(ports, c, n, ended)
        remember(laws, numbers, ended, z, begun, dbegun, dended, dz, dnumbers, memory_slopes)
    moved_out[-1] = begun


def filtered(f: Array, df: Array, weights: Array, steps: int, samples: int) -> tuple[Array, Array]:
    """Return the weighed sums of forces around each sample, and of their derivatives.

    Before the first sample the forces are those at the end of the first one.

    Args:
        f: over the parts, (parts, l).
        df: their derivatives, (parts, l, p).
        weights: of the moments of what is around a sample (``low_pass.moments``), (w, taps).
        steps: parts of a sample.
        samples: how many.

    Returns:
        (samples, w l) and (samples, w l, p).
    """
    count, p = df.shape[1:]
    every = np.concatenate([f[:, :, None], df], axis=2).reshape(len(f), -1)
    with np.errstate(all="ignore"):  # laws that run away are hopeless, filtered or not
        out = around(every[steps - 1], every, weights, steps, samples)
    out = out.reshape(samples, len(weights) * count, 1 + p)
    return out[:, :, 0], out[:, :, 1:]
