"""A linear system with places for forces: continuous, and exactly sampled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from twin.estimation.decoupled import Decoupled, decoupled
from twin.estimation.lifted import Lifted, lifted
from twin.estimation.low_pass import MOMENTS, TO_POWERS, LowPass, in_moments, twice, weights

Array = NDArray[np.float64]

SHORT = 1.0
"""Norm of A h up to which a step counts as short: nothing grows by more than e in it."""


@dataclass(frozen=True)
class System:
    """x' = A x + B u + E f + W n + G w,  y = C x + D u + F f + V n + v.

    Attributes:
        A: (n, n).
        B, D: of the inputs u, (n, r), (m, r).
        C: of the outputs, (m, n).
        E, F: of the laws' forces f, (n, l), (m, l).
        drift, rate: displacement and velocity at the laws' ports, (l, n).
        W, V: of disturbances n that are constant over a sample and white from one to the next,
            (n, w), (m, w): noise of the measured inputs, process noise.
        G: of continuous white noises w of unit intensity, (n, g): they drive latent forces.
        coordinates: of the structure: their displacements are the first states, their velocities
            the next ones.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    E: Array
    F: Array
    drift: Array
    rate: Array
    W: Array
    V: Array
    G: Array
    coordinates: int = 0


@dataclass(frozen=True)
class Noise:
    """The levels of one recording's noise.

    Attributes:
        held: standard deviation of the disturbances that are held over a sample, (w,).
        output: standard deviation of the white noise of each output, (m,).
        start: covariance of the state before the first sample, (n, n).
        kicks: samples before which the state is less certain, and by what covariance, (n, n).
    """

    held: Array
    output: Array
    start: Array
    kicks: Mapping[int, Array] = field(default_factory=dict)

    def in_order(self) -> tuple[NDArray[np.int64], Array]:
        """Return the samples of kicks in their order, (kicks,), and the kicks, (kicks, n, n)."""
        at = sorted(self.kicks)
        shape = len(at), *self.start.shape
        return np.array(at, np.int64), np.array([self.kicks[k] for k in at]).reshape(shape)


@dataclass(frozen=True)
class Sampled:
    """A system stepped exactly: x+ = A x + B0 u + B1 u+ + E f + W n over a part of a sample.

    Attributes:
        A, B0, B1, E, W: over one of ``steps`` equal parts of a sample; inputs are linear in it.
        whole: A over the whole sample, (n, n).
        entry: W over the whole sample, (n, w).
        Q: covariance that the continuous white noises leave after a sample, (n, n).
        steps: parts of a sample.
        step_s: length of a part [s].
        system: the continuous system, for its outputs.
        driven: where the laws are simulated and filtered.
    """

    A: Array
    B0: Array
    B1: Array
    E: Array
    W: Array
    whole: Array
    entry: Array
    Q: Array
    steps: int
    step_s: float
    system: System
    driven: Driven | None = None

    @cached_property
    def lifted(self) -> Lifted:
        """The steps of a sample at once."""
        return lifted(self)

    @cached_property
    def modes(self) -> Decoupled:
        """Coordinates in which the modes do not move one another."""
        return decoupled(self.system.A)


@dataclass(frozen=True)
class Driven:
    """A system whose laws' forces are inputs: they come from a simulation and pass a filter.

    Attributes:
        plant: with (1 + MOMENTS) l further inputs: the filtered forces at a sample, which the
            outputs see, and their Legendre coefficients until the next one, which drive the states;
            it has no laws.
        weights: of the moments of the forces around a sample for these inputs, (1 + MOMENTS, taps).
        twice: the same of the filtered forces at a sample and half a sample later, (2, taps).
        simulated: the system as it is simulated with its laws.
    """

    plant: Sampled
    weights: Array
    twice: Array
    simulated: Sampled


def transition(A: Array, B: Array, h: float, ramps: int) -> tuple[Array, Array, Array]:
    """Return what a linear system does in h seconds, exactly (Van Loan 1978).

    Args:
        A: of x' = A x + B u, (n, n).
        B: of the inputs, (n, k).
        h: time [s].
        ramps: inputs, the first ones, whose slopes are asked for.

    Returns:
        e^(A h), the influence of inputs of constant 1 (n, k), and of inputs t/h (n, ramps).
    """
    n, k = B.shape
    big = np.zeros((n + k + ramps, n + k + ramps))
    big[:n, :n], big[:n, n : n + k] = A * h, B * h
    big[n : n + ramps, n + k :] = np.eye(ramps)
    with np.errstate(over="ignore", invalid="ignore"):  # what runs away has no stationary filter
        power = expm(big)
    return power[:n, :n], power[:n, n : n + k], power[:n, n + k :]


def of_powers(A: Array, B: Array, h: float, count: int) -> Array:
    """Return what inputs (t/h)^k / k! do to x' = A x + B u in h seconds, (count, n, inputs).

    Exactly, as ``transition`` does: k counts from 0.
    """
    n, inputs = B.shape
    big = np.zeros((n + count * inputs, n + count * inputs))
    big[:n, :n], big[:n, n : n + inputs] = A * h, B * h
    last = n + (count - 1) * inputs
    big[n:last, n + inputs :] = np.eye((count - 1) * inputs)
    with np.errstate(over="ignore", invalid="ignore"):  # what runs away has no stationary filter
        power = expm(big)[:n, n:]
    return np.asarray(power.reshape(n, count, inputs).swapaxes(0, 1))


