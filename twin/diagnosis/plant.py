"""A linear model with mechanisms as one state-space system for the predictor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.discrepancy import Discrepancy
from twin.diagnosis.plant_states import Plant, Shaped, driven, driven_as_read, read_by
from twin.diagnosis.scales import ROUNDING
from twin.diagnosis.straight import calmed, well_damped
from twin.errors import NoLikelihoodError
from twin.estimation.system import System
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def plant_of(
    model: LinearModel,
    mechanisms: Sequence[Mechanism],
    latent: Sequence[Discrepancy],
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
        latent: each discrepancy.
        readings: RMS of each channel.
        noise_gain: by what noise stirs each of the first coordinates more than it does in steps
            from sample to sample, (n,), 0 where none is to; 1 without.
        pseudo_forces: further inputs, each a force on one of the first coordinates.
        step_s: sampling interval [s], if modes above half the sampling rate are not to ring.
        sampled_s: the same, if instruments and forces that nobody measured are not to, either.

    Raises:
        NoLikelihoodError: changes that take more damping than there is.
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
    shaped = []
    for one in latent:
        if one.place in model.outputs:
            seen = np.zeros((len(model.outputs), 1))
            seen[model.outputs.index(one.place)] = 1.0
            force = np.zeros((2 * n, 1)), seen
        else:
            force = entry(-model.port(one.place)[:, None])
        shaped.append(Shaped(*force, *_calm(one.shaping(), sampled_s)))
    for mechanism in mechanisms:
        if isinstance(mechanism, Disturbance):
            shaping = _calm(mechanism.shaping(), sampled_s)
            shaped.append(Shaped(*_entry_of(model, mechanism, entry), *shaping))
    plant = driven(plant, shaped)
    for mechanism in mechanisms:
        if isinstance(mechanism, ChannelFault):
            plant = _seen_through(plant, model, mechanism, readings, sampled_s)
    return plant


def _calm(shaping: tuple[Array, Array, Array], step_s: float | None) -> tuple[Array, Array, Array]:
    """Return a filter that does not ring above half the sampling rate; as it is without a step."""
    block, drive, shape = shaping
    if step_s is None:
        return shaping
    return *calmed(block, drive, step_s), shape


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
        NoLikelihoodError: they are not finite, or take more damping than there is: modes that no
            recording shows would grow, and energy come from nowhere.
    """
    changes = [m for m in mechanisms if isinstance(m, StructuralChange)]
    if changes:
        before = np.linalg.eigvalsh(model.R)
        for change in sorted(changes, key=lambda m: m.stage):
            model = change.edit(model)
        after = np.linalg.eigvalsh(model.R)
        if after[0] < min(before[0], 0.0) - ROUNDING * after[-1]:
            raise NoLikelihoodError("less damping than none")
    for law in [m for m in mechanisms if isinstance(m, Law)]:
        model = model.adding(K=law.parted()[1], along=model.port(law.place))
    if not all(np.all(np.isfinite(X)) for X in (model.M, model.R, model.K)):
        raise NoLikelihoodError("a structure without bounds")
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


def _seen_through(
    plant: Plant, model: LinearModel, fault: ChannelFault, readings: Mapping[str, float],
    sampled_s: float | None,
) -> Plant:  # fmt: skip
    """Return the plant whose channels are read through a faulty instrument."""
    instrument = fault.instrument(max(readings[name] for name in fault.channels))
    if instrument is None:
        return plant
    if sampled_s is not None:
        c = instrument.B.shape[1]
        A, BG = calmed(instrument.A, np.hstack([instrument.B, instrument.G]), sampled_s)
        instrument = replace(instrument, A=A, B=BG[:, :c], G=BG[:, c:])
    if all(name in model.inputs for name in fault.channels):
        return driven_as_read(plant, [model.inputs.index(n) for n in fault.channels], instrument)
    return read_by(plant, [model.outputs.index(n) for n in fault.channels], instrument)
