"""A linear model with mechanisms as one state-space system for the predictor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from scipy.linalg import block_diag, solve_continuous_lyapunov

from twin.diagnosis.scales import ROUNDING
from twin.diagnosis.straight import calmed, well_damped
from twin.estimation.system import System
from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange
from twin.model.linear import LinearModel

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


def plant_of(
    model: LinearModel,
    mechanisms: Sequence[Mechanism],
    latent: Sequence[tuple[str, float, float]],
    readings: Mapping[str, float],
    noise_gain: Array | None = None,
    pseudo_forces: int = 0,
    step_s: float | None = None,
    sampled_s: float | None = None,
) -> Plant:
    """Return the plant of a model with mechanisms.

    Args:
        model: the structure as it stands.
        mechanisms: in any order.
        latent: port or output, RMS [N or the output's unit] and corner frequency [Hz] of each
            discrepancy.
        readings: RMS of each output.
        noise_gain: by what noise stirs each of the first coordinates more than it does in steps
            from sample to sample, (n,), 0 where none is to; 1 without.
        pseudo_forces: further inputs, each a force on one of the first coordinates.
        step_s: sampling interval [s], if modes above half the sampling rate are not to ring.
        sampled_s: the same, if instruments and forces that nobody measured are not to, either.

    Raises:
        ValueError: changes that take more damping than there is.
    """
    own = len(model.coordinates)
    model, laws = structure_of(model, mechanisms), [m for m in mechanisms if isinstance(m, Law)]
    if step_s is not None:
        model = well_damped(model, step_s)
    n = len(model.coordinates)
    inverse = np.linalg.inv(model.M)
    lower = -inverse @ np.hstack([model.K, model.R])
    A = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])
    C = np.hstack([model.Cd, model.Cv]) + model.Ca @ lower

    def entry(force: Array) -> tuple[Array, Array]:
        """Return what forces on the coordinates do to states and outputs, columns (n, k)."""
        acceleration = inverse @ force
        return np.vstack([0 * acceleration, acceleration]), model.Ca @ acceleration

    B, D = entry(np.hstack([model.B, np.eye(n, pseudo_forces)]))
    D[:, : len(model.inputs)] += model.Cu
    rows = np.array([model.port(law.place) for law in laws]).reshape(len(laws), n)
    E, F = entry(-rows.T)
    more = np.ones((n, 1))
    if noise_gain is not None:
        more[: len(noise_gain), 0] = noise_gain
    noises = np.hstack([model.B, np.diag(_stirred(model.M, model.K, own))])
    W, V = entry(more * noises)[0], entry(np.where(more > 0, noises, 0.0))[1]
    V[:, : len(model.inputs)] += model.Cu
    drift, rate = np.hstack([rows, 0 * rows]), np.hstack([0 * rows, rows])
    system = System(A, B, C, D, E, F, drift, rate, W, V, np.zeros((2 * n, 0)), n)
    plant = Plant(system, np.zeros((0, 0)), np.diag(model.M), np.diag(model.K))
    for port, rms, frequency in latent:
        rate_of = 2 * np.pi * frequency
        drive = np.array([rms * np.sqrt(2 * rate_of)])
        if port in model.outputs:
            seen = np.zeros((len(model.outputs), 1))
            seen[model.outputs.index(port)] = 1.0
            force = np.zeros((2 * n, 1)), seen
        else:
            force = entry(-model.port(port)[:, None])
        plant = _driven(plant, *force, np.array([[-rate_of]]), drive, np.ones(1))
    for mechanism in mechanisms:
        if isinstance(mechanism, Disturbance):
            block, drive, shape = mechanism.shaping()
            if sampled_s is not None:
                block, drive = calmed(block, drive, sampled_s)
            plant = _driven(plant, *_entry_of(model, mechanism, entry), block, drive, shape)
    for mechanism in mechanisms:
        if isinstance(mechanism, ChannelFault):
            plant = _seen_through(plant, model, mechanism, readings, sampled_s)
    return plant


def _stirred(M: Array, K: Array, own: int) -> Array:
    """Return the force that process noise of unit level is on each coordinate, (n,).

    It is a share of the inertia forces: of a mode 1, for its mass is; of what hangs on the
    structure, or gives way under it, its own mass times its quasi-static motion with every mode.

    Args:
        M: of all coordinates, (n, n).
        K: of all coordinates, (n, n).
        own: how many of them are the structure's modes.
    """
    square = np.diag(K)[:own] / np.diag(M)[:own]
    moved_by = K[own:, :own] - M[own:, :own] * square
    follows = moved_by / np.maximum(np.abs(np.diag(K)[own:]), 1e-300)[:, None]
    inertia = np.diag(M)[own:] * np.linalg.norm(follows, axis=1)
    return np.concatenate([np.ones(own), inertia])


def structure_of(model: LinearModel, mechanisms: Sequence[Mechanism]) -> LinearModel:
    """Return a model with changes of the structure, and the linear parts of laws.

    Raises:
        ValueError: they take more damping than there is: modes that no recording shows would grow,
            and energy come from nowhere.
    """
    changes = [m for m in mechanisms if isinstance(m, StructuralChange)]
    if changes:
        before = np.linalg.eigvalsh(model.R)
        for change in sorted(changes, key=lambda m: m.stage):
            model = change.edit(model)
        after = np.linalg.eigvalsh(model.R)
        if after[0] < min(before[0], 0.0) - ROUNDING * after[-1]:
            raise ValueError("less damping than none")
    for law in [m for m in mechanisms if isinstance(m, Law)]:
        model = model.adding(K=law.parted()[1], along=model.port(law.place))
    return model


def _entry_of(model: LinearModel, mechanism: Disturbance, entry: Any) -> tuple[Array, Array]:
    """Return where a disturbance acts: at a port, or as an acceleration of the whole base."""
    place = mechanism.place
    if place in model.places("base"):
        base = model.base[axis_of(model, place)]
        force, read = entry(-base.row[:, None])
        return force, read + base.acc[:, None]
    force, read = entry(model.port(place)[:, None])
    return force, read


def axis_of(model: LinearModel, place: str) -> str:
    """Return the axis of a place of kind "base"."""
    return dict(zip(model.places("base"), model.base, strict=False))[place]


def _driven(
    plant: Plant, force: Array, read: Array, block: Array, drive: Array, shape: Array
) -> Plant:
    """Return the plant with a force that white noise makes through a filter."""
    system, k = plant.system, len(block)
    n = len(system.A)
    into = np.zeros((n, k))
    into[: len(force)] = force @ shape[None]
    grown = _grown(system, k)
    A = grown.A + np.block([[np.zeros((n, n)), into], [np.zeros((k, n)), block]])
    C = grown.C + np.hstack([0 * system.C, read @ shape[None]])
    column = np.concatenate([np.zeros(n), drive])[:, None]
    start = solve_continuous_lyapunov(block, -np.outer(drive, drive))
    grown = replace(grown, A=A, C=C, G=np.hstack([grown.G, column]))
    return replace(plant, system=grown, start=block_diag(plant.start, start))


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
    A, C, W, V = (np.array(m) for m in (grown.A, grown.C, grown.W, grown.V))
    for i, index in enumerate(at):
        own, w = slice(n + i * k, n + (i + 1) * k), 2 * np.pi * bands[index]
        A[:n, own], C[:, own] = np.outer(W[:n, index], out), np.outer(V[:, index], out)
        A[own, own] = w * block
        W[:, index], V[:, index] = 0.0, 0.0
        W[own, index] = w * entry
    start = block_diag(plant.start, np.zeros((k * len(at), k * len(at))))
    return replace(plant, system=replace(grown, A=A, C=C, W=W, V=V), start=start)


@cache
def _low_pass() -> tuple[Array, Array, Array]:
    """Return A (k, k), B and C (k,) of a low-pass of 1 rad/s."""
    block, entry, out, _ = signal.tf2ss(*signal.butter(ORDER, 1.0, analog=True))
    return block, entry[:, 0], out[0]


def _seen_through(
    plant: Plant, model: LinearModel, fault: ChannelFault, readings: Mapping[str, float],
    sampled_s: float | None,
) -> Plant:  # fmt: skip
    """Return the plant whose channels are read through a faulty instrument."""
    system = plant.system
    if all(name in model.inputs for name in fault.channels):
        instrument = fault.instrument(0.0)
        if instrument is None:
            return plant
        # the true input is what was recorded, taken back
        at = [model.inputs.index(name) for name in fault.channels]
        B, D = np.array(system.B), np.array(system.D)
        inverse = np.linalg.inv(instrument.D)
        B[:, at], D[:, at] = B[:, at] @ inverse, D[:, at] @ inverse
        return replace(plant, system=replace(system, B=B, D=D))
    rows = [model.outputs.index(name) for name in fault.channels]
    instrument = fault.instrument(max(readings[name] for name in fault.channels))
    if instrument is None:
        return plant
    if sampled_s is not None:
        c = instrument.B.shape[1]
        A, BG = calmed(instrument.A, np.hstack([instrument.B, instrument.G]), sampled_s)
        instrument = replace(instrument, A=A, B=BG[:, :c], G=BG[:, c:])
    return _read(plant, rows, instrument)


def _read(plant: Plant, rows: Sequence[int], instrument: Instrument) -> Plant:
    system, k = plant.system, len(instrument.A)
    n, pick = len(system.A), list(rows)
    grown = _grown(system, k)
    A, B, E, W = (np.array(m) for m in (grown.A, grown.B, grown.E, grown.W))
    A[n:, :n] = instrument.B @ system.C[pick]
    A[n:, n:] = instrument.A
    B[n:], E[n:] = instrument.B @ system.D[pick], instrument.B @ system.F[pick]
    W[n:] = instrument.B @ system.V[pick]
    C, D, F, V = (np.array(m) for m in (grown.C, grown.D, grown.F, grown.V))
    for matrix in (C, D, F, V):
        matrix[pick] = instrument.D @ matrix[pick]
    C[pick, n:] = instrument.C
    g = instrument.G.shape[1]
    G = np.hstack([grown.G, np.zeros((n + k, g))])
    if g:
        G[n:, -g:] = instrument.G
    out = replace(grown, A=A, B=B, E=E, W=W, C=C, D=D, F=F, V=V, G=G)
    return replace(plant, system=out, start=block_diag(plant.start, instrument.start))


def _grown(system: System, k: int) -> System:
    """Return the system with k more states that nothing moves or sees yet."""

    def tall(m: Array) -> Array:
        return np.vstack([m, np.zeros((k, m.shape[1]))])

    def wide(m: Array) -> Array:
        return np.hstack([m, np.zeros((m.shape[0], k))])

    return replace(
        system,
        A=wide(tall(system.A)),
        B=tall(system.B),
        C=wide(system.C),
        E=tall(system.E),
        W=tall(system.W),
        G=tall(system.G),
        drift=wide(system.drift),
        rate=wide(system.rate),
    )
