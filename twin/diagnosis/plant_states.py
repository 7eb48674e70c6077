"""States that a plant gets besides q and q': of filters before white noises, and of instruments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from scipy.linalg import matrix_balance, solve_continuous_lyapunov

from twin.estimation.system import System
from twin.mechanisms.instrument import Instrument

Array = NDArray[np.float64]

ORDER = 4
"""Of the low-pass that noise of an input is behind: at twice the band a lightly damped resonance
(2 % of critical, 28 dB) responds less than the structure does in the band (48 dB less)."""


@dataclass(frozen=True)
class Plant:
    """A system and what its states are: q, q', then latent forces and instruments.

    Attributes:
        system: for the predictor.
        start: covariance of the states after q and q' before the first sample, (k, k).
        mass: diagonal of M, (n,).
        stiffness: diagonal of K, (n,).
    """

    system: System
    start: Array
    mass: Array
    stiffness: Array


@dataclass(frozen=True)
class Shaped:
    """A force that white noise makes through a filter x' = block x + drive w.

    Attributes:
        force, read: what a force of one does to the states and the outputs, (n, 1), (m, 1).
        block: (k, k).
        drive: (k,).
        shape: the force by x, (k,).
    """

    force: Array
    read: Array
    block: Array
    drive: Array
    shape: Array


def driven(plant: Plant, shaped: Sequence[Shaped]) -> Plant:
    """Return the plant with forces that white noises make through filters."""
    if not shaped:
        return plant
    system = plant.system
    n, k = len(system.A), sum(len(one.block) for one in shaped)
    grown = _grown(system, k)
    A, C, G = grown.A, grown.C, np.zeros((n + k, len(shaped)))
    start, at = np.zeros((k, k)), 0
    for column, one in enumerate(shaped):
        own = slice(n + at, n + at + len(one.block))
        A[:n, own], C[:, own] = one.force * one.shape, one.read * one.shape
        A[own, own], G[own, column] = one.block, one.drive
        first, at = at, at + len(one.block)
        start[first:at, first:at] = stationary(one.block, one.drive)
    grown = replace(grown, G=np.hstack([grown.G, G]))
    return replace(plant, system=grown, start=_beside(plant.start, start))


def _beside(first: Array, second: Array) -> Array:
    """Return a covariance of independent states, (k, k)."""
    at, k = len(first), len(first) + len(second)
    out = np.zeros((k, k))
    out[:at, :at], out[at:, at:] = first, second
    return out


def stationary(block: Array, drive: Array) -> Array:
    """Return the covariance of x' = block x + drive w, with white noise w, (k, k)."""
    if len(block) == 1:
        return -0.5 * np.outer(drive, drive) / block
    if len(block) == 2 and block[0, 0] == drive[0] == 0.0 and block[0, 1] == 1.0:  # an oscillator
        square, a = -block[1]
        return np.diag([1.0 / square, 1.0]) * drive[1] ** 2 / (2.0 * a)
    # a fast filter's displacements are far below its rates: units do not count
    balanced, (scale, _) = matrix_balance(block, permute=False, separate=True)
    drive = drive / scale
    P = solve_continuous_lyapunov(balanced, -np.outer(drive, drive))
    return np.asarray(scale[:, None] * P * scale)


def band_limited(plant: Plant, bands: Sequence[float]) -> Plant:
    """Return the plant with the noise of its first inputs behind low-passes (Butterworth's).

    Args:
        plant: with white noise.
        bands: of each input [Hz]; inf where its noise is white.
    """
    at = [index for index, band in enumerate(bands) if np.isfinite(band)]
    if not at:
        return plant
    block, entry, out = _low_pass()
    n, k = len(plant.system.A), len(block)
    grown = _grown(plant.system, k * len(at))
    A, C, W, V = grown.A, grown.C, grown.W, grown.V.copy()
    for i, index in enumerate(at):
        own, w = slice(n + i * k, n + (i + 1) * k), 2 * np.pi * bands[index]
        A[:n, own], C[:, own] = np.outer(W[:n, index], out), np.outer(V[:, index], out)
        A[own, own] = w * block
        W[:, index], V[:, index] = 0.0, 0.0
        W[own, index] = w * entry
    start = _beside(plant.start, np.zeros((k * len(at), k * len(at))))
    return replace(plant, system=replace(grown, A=A, C=C, W=W, V=V), start=start)


