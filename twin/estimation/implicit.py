"""The force of one law over a part of a sample, which moves the port that it depends on.

With displacement and rate (b, s) where the part begins and (d + ed f, v + ev f) where it ends, the
force f is that of the middle of the motion,

    f = law((b + d + ed f) / 2, s + a (v + ev f - s), (z + z+) / 2, t),  z+ = flow(z, b, d + ed f),

with a = 1/2 the implicit midpoint rule, of second order. Where x = -ev law'(0), the slope by the
rate, is above 2 what dry friction should hold would change the sign of its rate from step to step
by it; there a goes to 1, the rule by which friction sticks (Moreau 1988; Hairer and Wanner 1996).

A rate that changes its sign meets two forces in a part: f1 = law(b, s, z) until it is zero, at the
share theta = s / (s - e1) of the part with e1 = v + ev f1, and from there on what the rule says,

    f = w f1 + (1 - w) law(...),  w = (2 a - 1) theta,

or the instant of a jump would be wrong by up to a part, an error of first order.

Where modes are too fast for a part (``yielding`` = 1, else 0), the port gives way to a force as a
spring does, and the rate at the end of a part says little of it. A law sees the mean rate there, of
the displacement, (d + ed f - b) / h: what holds then holds the displacement.
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np

from twin.estimation.laws import call_flow, call_force

SECANTS = 12
"""Secant steps before the bracketed search takes over: smooth laws need two or three."""

BRACKETED = 120
"""Steps of the bracketed search: halving in every other one reaches rounding."""

CLOSE = 1e-12
"""Error, as a share of the scale of force at the port, at which the force is solved."""

WIDENED = 40
"""Times that what brackets the force is widened, twice as far each time: 1e12 of where it began."""

LEAST_SLOPE = 0.1
"""Slope of f - law(f), 1 where the law does nothing, below which a secant is not trusted."""

DIFFERENCE = 1e-7
"""Step of a law's numeric slopes, as a share of the scale of its argument: between rounding
(1e-16 / 1e-7) and curvature (1e-7)."""

BESIDE_CORNERS = 1e-9
"""Step of a memory's numeric slopes, as a share of the scales of force and displacement: it should
not go over a corner, as where a slider yields, that the motion goes over by little, and a sum of
parts that rounding knows to 1e-16 leaves it 1e-7."""

SUDDEN = 4
"""Power of x by which the end takes over: 0.3 % of the begin are left at x = 7, where the force of
a friction that holds should know nothing of an error of the rate that it begins with."""


@numba.njit(nogil=True, cache=True, forceinline=True)
def memory_of(law, z):
    """Return a law's memory, the sum of its parts z."""
    total = 0.0
    for i in range(law[2]):
        total += z[i]
    return total


@numba.njit(nogil=True, cache=True, forceinline=True)
def middle_memory(law, z, before, after, numbers):
    """Return a law's memory in the middle of a change of displacement, from its parts z."""
    total = 0.0
    for i in range(law[2]):
        total += 0.5 * (z[i] + call_flow(law[1], z[i], float(i), before, after, numbers))
    return total


@numba.njit(nogil=True, cache=True)
def rate_share(law, numbers, d, z, ev, t, scale):
    """Return the share a of the rate at the end in the rate that the law sees.

    Args:
        law: addresses of force and flow.
        numbers: address of the law's numbers.
        d: displacement.
        z: memory.
        ev: what the force adds to the rate at the end, a newton.
        t: time [s].
        scale: of rates at the port [m/s].
    """
    h = DIFFERENCE * scale
    above = call_force(law[0], d, h, z, t, numbers)
    x = -ev * (above - call_force(law[0], d, -h, z, t, numbers)) / (2.0 * h)
    return 0.5 if not x > 0.0 else 0.5 + 0.5 / (1.0 + (2.0 / x) ** SUDDEN)


