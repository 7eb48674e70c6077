"""Maximum likelihood of modes from responses alone, near their resonances.

Near a resonance the modal coordinates have the spectral matrix D P D^H + R: D the modes' responses,
P the spectrum of their forces and R that of noise, both constant there. The lines of their discrete
Fourier transform are independent and complex normal (Whittle 1953); what a record of finite length
smears into them is part of their expected spectrum (Sykulski et al. 2019, the debiased Whittle
likelihood). Deviations are those of the Fisher information.

Source: Au 2017, Operational Modal Analysis (the likelihood near a resonance, and how much of what a
record knows lies how near to it).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

REACH = 20.0
"""Half bandwidths k to either side of a resonance whose lines are used: they hold 85 % of what a
long record without noise knows of its damping, 2/pi (atan k + k/(1 + k^2) - 2 atan(k)^2 / k)."""

ALONE = 5.0
"""Half bandwidths, of both modes together, from which on two modes do without each other: their
bands end halfway between them, and hold 52 % of that."""

MOST_TOGETHER = 4
"""Modes of one group at most; their forces' spectrum alone has the square of that unknowns."""

LEAST_LINES = 3
"""Lines for each unknown, at least."""

STEPS = 60
"""Scoring steps at most; five to ten are usual."""

SMALL_GAIN = 1e-6
"""Gain of the log likelihood below which the fit ends."""

DIFFERENCE = 1e-6
"""Relative step of the derivatives, between rounding (1e-16 / step) and curvature (step)."""

UNFELT = 1e-9
"""Share of the largest eigenvalue of the Fisher information below which a direction is not known;
all unknowns are logarithms or shares, rounding of the differences is 1e-10."""

