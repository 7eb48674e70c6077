"""The linear part of a hypothesis as a state space with all that may enter it.

States are the places' displacements and velocities, then one state for every high-pass in a
channel and those of every disturbance's filter. Inputs are the measured ones, the forces of the
laws, and white force noise on every coordinate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from twin.diagnosis.trials import SHAKE_TABLE
from twin.mechanisms.mechanism import (
    ChannelFault,
    Disturbance,
    Law,
    Mechanism,
    StructuralChange,
)
from twin.mechanisms.replay import in_order
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]


KNOWN_FORCE = "law_"
"""Prefix of an input that is the known force of a law: "law_0_storey1" opposes that drift."""


@dataclass(frozen=True)
class Plant:
    """Continuous-time matrices: x' = A x + B u + E f + G w + H s, y = C x + D u + F f + L w.

    Attributes:
        A, B, C, D: as ever; u are the measured inputs.
        E, F: entry of the laws' forces f.
        G, L: entry of white force noise w on the coordinates.
        drive: entry of the disturbances' white noise, (n, disturbances), scaled to unit intensity.
        drift: drift of each law from the states, (laws, n).
        rate: its rate, (laws, n).
        model: M, R, K after all structural changes.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    E: Array
    F: Array
    G: Array
    L: Array
    drive: Array
    drift: Array
    rate: Array
    model: SecondOrderModel


def laws_of(mechanisms: Sequence[Mechanism]) -> tuple[Law, ...]:
    """Return the laws among the mechanisms, in order."""
    return tuple(m for m in mechanisms if isinstance(m, Law))


def place_vector(model: SecondOrderModel, place: str) -> Array:
    """Return b with the motion at a place = b^T x: a storey's drift or a place's displacement."""
    return model.port(place)


def build(
    base: SecondOrderModel,
    mechanisms: Sequence[Mechanism],
    inputs: Sequence[str],
    outputs: Sequence[str],
) -> Plant:
    """Assemble the plant of a hypothesis.

    Args:
        base: M, R, K of the model as it stands.
        mechanisms: what is added; parameters must be numbers.
        inputs: names of the measured inputs.
        outputs: names of the measured outputs.

    Raises:
        ModelError: a mechanism's place is not in the model.
    """
    model = base
    for mechanism in in_order(mechanisms):
        if isinstance(mechanism, StructuralChange):
            model = mechanism.edit(model)
    n = len(model.coordinates)
    inverse = np.linalg.inv(model.M)
    lower = -inverse @ np.hstack([model.K, model.R])
    A = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])
    table = "acc_ground" in inputs and SHAKE_TABLE not in outputs
    T = np.column_stack([_entry(model, name) for name in inputs])
    ground = np.array([float(name == SHAKE_TABLE) for name in inputs])
    laws = laws_of(mechanisms)
    vectors = [place_vector(model, law.place) for law in laws]
    b = np.column_stack(vectors) if vectors else np.zeros((n, 0))
    acc_u, acc_f, acc_w = inverse @ T, -inverse @ b, inverse

    def rows(full: Array, direct: Any, extra: Array | None = None) -> Array:
        """Pick each output's row out of accelerations (direct) or displacements (zero)."""
        out = []
        for name in outputs:
            kind, place = name.split("_", 1)
            if place not in model.coordinates:
                out.append(np.zeros(direct.shape[1]))
                continue
            index = model.coordinates.index(place)
            row = direct[index] if kind == "acc" else full[index]
            out.append(row + (extra if extra is not None and kind == "acc" else 0.0))
        return np.array(out).reshape(len(outputs), direct.shape[1])

    displacement = np.hstack([np.eye(n), np.zeros((n, n))])
    C = rows(displacement, lower)
    none = np.zeros((n, T.shape[1]))
    D = rows(none, acc_u, ground if table else None)
    F = rows(np.zeros((n, b.shape[1])), acc_f)
    L = rows(np.zeros((n, n)), acc_w)
    zero = np.zeros
    plant = Plant(
        A,
        np.vstack([zero((n, T.shape[1])), acc_u]),
        C,
        D,
        np.vstack([zero((n, b.shape[1])), acc_f]),
        F,
        np.vstack([zero((n, n)), acc_w]),
        L,
        zero((2 * n, 0)),
        np.vstack([b, 0 * b]).T,
        np.vstack([0 * b, b]).T,
        model,
    )
    for mechanism in mechanisms:
        if isinstance(mechanism, Disturbance):
            plant = _with_disturbance(plant, mechanism, outputs)
        elif isinstance(mechanism, ChannelFault) and (corner := mechanism.filter_hz()) is not None:
            plant = _with_highpass(plant, outputs.index(mechanism.place), corner)
    return plant


def _entry(model: SecondOrderModel, name: str) -> Array:
    """Where an input acts: a unit force, or the inertia forces of a shaken ground."""
    n = len(model.coordinates)
    if name.startswith(KNOWN_FORCE):
        return -place_vector(model, name.split("_", 2)[2])
    if name == SHAKE_TABLE:
        rigid = np.array([float(c != "pendulum") for c in model.coordinates])
        return -model.M @ rigid
    place = name.split("_", 1)[1]
    if place not in model.coordinates:
        return np.zeros(n)
    return model.port(place)