@numba.njit(nogil=True, cache=True)
def until_zero(law, numbers, before, begun, v, z, ev, t, share, yielding):
    """Return the weight w of the force with which a part begins, that force, and the rate e1.

    The arguments are those of ``solve_force``, the share a, and how far the port yields. The weight
    is 0 where the rate does not change its sign.
    """
    if not share > 0.5:
        return 0.0, 0.0, v
    first = call_force(law[0], before, begun, z, t, numbers)
    end = v + ev * first
    if not begun * end < 0.0:
        return 0.0, first, end
    return (1.0 - yielding) * (2.0 * share - 1.0) * begun / (begun - end), first, end


@numba.njit(nogil=True, cache=True)
def middle_force(law, numbers, before, d, v, z, ed, ev, f, t, w, first):
    """Return what the law says of the force of a motion in which it was f.

    The arguments are those of ``solve_force``, but v and ev are of the rate that the law sees.
    """
    after = d + ed * f
    memory = middle_memory(law, z, before, after, numbers)
    then = call_force(law[0], 0.5 * (before + after), v + ev * f, memory, t, numbers)
    return w * first + (1.0 - w) * then


@numba.njit(nogil=True, cache=True)
def seen_rate(before, begun, end, d, share, yielding, part_s):
    """Return the rate that a law sees: of its port, as far as that yields of its displacement.

    It is linear in rate and displacement at the end, (v, d), and so in a force that changes them.
    """
    return (1.0 - yielding) * (begun + share * (end - begun)) + yielding * (d - before) / part_s


@numba.njit(nogil=True, cache=True)
def solve_force(law, numbers, before, begun, d, v, z, ed, ev, guess, slope, t, scales, part_s):
    """Return f as above, and the slope of f - law(f) there.

    Args:
        law: addresses of force and flow.
        numbers: address of the law's numbers.
        before: displacement where the part of the sample begins.
        begun: rate there.
        d: displacement at its end without this force.
        v: rate there.
        z: parts of its memory where it begins, (parts,).
        ed: what this force adds to the displacement at the end, a newton.
        ev: the same of the rate.
        guess: of the force.
        slope: of f - law(f), to begin with.
        t: time of the middle [s].
        scales: of force, displacement and rate at the port, and how far it yields, (4,).
        part_s: length of the part [s].
    """
    scale, f, yielding, memory = scales[0], guess, scales[3], memory_of(law, z)
    a = rate_share(law, numbers, before, memory, (1.0 - yielding) * ev, t, scales[2])
    w, first, _ = until_zero(law, numbers, before, begun, v, memory, ev, t, a, yielding)
    v = seen_rate(before, begun, v, d, a, yielding, part_s)
    ev = seen_rate(0.0, 0.0, ev, ed, a, yielding, part_s)
    error = f - middle_force(law, numbers, before, d, v, z, ed, ev, f, t, w, first)
    for _ in range(SECANTS):
        if abs(error) <= CLOSE * max(scale, abs(f)):
            return f, slope
        step = -error / slope
        moved = f + step - middle_force(law, numbers, before, d, v, z, ed, ev, f + step, t, w,
                                        first)  # fmt: skip
        secant = (moved - error) / step
        f, error = f + step, moved
        if not secant > LEAST_SLOPE:
            break
        slope = secant
    if abs(error) <= CLOSE * max(scale, abs(f)):
        return f, slope
    return _bracketed(law, numbers, before, d, v, z, ed, ev, t, scale, w, first), 1.0


@numba.njit(nogil=True, cache=True)
def _bracketed(law, numbers, before, d, v, z, ed, ev, t, scale, w, first):
    """Return f by bisection and false position (Illinois, 1971) in turn.

    Where a law opposes the motion the slope of f - law(f) is 1 at least: f lies between any force
    and what the law says of that. Elsewhere it is looked for twice as far, and again.
    """
    a = w * first
    error_a = a - middle_force(law, numbers, before, d, v, z, ed, ev, a, t, w, first)
    reach, b, error_b = error_a, a, error_a
    for _ in range(WIDENED):
        b = a - reach
        error_b = b - middle_force(law, numbers, before, d, v, z, ed, ev, b, t, w, first)
        if not error_a * error_b > 0.0:
            break
        reach *= 2.0
    f = b
    for k in range(BRACKETED):
        if abs(error_b - error_a) <= 1e-300 or error_a * error_b > 0.0 or k % 2:
            f = 0.5 * (a + b)
        else:
            f = b - error_b * (b - a) / (error_b - error_a)
        error = f - middle_force(law, numbers, before, d, v, z, ed, ev, f, t, w, first)
        if abs(error) <= CLOSE * max(scale, abs(f)) or abs(b - a) <= CLOSE * scale * 1e-3:
            break
        if error * error_b < 0.0:
            a, error_a = b, error_b
        else:
            error_a *= 0.5
        b, error_b = f, error
    return f


