"""The compiled one-step predictor with laws inside, and its exact forward sensitivities.

One loop carries the state and its derivatives with respect to all unknowns. A law's force over a
part of a sample is that of the motion's midpoint, which it moves itself (implicit midpoint): the
scheme is of second order for smooth laws, and for dry friction that of Moreau (1988), which sticks.
"""

# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

import numba
import numpy as np

NEWTON = 8
"""Newton steps for a law's force before the bracketed search takes over."""

BRACKETED = 60
"""Steps of the bracketed search: halving alone reaches rounding."""

SWEEPS = 4
"""Gauss-Seidel sweeps over laws that act on one another within a part of a sample."""

CLOSE = 1e-9
"""Force error, as a share of the force, at which a law's equation is solved."""

DIFFERENCE = 1e-6
"""Step of the numeric slopes of a law, as a share of the scale of its argument."""

FAR = 1e9
"""Bound of the states: a predictor that runs away gives a finite, hopeless likelihood."""


@numba.njit(nogil=True, cache=True)
def _at(force, flow, numbers, before, start, d, v, z, ed, ev, f, t):
    """Return the law's force at the midpoint of a step in which it was f."""
    after = d + ed * f
    memory = flow(z, before, after, numbers)
    return force(0.5 * (before + after), 0.5 * (start + v + ev * f), 0.5 * (z + memory), t, numbers)


@numba.njit(nogil=True, cache=True)
def _solve(force, flow, numbers, before, start, d, v, z, ed, ev, guess, t, scale):
    """Return f with f = law(midpoint of the motion that f itself moves)."""
    f = guess
    for _ in range(NEWTON):
        value = _at(force, flow, numbers, before, start, d, v, z, ed, ev, f, t)
        error = f - value
        if abs(error) <= CLOSE * (abs(f) + 1e-6 * scale):
            return f
        step = DIFFERENCE * (abs(f) + 1e-3 * scale)
        slope = (
            1.0
            - (_at(force, flow, numbers, before, start, d, v, z, ed, ev, f + step, t) - value)
            / step
        )
        if not slope > 0.1:
            break
        f = f - error / slope
    high = _at(force, flow, numbers, before, start, d, v, z, ed, ev, 0.0, t)
    low = _at(force, flow, numbers, before, start, d, v, z, ed, ev, high, t)
    if low > high:
        low, high = high, low
    for _ in range(BRACKETED):
        f = 0.5 * (low + high)
        error = f - _at(force, flow, numbers, before, start, d, v, z, ed, ev, f, t)
        if abs(error) <= CLOSE * (abs(f) + 1e-6 * scale) or high - low <= CLOSE * scale * 1e-3:
            break
        if error > 0:
            high = f
        else:
            low = f
    return f