def _grown(plant: Plant, block: Array, into: Array) -> Plant:
    """Append states with their own dynamics ``block``, driving the old ones through ``into``."""
    n, extra = len(plant.A), len(block)
    A = np.block([[plant.A, into], [np.zeros((extra, n)), block]])

    def tall(m: Array) -> Array:
        return np.vstack([m, np.zeros((extra, m.shape[1]))])

    def wide(m: Array) -> Array:
        return np.hstack([m, np.zeros((m.shape[0], extra))])

    return Plant(
        A,
        tall(plant.B),
        wide(plant.C),
        plant.D,
        tall(plant.E),
        plant.F,
        tall(plant.G),
        plant.L,
        tall(plant.drive),
        wide(plant.drift),
        wide(plant.rate),
        plant.model,
    )


def _with_disturbance(plant: Plant, mechanism: Disturbance, outputs: Sequence[str]) -> Plant:
    """Add the filter that shapes a force from white noise; the force acts at the place."""
    block, drive, shape = mechanism.shaping()
    k, model = len(drive), plant.model
    shaken = mechanism.place == "ground" and "ground" not in model.coordinates
    if shaken:
        force = -model.M @ np.array([float(c != "pendulum") for c in model.coordinates])
    else:
        force = model.port(mechanism.place)
    n = len(model.coordinates)
    acceleration = np.linalg.solve(model.M, force)
    into = np.zeros((len(plant.A), k))
    into[n : 2 * n] = np.outer(acceleration, shape)
    if shaken:
        acceleration = acceleration + 1.0  # accelerometers see the ground's motion too
    grown = _grown(plant, block, into)
    C = grown.C.copy()
    for row, name in enumerate(outputs):
        kind, place = name.split("_", 1)
        if kind == "acc" and place in model.coordinates:
            C[row, -k:] += acceleration[model.coordinates.index(place)] * shape
        elif kind == "acc" and place == "ground" and shaken:
            C[row, -k:] += shape
    column = np.zeros((len(grown.A), 1))
    column[-k:, 0] = drive
    drive = np.hstack([grown.drive, column])
    return Plant(
        grown.A, grown.B, C, grown.D, grown.E, grown.F, grown.G, grown.L, drive,
        grown.drift, grown.rate, model,
    )  # fmt: skip


def _with_highpass(plant: Plant, row: int, corner_hz: float) -> Plant:
    """Pass one output through s / (s + w): its low-passed part is a state that is taken off."""
    w = 2 * np.pi * corner_hz
    n = len(plant.A)
    grown = _grown(plant, np.array([[-w]]), np.zeros((n, 1)))
    A, B, E, G, C = (m.copy() for m in (grown.A, grown.B, grown.E, grown.G, grown.C))
    A[n, :n] = w * plant.C[row]
    B[n] = w * plant.D[row]
    E[n] = w * plant.F[row]
    G[n] = w * plant.L[row]
    C[row, n] -= 1.0
    return Plant(
        A, B, C, grown.D, E, grown.F, G, grown.L, grown.drive, grown.drift, grown.rate, plant.model
    )


@dataclass(frozen=True)
class Sampled:
    """A plant between samples: x+ = A x + B0 u + B1 u+ + E0 f + E1 f+, and noise entries.

    Attributes:
        A, B0, B1, E0, E1: inputs are linear between samples (a column of B1 that is zero: held).
        G: entry of force noise that is white from sample to sample, (n, coordinates).
        Q: covariance of the disturbances' contribution, (n, n).
        plant: the continuous plant, for its outputs.
        step_s: from sample to sample [s].
    """

    A: Array
    B0: Array
    B1: Array
    E0: Array
    E1: Array
    G: Array
    Q: Array
    plant: Plant
    step_s: float


def sampled(plant: Plant, step_s: float, held: bool | NDArray[np.bool_] = False) -> Sampled:
    """Discretise exactly for inputs that are linear between samples, or held: all, or each (r,)."""
    n = len(plant.A)
    inputs = np.hstack([plant.B, plant.E, plant.G])
    r = inputs.shape[1]
    big = np.zeros((n + 2 * r, n + 2 * r))
    big[:n, :n] = plant.A * step_s
    big[:n, n : n + r] = inputs * step_s
    big[n : n + r, n + r :] = np.eye(r)
    power = expm(big)
    A, first, second = power[:n, :n], power[:n, n : n + r], power[:n, n + r :]
    zero, one = first - second, second
    k, e = plant.B.shape[1], plant.E.shape[1]
    Q = np.zeros((n, n))
    if plant.drive.shape[1]:
        Q = _noise_integral(plant.A, plant.drive @ plant.drive.T, step_s)
    ramp = np.broadcast_to(~np.asarray(held, bool), (k,))
    return Sampled(
        A,
        np.where(ramp, zero[:, :k], first[:, :k]),
        np.where(ramp, one[:, :k], 0.0),
        zero[:, k : k + e],
        one[:, k : k + e],
        first[:, k + e :],
        Q,
        plant,
        step_s,
    )


def _noise_integral(A: Array, spectral: Array, step_s: float) -> Array:
    """Covariance that white noise leaves after one step (Van Loan 1978)."""
    n = len(A)
    block = np.block([[-A, spectral], [np.zeros((n, n)), A.T]]) * step_s
    power = expm(block)
    return np.asarray(power[n:, n:].T @ power[:n, n:])