@numba.njit(nogil=True, cache=True)
def force_slopes(law, row, steps, d, v, z, t, scale, out):
    """Fill the slopes of a force: by displacement, rate, memory, then by its numbers, (3 + most,).

    Args:
        law: addresses of force and flow.
        row: numbers of the law, (most,).
        steps: of the numbers' differences; zero where they do not vary, (most,).
        d: displacement.
        v: rate.
        z: memory.
        t: time.
        scale: of force, displacement and rate, (3,).
        out: filled.
    """
    at = row.ctypes.data
    here = call_force(law[0], d, v, z, t, at)
    h = DIFFERENCE * scale[1]
    out[0] = (call_force(law[0], d + h, v, z, t, at) - here) / h
    h = DIFFERENCE * scale[2]
    out[1] = (call_force(law[0], d, v + h, z, t, at) - here) / h
    out[2] = 0.0
    if law[1]:
        h = DIFFERENCE * scale[0]
        out[2] = (call_force(law[0], d, v, z + h, t, at) - here) / h
    for q in range(len(row)):
        out[3 + q] = 0.0
        if steps[q] != 0.0:
            kept = row[q]
            row[q] = kept + steps[q]
            out[3 + q] = (call_force(law[0], d, v, z, t, at) - here) / steps[q]
            row[q] = kept


@numba.njit(nogil=True, cache=True)
def flow_slopes(law, row, steps, z, before, after, scale, out):
    """Fill the slopes of the parts of a memory: by itself, displacement before and after, ...

    ... then by the law's numbers, (parts, 3 + most). Arguments as those of ``force_slopes``, but z,
    the parts, (parts,). Where nothing moves, the memory is what it was, whichever way its law bends
    there.
    """
    at = row.ctypes.data
    for i in range(law[2]):
        part, slopes = float(i), out[i]
        if before == after:
            h = BESIDE_CORNERS * scale[1]
            ahead = call_flow(law[1], z[i], part, before, after + h, at)
            slopes[:] = 0.0
            slopes[0] = 1.0
            slopes[2] = (ahead - call_flow(law[1], z[i], part, before, after - h, at)) / (2.0 * h)
            slopes[1] = -slopes[2]
            continue
        here = call_flow(law[1], z[i], part, before, after, at)
        h = BESIDE_CORNERS * scale[0]
        slopes[0] = (call_flow(law[1], z[i] + h, part, before, after, at) - here) / h
        h = BESIDE_CORNERS * scale[1]
        slopes[1] = (call_flow(law[1], z[i], part, before + h, after, at) - here) / h
        slopes[2] = (call_flow(law[1], z[i], part, before, after + h, at) - here) / h
        for q in range(len(row)):
            slopes[3 + q] = 0.0
            if steps[q] != 0.0:
                kept = row[q]
                row[q] = kept + steps[q]
                slopes[3 + q] = (call_flow(law[1], z[i], part, before, after, at) - here) / steps[q]
                row[q] = kept


@numba.njit(nogil=True, cache=True)
def number_steps(dnumbers):
    """Return steps for the differences by the laws' numbers, (l, most): zero where none varies."""
    laws, most, p = dnumbers.shape
    out = np.zeros((laws, most))
    for j in range(laws):
        for q in range(most):
            for a in range(p):
                out[j, q] = max(out[j, q], DIFFERENCE * abs(dnumbers[j, q, a]))
    return out