def sampled(
    system: System, step_s: float, steps: int, held: NDArray[np.bool_],
    low_pass: LowPass | None = None, own: System | None = None,
) -> Sampled:  # fmt: skip
    """Discretise exactly by the matrix exponential (Van Loan 1978).

    Args:
        system: the continuous system.
        step_s: sampling interval [s].
        steps: parts into which a sample is divided for the laws.
        held: inputs that are held from sample to sample instead of linear in between, (r,).
        low_pass: that the forces of the laws pass before they are seen, if any.
        own: the system as it is simulated with its laws; the same one without.
    """
    r, forces = system.B.shape[1], system.E.shape[1]
    entries = np.hstack([system.B, system.E, system.W])
    A, first, second = transition(system.A, entries, step_s / steps, r)
    B0 = np.where(held, first[:, :r], first[:, :r] - second)
    B1 = np.where(held, 0.0, second)
    W = first[:, r + forces :]
    whole, entry = A, W
    for _ in range(steps - 1):
        whole, entry = A @ whole, A @ entry + W
    plant = Sampled(
        A, B0, B1, first[:, r : r + forces], W, whole, entry,
        noise_integral(system.A, system.G, step_s), steps, step_s / steps, system,
    )  # fmt: skip
    if low_pass is None:
        return plant
    alone = plant if own is None or own is system else sampled(own, step_s, steps, held)
    return replace(plant, driven=_driven(plant, held, low_pass, alone))


def deviating(plant: Sampled, tangent: Array) -> Sampled:
    """Return the system of small deviations from a simulation with the laws; nothing drives it.

    Noise of the inputs is in the simulation, and moves it away from the motion: by how much is a
    matter of what the laws do then, as where friction holds and noise cannot move what it holds.

    Args:
        plant: the system.
        tangent: the laws' forces for small deviations, (l, n).
    """
    own, step_s = plant.system, plant.steps * plant.step_s
    n, m = len(own.A), len(own.C)
    system = replace(
        own, A=own.A + own.E @ tangent, C=own.C + own.F @ tangent, E=np.zeros((n, 0)),
        F=np.zeros((m, 0)), drift=np.zeros((0, n)), rate=np.zeros((0, n)),
    )  # fmt: skip
    whole, entry, Q = plant.whole, plant.entry, plant.Q
    if np.any(tangent):
        whole, entry, _ = transition(system.A, system.W, step_s, 0)
        Q = noise_integral(system.A, system.G, step_s)
    return Sampled(whole, 0 * plant.B0, 0 * plant.B1, system.E, entry, whole, entry, Q, 1, step_s,
                   system)  # fmt: skip


def _driven(plant: Sampled, held: NDArray[np.bool_], low_pass: LowPass, alone: Sampled) -> Driven:
    """Return a sampled system with the filtered forces of its laws as inputs."""
    system = plant.system
    (n, r), forces, m = system.B.shape, system.E.shape[1], len(system.C)
    step_s = plant.steps * plant.step_s
    _, first, second = transition(system.A, system.B, step_s, r)
    B0 = np.where(held, first, first - second)
    B1 = np.where(held, 0.0, second)
    none, shown = np.zeros((n, forces)), np.zeros((n, (1 + MOMENTS) * forces))
    powers = of_powers(system.A, system.E, step_s, MOMENTS)
    moments = np.einsum("dk,knl->dnl", TO_POWERS, powers)
    without = replace(
        system,
        D=np.hstack([system.D, system.F, np.zeros((m, MOMENTS * forces))]),
        E=np.zeros((n, 0)), F=np.zeros((m, 0)), drift=np.zeros((0, n)), rate=np.zeros((0, n)),
    )  # fmt: skip
    linear = replace(
        plant, A=plant.whole, B0=np.hstack([B0, none, *moments]), B1=np.hstack([B1, shown]),
        E=none[:, :0], W=plant.entry, steps=1, step_s=step_s, system=without,
    )  # fmt: skip
    seen, doubled = (in_moments(of, low_pass, plant.steps) for of in (weights, twice))
    return Driven(linear, seen, doubled, alone)


def noise_integral(A: Array, G: Array, step_s: float) -> Array:
    """Return the covariance that white noise of unit intensity through G leaves after one step.

    By the block exponential (Van Loan 1978) over a part of the step in which nothing moves far, and
    by doubling: where the system's modes decay the block's grow, and overflow over a whole step.

    Args:
        A: (n, n).
        G: (n, g).
        step_s: the step [s].

    Returns:
        (n, n); what overflows is not finite.
    """
    n = len(A)
    if not G.size:
        return np.zeros((n, n))
    size = float(np.linalg.norm(A, 1)) * step_s
    if not np.isfinite(size):
        return np.full((n, n), np.nan)
    doublings = max(int(np.ceil(np.log2(max(size, SHORT) / SHORT))), 0)
    block = np.block([[-A, G @ G.T], [np.zeros((n, n)), A.T]]) * step_s / 2**doublings
    power = expm(block)
    move = power[n:, n:].T
    Q = move @ power[:n, n:]
    for _ in range(doublings):
        Q, move = Q + move @ Q @ move.T, move @ move
    return np.asarray((Q + Q.T) / 2)
