"""The compiled one-step predictor with laws inside, and its exact forward sensitivities.

One loop carries the state x and its derivatives X with respect to p unknowns. With
c = (x, n, u, u+, f), state, held disturbances, inputs before and after, forces of the laws over
each part of a sample (``twin.estimation.lifted``),

    x+ = over c          over a sample,
    y  = read (x, u, f)  at a sample,            e = y measured - y,
    (x, n) = (x, 0) + gain T e                   where it was measured,

so that X+ = over C + dover c with C the derivatives of c, and likewise for the others; T is how far
an output is trusted where it is more uncertain than its noise (``likelihood.run``). Laws' forces
follow from the motion that they move themselves (``twin.estimation.implicit``), part after part.
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np

from twin.estimation.coupled import force_derivatives, solve_forces
from twin.estimation.implicit import flow_slopes, force_slopes, memory_of, number_steps
from twin.estimation.laws import call_flow, call_force
from twin.estimation.products import add_contracted, add_product, add_sum, along, set_slopes

FAR = 1e9
"""Bound of the states: a predictor that runs away gives a finite, hopeless likelihood."""


@numba.njit(nogil=True, cache=True)
def predict(
    laws, over, reach, push, read, ports, numbers, gain, trust, doubt, u, between, du, y, x0, z0,
    added, added_at, begin_s, step_s, scales, dover, dreach, dpush, dread, dgain, dnumbers, dx0,
    order, e_out, de_out, x_out, z_out, f_out,
):  # fmt: skip
    """Fill innovations and their derivatives, and the states before each sample.

    Shapes: n states, w held disturbances, r inputs, l laws, m outputs, p unknowns, t gains.

    In the order of the arguments:
        laws: addresses of forces and flows, and parts of memory, (l, 3).
        over, reach, push: what a sample does, as ``Lifted`` has them.
        read: of the outputs, (m, n + r + l).
        ports: displacements, then rates, at the laws' ports, (2 l, n).
        numbers: of the laws, (l, most).
        gain: of state and held disturbances, (t, n + w, m); the last one for all later samples.
        trust: what multiplies the innovations before they correct, (samples, m, m), or empty.
        doubt: derivatives of the innovations' covariances times their inverses, which trust changes
            by, (t, m, m, p), or empty.
        u, between: inputs as the outputs see them, and as they drive the states, (samples, r).
        du: derivatives of the last inputs, (samples, inputs that have some, .): they are held.
        y: measured outputs, (samples, m); NaN where there is none.
        x0, z0: state (n,) and memories (l, parts) before the first sample.
        added, added_at: what comes to the state before a sample, (n,), and which sample.
        begin_s, step_s: time of the first sample, sampling interval.
        scales: of force, displacement and rate at each port, and how far it yields, (l, 4).
        dover, ..., dnumbers: derivatives with respect to the first of the unknowns, these in the
            last axis; with respect to the others they are zero. dgain has all p, and its
            last one is for all later samples.
        dx0: derivatives of the first state, (n, p).
        order: where each unknown's column goes in ``de_out``, (p,).
        e_out, de_out, x_out, z_out, f_out: filled, (samples, m), (samples, m, p), (samples, n),
            (samples, l, parts), (samples, l): the force at each sample.
    """
    samples, m = y.shape
    n, p, count = len(x0), dgain.shape[3], len(laws)
    w, r, steps = gain.shape[1] - n, u.shape[1], len(push)
    first_u, first_f = n + w, n + w + 2 * r
    h = step_s / steps
    # c of a sample, what the outputs are read from, and the derivatives
    c, seen = np.zeros(over.shape[1]), np.zeros(n + r + count)
    X, Y, dnext = np.zeros((n + w, p)), np.zeros((m, p)), np.zeros((n, p))
    e, next_x, weighed = np.zeros(m), np.zeros(n), np.zeros((m, p))
    doubted = len(trust) > 0
    z, df, dz = z0.copy(), np.zeros((count, p)), np.zeros((*z0.shape, p))
    dforces = np.zeros((steps * count, p))
    # displacements and rates at the ports: where a part begins, where it ends, and derivatives
    begun, ended = np.zeros(2 * count), np.zeros(2 * count)
    dbegun, dended = np.zeros((2 * count, p)), np.zeros((2 * count, p))
    solved = np.ones(count)
    slopes, coupled = np.zeros(3 + numbers.shape[1]), np.zeros((count, count))
    memory_slopes = np.zeros((*z0.shape, 3 + numbers.shape[1]))
    varied = number_steps(dnumbers)
    c[:n] = x0
    X[:n] = dx0
    for k in range(samples):
        t = begin_s + k * step_s
        if k == added_at:
            for i in range(n):
                c[i] += added[i]
        # what the outputs should read
        for i in range(n):
            seen[i] = x_out[k, i] = c[i]
        for i in range(r):
            seen[n + i] = u[k, i]
        ports_at(ports, c, n, begun)
        for j in range(count):
            d, v = begun[j], begun[count + j]
            memory = memory_of(laws[j], z[j])
            seen[n + r + j] = call_force(laws[j, 0], d, v, memory, t, numbers[j].ctypes.data)
            f_out[k, j], z_out[k, j] = seen[n + r + j], z[j]
        for o in range(m):
            e[o] = 0.0 if np.isnan(y[k, o]) else y[k, o] - along(read[o], seen, len(seen))
            e_out[k, o] = e[o]
        if p:
            derivatives_at_ports(ports, X, n, dbegun)
            for j in range(count):
                d, v = begun[j], begun[count + j]
                memory = memory_of(laws[j], z[j])
                force_slopes(laws[j], numbers[j], varied[j], d, v, memory, t, scales[j], slopes)
                by_memory, slopes[2] = slopes[2], 0.0
                set_slopes(df[j], slopes, dbegun[j], dbegun[count + j], dz[j, 0], dnumbers[j])
                add_sum(df[j], by_memory, dz[j], laws[j, 2])
            Y[:] = 0.0
            add_product(Y, read, 0, X, n)
            add_product(Y, read, n + r, df, count)
            if len(du):
                add_product(Y, read, n + r - du.shape[1], du[k], du.shape[1])
            add_contracted(Y, dread, seen)
            for o in range(m):
                sign = 0.0 if np.isnan(y[k, o]) else -1.0
                for a in range(p):
                    Y[o, a] *= sign
                    de_out[k, o, order[a]] = Y[o, a]
        # the correction by what was measured, which moves the ports too
        here = gain[min(k, len(gain) - 1)]
        if doubted:
            for o in range(m):
                e[o] = along(trust[k, o], e_out[k], m)
            weighed[:] = 0.0
            add_product(weighed, trust[k], 0, Y, m)
            Y[:] = weighed
            uncertain = False
            if len(doubt):
                for o in range(m):
                    uncertain = uncertain or trust[k, o, o] != 1.0
            if uncertain:
                weighed[:] = 0.0
                add_contracted(weighed, doubt[min(k, len(doubt) - 1)], e)
                Y += weighed
                for o in range(m):
                    for i in range(m):
                        for a in range(p):
                            Y[o, a] -= trust[k, o, i] * weighed[i, a]
        for i in range(n + w):
            c[i] = along(here[i], e, m) + (c[i] if i < n else 0.0)
        if p:
            X[n:] = 0.0
            add_product(X, here, 0, Y, m)
            add_contracted(X, dgain[min(k, len(dgain) - 1)], e)
            derivatives_at_ports(ports, X, n, dended)
            for j in range(count):
                flow_slopes(laws[j], numbers[j], varied[j], z[j], begun[j], along(ports[j], c, n),
                            scales[j], memory_slopes[j])  # fmt: skip
        ports_at(ports, c, n, ended)
        remember(laws, numbers, ended, z, begun, dbegun, dended, dz, dnumbers, memory_slopes)
        if k == samples - 1:
            break
        # to the next sample
        for i in range(r):
            c[first_u + i], c[first_u + r + i] = between[k, i], between[k + 1, i]
        for part in range(steps if count else 0):
            own = first_f + part * count
            last = own - count if part else first_f + (steps - 1) * count
            for j in range(count):
                c[own + j] = c[last + j]
            # where the part ends, without its own forces
            for a in range(2 * count):
                ended[a] = along(reach[part, a], c, first_f)
                for i in range(part):
                    for j in range(count):
                        ended[a] += push[part - i, a, j] * c[first_f + i * count + j]
            middle = t + (part + 0.5) * h
            solve_forces(laws, numbers, push[0], begun, ended, z, solved, middle, scales, c, own, h)
            if p:
                dbegun[:] = dended
                dended[:] = 0.0
                add_product(dended, reach[part], 0, X, first_u)
                add_contracted(dended, dreach[part], c)
                if len(du):
                    add_product(dended, reach[part], first_u + r - du.shape[1], du[k], du.shape[1])
                for i in range(part + 1):
                    add_contracted(dended, dpush[part - i], c[first_f + i * count :])
                    if i < part:
                        add_product(dended, push[part - i], 0, dforces[i * count :], count)
                force_derivatives(laws, numbers, varied, push[0], begun, ended, z, middle, scales,
                                  c, own, h, dbegun, dended, dz, dnumbers, df, memory_slopes,
                                  slopes, coupled)  # fmt: skip
                add_product(dended, push[0], 0, df, count)
                dforces[part * count : (part + 1) * count] = df
            for a in range(2 * count):
                for j in range(count):
                    ended[a] += push[0, a, j] * c[own + j]
                ended[a] = min(max(ended[a], -FAR), FAR)
            remember(laws, numbers, ended, z, begun, dbegun, dended, dz, dnumbers, memory_slopes)
        if p:
            dnext[:] = 0.0
            add_product(dnext, over, 0, X, first_u)
            add_contracted(dnext, dover, c)
            if len(du):
                add_product(dnext, over, first_u + r - du.shape[1], du[k], du.shape[1])
            add_product(dnext, over, first_f, dforces, len(dforces))
            X[:n] = dnext
        for i in range(n):
            next_x[i] = min(max(along(over[i], c, len(c)), -FAR), FAR)
        c[:n] = next_x


@numba.njit(nogil=True, cache=True, forceinline=True)
def ports_at(ports, c, n, out):
    """Fill displacements, then rates, at the ports, (2 l,), of a state c[:n]."""
    for j in range(len(out)):
        out[j] = along(ports[j], c, n)


@numba.njit(nogil=True, cache=True, forceinline=True)
def derivatives_at_ports(ports, X, n, out):
    """Fill their derivatives, (2 l, p), by those of the state, (n, p)."""
    out[:] = 0.0
    add_product(out, ports, 0, X, n)


@numba.njit(nogil=True, cache=True, forceinline=True)
def remember(laws, numbers, ended, z, begun, dbegun, dended, dz, dnumbers, memory_slopes):
    """Move memories z and their derivatives to where the ports are now, and ``begun`` with them."""
    count, p = len(laws), dz.shape[2]
    for j in range(count):
        before, begun[j] = begun[j], ended[j]
        begun[count + j] = ended[count + j]
        for i in range(laws[j, 2]):
            z[j, i] = call_flow(laws[j, 1], z[j, i], float(i), before, begun[j],
                                numbers[j].ctypes.data)  # fmt: skip
            if p:
                set_slopes(dz[j, i], memory_slopes[j, i], dz[j, i], dbegun[j], dended[j],
                           dnumbers[j])  # fmt: skip