@numba.njit(nogil=True, cache=True)
def predict(
    forces, flows, A, B0, B1, E, W, C, D, F, drift, rate, numbers, Kf, Ku,
    u, us, y, x0, z0, begin_s, steps, step_s, ramps, scales,
    dA, dB0, dB1, dE, dW, dC, dD, dF, dnumbers, dKf, dKu, dx0,
    e_out, de_out, x_out, z_out, f_out,
):  # fmt: skip
    """Fill innovations and their derivatives, and the states before each sample.

    Shapes: n states, m outputs, r inputs, l laws, w held disturbances, p unknowns, t gains.

    In the order of the arguments:
        forces, flows: of the laws, compiled.
        A, B0, B1, E, W: over one part of a sample; C, D, F: of the outputs.
        drift, rate: at the laws' ports, (l, n).
        numbers: of the laws, (l, most).
        Kf, Ku: gains, (t, n, m), (t, w, m); the last one for all later samples.
        u, us: inputs (samples, r) as the outputs see them, and as they drive the states.
        y: measured outputs, (samples, m); NaN where there is none.
        x0, z0: state (n,) and memories (l,) before the first sample.
        begin_s, steps, step_s: time of the first sample, parts of a sample, sampling interval.
        ramps: 1 for inputs that are linear between samples, 0 for held ones, (r,).
        scales: of force, drift and rate at each port, (l, 3).
        dA ... dKu, dx0: derivatives with respect to the unknowns, these in the last axis.
        e_out, de_out, x_out, z_out, f_out: filled, (samples, m), (samples, m, p), (samples, n),
            (samples, l), (samples, l): the force at each sample.
    """
    samples, m = y.shape
    n, r, laws, w = A.shape[0], D.shape[1], E.shape[1], W.shape[1]
    p = dA.shape[2]
    last_gain = Kf.shape[0] - 1
    h = step_s / steps
    x, free, held, e = x0.copy(), np.zeros(n), np.zeros(w), np.zeros(m)
    f, z, instant = np.zeros(laws), z0.copy(), np.zeros(laws)
    now, soon, start = np.zeros(r), np.zeros(r), np.zeros(n)
    X, Y, dfree = dx0.copy(), np.zeros((m, p)), np.zeros((n, p))
    dheld, df, dz, dinstant = (
        np.zeros((w, p)),
        np.zeros((laws, p)),
        np.zeros((laws, p)),
        np.zeros((laws, p)),
    )
    before, begun, ed, ev = np.zeros(laws), np.zeros(laws), np.zeros(laws), np.zeros(laws)
    dbefore, dbegun = np.zeros((laws, p)), np.zeros((laws, p))
    slope_n = np.zeros((laws, numbers.shape[1]))
    vary = np.zeros((laws, numbers.shape[1]), np.bool_)
    for j in range(laws):
        for i in range(n):
            ed[j] += drift[j, i] * E[i, j]
            ev[j] += rate[j, i] * E[i, j]
        for q in range(numbers.shape[1]):
            for i in range(p):
                if dnumbers[j, q, i] != 0.0:
                    vary[j, q] = True
    for k in range(samples):
        t = begin_s + k * step_s
        # the law's force at the sample, and what the outputs should read
        for j in range(laws):
            d, v = 0.0, 0.0
            for i in range(n):
                d += drift[j, i] * x[i]
                v += rate[j, i] * x[i]
            instant[j] = forces[j](d, v, z[j], t, numbers[j].ctypes)
            if p:
                hd, hv = DIFFERENCE * scales[j, 1], DIFFERENCE * scales[j, 2]
                hz = DIFFERENCE * scales[j, 0]
                sd = (
                    forces[j](d + hd, v, z[j], t, numbers[j].ctypes)
                    - forces[j](d - hd, v, z[j], t, numbers[j].ctypes)
                ) / (2 * hd)
                sv = (
                    forces[j](d, v + hv, z[j], t, numbers[j].ctypes)
                    - forces[j](d, v - hv, z[j], t, numbers[j].ctypes)
                ) / (2 * hv)
                sz = (
                    forces[j](d, v, z[j] + hz, t, numbers[j].ctypes)
                    - forces[j](d, v, z[j] - hz, t, numbers[j].ctypes)
                ) / (2 * hz)
                for i in range(p):
                    dinstant[j, i] = sz * dz[j, i]
                for l in range(n):  # noqa: E741
                    g = sd * drift[j, l] + sv * rate[j, l]
                    if g != 0.0:
                        for i in range(p):
                            dinstant[j, i] += g * X[l, i]
                for q in range(numbers.shape[1]):
                    if vary[j, q]:
                        kept = numbers[j, q]
                        hq = DIFFERENCE * (abs(kept) + 1e-12)
                        numbers[j, q] = kept + hq
                        up = forces[j](d, v, z[j], t, numbers[j].ctypes)
                        numbers[j, q] = kept - hq
                        low = forces[j](d, v, z[j], t, numbers[j].ctypes)
                        numbers[j, q] = kept
                        for i in range(p):
                            dinstant[j, i] += (up - low) / (2 * hq) * dnumbers[j, q, i]
            f_out[k, j] = instant[j]
            z_out[k, j] = z[j]
        for i in range(n):
            x_out[k, i] = x[i]
        for o in range(m):
            predicted = 0.0
            for i in range(n):
                predicted += C[o, i] * x[i]
            for i in range(r):
                predicted += D[o, i] * u[k, i]
            for j in range(laws):
                predicted += F[o, j] * instant[j]
            missing = np.isnan(y[k, o])
            e[o] = 0.0 if missing else y[k, o] - predicted
            e_out[k, o] = e[o]
            if p:
                for i in range(p):
                    Y[o, i] = 0.0
                if not missing:
                    for l in range(n):  # noqa: E741
                        c, s = C[o, l], x[l]
                        for i in range(p):
                            Y[o, i] -= c * X[l, i] + dC[o, l, i] * s
                    for l in range(r):  # noqa: E741
                        s = u[k, l]
                        if s != 0.0:
                            for i in range(p):
                                Y[o, i] -= dD[o, l, i] * s
                    for j in range(laws):
                        c, s = F[o, j], instant[j]
                        for i in range(p):
                            Y[o, i] -= c * dinstant[j, i] + dF[o, j, i] * s
                for i in range(p):
                    de_out[k, o, i] = Y[o, i]
        # the correction by what was measured
        g = min(k, last_gain)
        for j in range(laws):
            d = 0.0
            for i in range(n):
                d += drift[j, i] * x[i]
            before[j] = d
            for i in range(p):
                dbefore[j, i] = 0.0
            if p:
                for l in range(n):  # noqa: E741
                    if drift[j, l] != 0.0:
                        for i in range(p):
                            dbefore[j, i] += drift[j, l] * X[l, i]
        for i in range(n):
            add = 0.0
            for o in range(m):
                add += Kf[g, i, o] * e[o]
            start[i] = x[i] + add
        for i in range(w):
            total = 0.0
            for o in range(m):
                total += Ku[g, i, o] * e[o]
            held[i] = total
        if p:
            for l in range(n):  # noqa: E741
                for o in range(m):
                    c, s = Kf[g, l, o], e[o]
                    for i in range(p):
                        X[l, i] += c * Y[o, i] + dKf[l, o, i] * s
            for l in range(w):  # noqa: E741
                for i in range(p):
                    dheld[l, i] = 0.0
                for o in range(m):
                    c, s = Ku[g, l, o], e[o]
                    for i in range(p):
                        dheld[l, i] += c * Y[o, i] + dKu[l, o, i] * s
        for i in range(n):
            x[i] = start[i]
        for j in range(laws):
            d = 0.0
            for i in range(n):
                d += drift[j, i] * x[i]
            held_z = z[j]
            z[j] = flows[j](held_z, before[j], d, numbers[j].ctypes)
            if p and scales[j, 0] > 0.0:
                hz, hd = DIFFERENCE * scales[j, 0], DIFFERENCE * scales[j, 1]
                sz = (
                    flows[j](held_z + hz, before[j], d, numbers[j].ctypes)
                    - flows[j](held_z - hz, before[j], d, numbers[j].ctypes)
                ) / (2 * hz)
                sb = (
                    flows[j](held_z, before[j] + hd, d, numbers[j].ctypes)
                    - flows[j](held_z, before[j] - hd, d, numbers[j].ctypes)
                ) / (2 * hd)
                sa = (
                    flows[j](held_z, before[j], d + hd, numbers[j].ctypes)
                    - flows[j](held_z, before[j], d - hd, numbers[j].ctypes)
                ) / (2 * hd)
                for i in range(p):
                    dz[j, i] = sz * dz[j, i] + sb * dbefore[j, i]
                for l in range(n):  # noqa: E741
                    if drift[j, l] != 0.0:
                        for i in range(p):
                            dz[j, i] += sa * drift[j, l] * X[l, i]
                for q in range(numbers.shape[1]):
                    if vary[j, q]:
                        kept = numbers[j, q]
                        hq = DIFFERENCE * (abs(kept) + 1e-12)
                        numbers[j, q] = kept + hq
                        up = flows[j](held_z, before[j], d, numbers[j].ctypes)
                        numbers[j, q] = kept - hq
                        low = flows[j](held_z, before[j], d, numbers[j].ctypes)
                        numbers[j, q] = kept
                        for i in range(p):
                            dz[j, i] += (up - low) / (2 * hq) * dnumbers[j, q, i]
        if k == samples - 1:
            break
        # to the next sample
        for q in range(steps):
            low_t, high_t = q / steps, (q + 1) / steps
            for i in range(r):
                a = us[k, i]
                b = ramps[i] * (us[k + 1, i] - a)
                now[i], soon[i] = a + low_t * b, a + high_t * b
            for i in range(n):
                total = 0.0
                for l in range(n):  # noqa: E741
                    total += A[i, l] * x[l]
                for l in range(r):  # noqa: E741
                    total += B0[i, l] * now[l] + B1[i, l] * soon[l]
                for l in range(w):  # noqa: E741
                    total += W[i, l] * held[l]
                free[i] = total
            if p:
                for i in range(n):
                    for a in range(p):
                        dfree[i, a] = 0.0
                    for l in range(n):  # noqa: E741
                        c, s = A[i, l], x[l]
                        for a in range(p):
                            dfree[i, a] += c * X[l, a] + dA[i, l, a] * s
                    for l in range(r):  # noqa: E741
                        c, s = now[l], soon[l]
                        if c != 0.0 or s != 0.0:
                            for a in range(p):
                                dfree[i, a] += dB0[i, l, a] * c + dB1[i, l, a] * s
                    for l in range(w):  # noqa: E741
                        c, s = W[i, l], held[l]
                        for a in range(p):
                            dfree[i, a] += c * dheld[l, a] + dW[i, l, a] * s
            if laws:
                middle = t + (q + 0.5) * h
                for j in range(laws):
                    d, v = 0.0, 0.0
                    for i in range(n):
                        d += drift[j, i] * x[i]
                        v += rate[j, i] * x[i]
                    before[j], begun[j] = d, v
                    if p:
                        for a in range(p):
                            dbefore[j, a] = 0.0
                            dbegun[j, a] = 0.0
                        for l in range(n):  # noqa: E741
                            c, s = drift[j, l], rate[j, l]
                            if c != 0.0 or s != 0.0:
                                for a in range(p):
                                    dbefore[j, a] += c * X[l, a]
                                    dbegun[j, a] += s * X[l, a]
                for _ in range(SWEEPS if laws > 1 else 1):
                    for j in range(laws):
                        d, v = 0.0, 0.0
                        for i in range(n):
                            total = free[i]
                            for b in range(laws):
                                if b != j:
                                    total += E[i, b] * f[b]
                            d += drift[j, i] * total
                            v += rate[j, i] * total
                        f[j] = _solve(
                            forces[j], flows[j], numbers[j].ctypes, before[j], begun[j], d, v,
                            z[j], ed[j], ev[j], f[j], middle, scales[j, 0],
                        )  # fmt: skip
                if p:
                    _force_slopes(
                        forces, flows, numbers, drift, rate, E, dE, free, dfree, before, begun,
                        dbefore, dbegun, z, dz, f, df, dnumbers, vary, slope_n, ed, ev, middle,
                        scales,
                    )  # fmt: skip
                for j in range(laws):
                    for i in range(n):
                        free[i] += E[i, j] * f[j]
                    if p:
                        for i in range(n):
                            c, s = E[i, j], f[j]
                            if c != 0.0:
                                for a in range(p):
                                    dfree[i, a] += c * df[j, a] + dE[i, j, a] * s
                for j in range(laws):
                    d = 0.0
                    for i in range(n):
                        d += drift[j, i] * free[i]
                    kept_z = z[j]
                    z[j] = flows[j](kept_z, before[j], d, numbers[j].ctypes)
                    if p:
                        hz, hd = DIFFERENCE * scales[j, 0], DIFFERENCE * scales[j, 1]
                        sz = (
                            flows[j](kept_z + hz, before[j], d, numbers[j].ctypes)
                            - flows[j](kept_z - hz, before[j], d, numbers[j].ctypes)
                        ) / (2 * hz)
                        sb = (
                            flows[j](kept_z, before[j] + hd, d, numbers[j].ctypes)
                            - flows[j](kept_z, before[j] - hd, d, numbers[j].ctypes)
                        ) / (2 * hd)
                        sa = (
                            flows[j](kept_z, before[j], d + hd, numbers[j].ctypes)
                            - flows[j](kept_z, before[j], d - hd, numbers[j].ctypes)
                        ) / (2 * hd)
                        for a in range(p):
                            dz[j, a] = sz * dz[j, a] + sb * dbefore[j, a]
                        for l in range(n):  # noqa: E741
                            if drift[j, l] != 0.0:
                                for a in range(p):
                                    dz[j, a] += sa * drift[j, l] * dfree[l, a]
                        for b in range(numbers.shape[1]):
                            if vary[j, b]:
                                kept = numbers[j, b]
                                hq = DIFFERENCE * (abs(kept) + 1e-12)
                                numbers[j, b] = kept + hq
                                up = flows[j](kept_z, before[j], d, numbers[j].ctypes)
                                numbers[j, b] = kept - hq
                                low = flows[j](kept_z, before[j], d, numbers[j].ctypes)
                                numbers[j, b] = kept
                                for a in range(p):
                                    dz[j, a] += (up - low) / (2 * hq) * dnumbers[j, b, a]
            for i in range(n):
                x[i] = min(max(free[i], -FAR), FAR)
                for a in range(p):
                    X[i, a] = dfree[i, a]