NUMERATORS = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""Power of s by which a sensor sees displacement."""


@dataclass(frozen=True)
class Lines:
    """Periodograms of some modal coordinates in a band, of one record.

    Attributes:
        omega: angular frequencies [rad/s], (lines,).
        I: periodograms, (lines, coordinates, coordinates).
        seconds: length of the record [s].
    """

    omega: Array
    I: ComplexArray  # noqa: E741
    seconds: float


@dataclass(frozen=True)
class Likeliest:
    """Modes of one group, refined.

    Attributes:
        frequency_hz: [Hz], (modes,).
        damping: damping ratios, (modes,).
        std: standard deviations of both, (2, modes).
    """

    frequency_hz: Array
    damping: Array
    std: Array


def groups(frequency_hz: Array, damping: Array) -> list[tuple[list[int], tuple[float, float]]]:
    """Return which modes are fitted together and the band [Hz] of each group.

    Args:
        frequency_hz: ascending [Hz], (modes,).
        damping: damping ratios, (modes,).
    """
    width = frequency_hz * damping
    together: list[list[int]] = []
    for i in range(len(frequency_hz)):
        near = i and frequency_hz[i] - frequency_hz[i - 1] < ALONE * (width[i] + width[i - 1])
        if near:
            together[-1].append(i)
        else:
            together.append([i])
    found = []
    for members in together:
        first, last = members[0], members[-1]
        low = frequency_hz[first] - REACH * width[first]
        high = frequency_hz[last] + REACH * width[last]
        if first:
            low = max(low, (frequency_hz[first - 1] + frequency_hz[first]) / 2)
        if last + 1 < len(frequency_hz):
            high = min(high, (frequency_hz[last] + frequency_hz[last + 1]) / 2)
        found.append((members, (max(float(low), 0.0), float(high))))
    return found


def lines(q: Sequence[Array], rate: float, band: tuple[float, float]) -> list[Lines]:
    """Transform the modal coordinates of every record, (samples, coordinates), in a band [Hz]."""
    found = []
    for x in q:
        freq = np.fft.rfftfreq(len(x), 1 / rate)
        keep = (freq > max(band[0], 0.0)) & (freq < min(band[1], rate / 2))
        X = np.fft.rfft(x - x.mean(axis=0), axis=0)[keep] / np.sqrt(len(x))
        omega = np.asarray(2 * np.pi * freq[keep], float)
        found.append(Lines(omega, X[:, :, None] * X[:, None].conj(), len(x) / rate))
    return found


def expected(
    omega: Array, seconds: float, poles: ComplexArray, power: int, P: ComplexArray, noise: Array
) -> ComplexArray:
    """Return the expected periodograms of a record of finite length, (lines, modes, modes).

    Its covariances are those of an endless one times (1 - |lag| / seconds). Of a covariance
    c exp(pole lag) that takes c (1 - exp((pole - j omega) T)) / (T (j omega - pole)^2) off the
    transform c / (j omega - pole); that of the pole's conjugate is negligible near resonance.
    """
    s = 1j * omega[:, None]
    mirrored = poles.conj()
    D = s**power / ((s - poles) * (s - mirrored))
    full = D[:, :, None] * P * D[:, None].conj()
    residue = poles**power / (poles - mirrored)
    across = (-poles[:, None]) ** power / ((-poles[:, None] - poles) * (-poles[:, None] - mirrored))
    lost = (1 - np.exp((poles - s) * seconds)) / (seconds * (s - poles) ** 2)
    half = -(residue[:, None] * P * across) * lost[:, :, None]
    return np.asarray(full + half + half.conj().transpose(0, 2, 1) + np.diag(noise))


def refine(
    data: Sequence[Lines], frequency_hz: Array, damping: Array, power: int
) -> Likeliest | None:
    """Return the likeliest modes of a group, or None where its lines do not support them.

    Args:
        data: lines of the group's band, of every record; as many coordinates as modes.
        frequency_hz: where to start [Hz], (modes,).
        damping: where to start, (modes,).
        power: of s by which the sensors see displacement, as in ``NUMERATORS``.
    """
    m = len(frequency_hz)
    theta = _start(data, frequency_hz, damping, power)
    if sum(len(d.omega) for d in data) * m < LEAST_LINES * len(theta):
        return None
    value = _log_likelihood(data, theta, m, power)
    damp = 0.0
    for _ in range(STEPS):
        gradient, fisher = _scores(data, theta, m, power)
        gain = 0.0
        for _ in range(STEPS):
            step = _inverse(fisher + damp * np.diag(np.diag(fisher))) @ gradient
            tried = theta + step
            other = _log_likelihood(data, tried, m, power)
            if other > value:
                gain, theta, value = other - value, tried, other
                damp = damp / 10 if damp > SMALL_GAIN else 0.0
                break
            if gradient @ step < SMALL_GAIN:
                break
            damp = max(10 * damp, 1e-3)
        if gain < SMALL_GAIN:
            break
    _, fisher = _scores(data, theta, m, power)
    if not np.isfinite(value):
        return None
    std = np.sqrt(np.diag(_inverse(fisher))[: 2 * m]).reshape(2, m)
    f, zeta = np.exp(theta[:m]) / (2 * np.pi), np.exp(theta[m : 2 * m])
    return Likeliest(f, zeta, std * np.array([f, zeta]))


def _inverse(fisher: Array) -> Array:
    """Return the inverse but for what the lines do not feel, such as noise far below them."""
    return np.asarray(np.linalg.pinv(fisher, rcond=UNFELT, hermitian=True), float)


def _start(data: Sequence[Lines], frequency_hz: Array, damping: Array, power: int) -> Array:
    """Return logarithms of frequencies and dampings, the factor of P, logarithms of the noise."""
    m = len(frequency_hz)
    w = 2 * np.pi * frequency_hz
    poles = w * (-damping + 1j * np.sqrt(1 - damping**2))
    total, shape, floor = np.zeros(m), np.zeros(m), np.full(m, np.inf)
    for d in data:
        s = 1j * d.omega[:, None]
        total += np.einsum("lii->li", d.I).real.sum(axis=0)
        shape += np.abs(s**power / ((s - poles) * (s - poles.conj()))).__pow__(2).sum(axis=0)
        floor = np.minimum(floor, np.quantile(np.einsum("lii->li", d.I).real, 0.25, axis=0))
    factor = np.zeros((m, m))
    np.fill_diagonal(factor, 0.5 * np.log(total / shape))
    return np.concatenate([
        np.log(w), np.log(damping), np.diag(factor), np.zeros(m * (m - 1)), np.log(floor)
    ])  # fmt: skip


def _model(d: Lines, theta: Array, m: int, power: int) -> ComplexArray:
    w, zeta = np.exp(theta[:m]), np.exp(theta[m : 2 * m])
    poles = w * (-zeta + 1j * np.sqrt(np.maximum(1 - zeta**2, 0.0)))
    scale = np.exp(theta[2 * m : 3 * m])
    below = np.tril_indices(m, -1)
    many = len(below[0])
    real, imaginary = theta[3 * m : 3 * m + many], theta[3 * m + many : 3 * m + 2 * many]
    L = np.eye(m, dtype=complex)
    L[below] = real + 1j * imaginary
    L = scale[:, None] * L
    noise = np.exp(theta[3 * m + 2 * many :])
    return expected(d.omega, d.seconds, poles, power, L @ L.conj().T, noise)


def _log_likelihood(data: Sequence[Lines], theta: Array, m: int, power: int) -> float:
    value = 0.0
    if np.any(theta[m : 2 * m] > 0) or np.any(np.abs(theta) > 500):
        return -np.inf
    for d in data:
        S = _model(d, theta, m, power)
        sign, size = np.linalg.slogdet(S)
        if not np.all(sign.real > 0) or not np.all(np.isfinite(size)):
            return -np.inf
        if m > 1 and np.any(np.linalg.eigvalsh(S) <= 0):
            return -np.inf
        value -= float(np.sum(size) + np.sum(np.linalg.solve(S, d.I).trace(axis1=1, axis2=2).real))
    return value


def _scores(data: Sequence[Lines], theta: Array, m: int, power: int) -> tuple[Array, Array]:
    """Return gradient and Fisher information, (unknowns,) and (unknowns, unknowns)."""
    n = len(theta)
    gradient, fisher = np.zeros(n), np.zeros((n, n))
    for d in data:
        S = _model(d, theta, m, power)
        changes = []
        for i in range(n):
            step = np.zeros(n)
            step[i] = DIFFERENCE
            up, down = (_model(d, theta + x, m, power) for x in (step, -step))
            changes.append(np.linalg.solve(S, (up - down) / (2 * DIFFERENCE)))
        white = np.linalg.solve(S, d.I)
        left = np.eye(m) - white
        for i, a in enumerate(changes):
            gradient[i] -= np.einsum("lij,lji->", a, left).real
            for j, b in enumerate(changes[: i + 1]):
                fisher[i, j] += np.einsum("lij,lji->", a, b).real
                fisher[j, i] = fisher[i, j]
    return gradient, fisher