@cache
def _low_pass() -> tuple[Array, Array, Array]:
    """Return A (k, k), B and C (k,) of a low-pass of 1 rad/s."""
    block, entry, out, _ = signal.tf2ss(*signal.butter(ORDER, 1.0, analog=True))
    return block, entry[:, 0], out[0]


def read_by(plant: Plant, rows: Sequence[int], instrument: Instrument) -> Plant:
    """Return the plant whose outputs, at these rows, are read through an instrument."""
    system, k = plant.system, len(instrument.A)
    n, pick = len(system.A), list(rows)
    grown = _grown(system, k)
    A, B, E, W = grown.A, grown.B, grown.E, grown.W
    A[n:, :n] = instrument.B @ system.C[pick]
    A[n:, n:] = instrument.A
    B[n:], E[n:] = instrument.B @ system.D[pick], instrument.B @ system.F[pick]
    W[n:] = instrument.B @ system.V[pick]
    C, D, F, V = grown.C, grown.D.copy(), grown.F.copy(), grown.V.copy()
    for matrix in (C, D, F, V):
        matrix[pick] = instrument.D @ matrix[pick]
    C[pick, n:] = instrument.C
    out = replace(grown, A=A, B=B, E=E, W=W, C=C, D=D, F=F, V=V, G=_stirring(grown, instrument))
    return replace(plant, system=out, start=_beside(plant.start, instrument.start))


def driven_as_read(plant: Plant, columns: Sequence[int], instrument: Instrument) -> Plant:
    """Return the plant whose inputs, at these columns, are what an instrument has read of them.

    What drives it is the reading taken back: for a reading C s + D u, u = D^-1 (reading - C s).
    Noise of an input is in its reading.

    Raises:
        numpy.linalg.LinAlgError: an instrument that passes nothing at once.
    """
    system, k = plant.system, len(instrument.A)
    n, pick = len(system.A), list(columns)
    inverse = np.linalg.inv(instrument.D)
    grown = _grown(system, k)
    A, B, C, D, W, V = grown.A, grown.B, grown.C, grown.D.copy(), grown.W, grown.V.copy()
    for states, outputs in ((B, D), (W, V)):
        states[:n, pick] = states[:n, pick] @ inverse
        states[n:, pick] = instrument.B @ inverse
        outputs[:, pick] = outputs[:, pick] @ inverse
    A[n:, n:] = instrument.A
    A[:, n:] -= B[:, pick] @ instrument.C
    C[:, n:] = -D[:, pick] @ instrument.C
    out = replace(grown, A=A, B=B, C=C, D=D, W=W, V=V, G=_stirring(grown, instrument))
    return replace(plant, system=out, start=_beside(plant.start, instrument.start))


def _stirring(grown: System, instrument: Instrument) -> Array:
    """Return the entry of white noises, an instrument's own at its states, the last ones."""
    k, g = instrument.G.shape
    own = np.zeros((len(grown.A), g))
    own[len(own) - k :] = instrument.G
    return np.hstack([grown.G, own])


def _grown(system: System, k: int) -> System:
    """Return the system with k more states that nothing moves or sees yet.

    Every matrix that has a place for them is a new one, and may be filled.
    """

    def larger(m: Array, rows: int, columns: int) -> Array:
        out = np.zeros((m.shape[0] + rows, m.shape[1] + columns))
        out[: m.shape[0], : m.shape[1]] = m
        return out

    return replace(
        system,
        A=larger(system.A, k, k),
        B=larger(system.B, k, 0),
        C=larger(system.C, 0, k),
        E=larger(system.E, k, 0),
        W=larger(system.W, k, 0),
        G=larger(system.G, k, 0),
        drift=larger(system.drift, 0, k),
        rate=larger(system.rate, 0, k),
    )