@numba.njit(nogil=True, cache=True)
def _force_slopes(
    forces, flows, numbers, drift, rate, E, dE, free, dfree, before, begun, dbefore, dbegun,
    z, dz, f, df, dnumbers, vary, slope_n, ed, ev, middle, scales,
):  # fmt: skip
    """Fill df, the derivatives of the midpoint forces, by the implicit function theorem."""
    laws, n, p = E.shape[1], E.shape[0], df.shape[1]
    for j in range(laws):
        d, v = 0.0, 0.0
        for i in range(n):
            total = free[i]
            for b in range(laws):
                if b != j:
                    total += E[i, b] * f[b]
            d += drift[j, i] * total
            v += rate[j, i] * total
        args = numbers[j].ctypes
        hf, hd = DIFFERENCE * scales[j, 0], DIFFERENCE * scales[j, 1]
        hv = DIFFERENCE * scales[j, 2]
        z0, b0, s0 = z[j], before[j], begun[j]
        c1, c2 = forces[j], flows[j]
        by_f = (
            _at(c1, c2, args, b0, s0, d, v, z0, ed[j], ev[j], f[j] + hf, middle)
            - _at(c1, c2, args, b0, s0, d, v, z0, ed[j], ev[j], f[j] - hf, middle)
        ) / (2 * hf)
        by_d = (
            _at(c1, c2, args, b0, s0, d + hd, v, z0, ed[j], ev[j], f[j], middle)
            - _at(c1, c2, args, b0, s0, d - hd, v, z0, ed[j], ev[j], f[j], middle)
        ) / (2 * hd)
        by_b = (
            _at(c1, c2, args, b0 + hd, s0, d, v, z0, ed[j], ev[j], f[j], middle)
            - _at(c1, c2, args, b0 - hd, s0, d, v, z0, ed[j], ev[j], f[j], middle)
        ) / (2 * hd)
        by_v = (
            _at(c1, c2, args, b0, s0, d, v + hv, z0, ed[j], ev[j], f[j], middle)
            - _at(c1, c2, args, b0, s0, d, v - hv, z0, ed[j], ev[j], f[j], middle)
        ) / (2 * hv)
        by_z = (
            _at(c1, c2, args, b0, s0, d, v, z0 + hf, ed[j], ev[j], f[j], middle)
            - _at(c1, c2, args, b0, s0, d, v, z0 - hf, ed[j], ev[j], f[j], middle)
        ) / (2 * hf)
        # the midpoint's rate is the mean of both ends', so both have the same slope
        scale = 1.0 / max(1.0 - by_f, 1e-3)
        for a in range(p):
            df[j, a] = by_b * dbefore[j, a] + by_v * dbegun[j, a] + by_z * dz[j, a]
        for l in range(n):  # noqa: E741
            c = by_d * drift[j, l] + by_v * rate[j, l]
            if c != 0.0:
                for a in range(p):
                    df[j, a] += c * dfree[l, a]
                for b in range(laws):
                    for a in range(p):
                        df[j, a] += c * dE[l, b, a] * f[b]
                        if b < j:
                            df[j, a] += c * E[l, b] * df[b, a]
        for q in range(numbers.shape[1]):
            if vary[j, q]:
                kept = numbers[j, q]
                hq = DIFFERENCE * (abs(kept) + 1e-12)
                numbers[j, q] = kept + hq
                up = _at(c1, c2, args, b0, s0, d, v, z0, ed[j], ev[j], f[j], middle)
                numbers[j, q] = kept - hq
                low = _at(c1, c2, args, b0, s0, d, v, z0, ed[j], ev[j], f[j], middle)
                numbers[j, q] = kept
                for a in range(p):
                    df[j, a] += (up - low) / (2 * hq) * dnumbers[j, q, a]
        for a in range(p):
            df[j, a] *= scale
