"""The predictor's pass over one recording."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twin.arrays import plain
from twin.estimation.kalman import Gains
from twin.estimation.law_averages import LawAverages
from twin.estimation.laws import addresses, no_memory
from twin.estimation.lifted import Lifted
from twin.estimation.low_pass import REACH
from twin.estimation.model import Assembly, Trial
from twin.estimation.sensitivities import (
    STEP,
    Slopes,
    deviation_matrix,
    gain_matrices,
    no_slopes,
    numbers_of,
    read_matrix,
    simulation_matrix,
)
from twin.estimation.simulated import filtered, simulate
from twin.estimation.stepping import predict
from twin.estimation.system import Sampled
from twin.estimation.trust import doubt_of, trust_in

Array = NDArray[np.float64]
Added = tuple[Array, int]
"""What comes to a state before a sample, (n,), and which sample."""


@dataclass(frozen=True)
class Run:
    """The predictor's pass over one recording.

    Attributes:
        e: innovations, (samples, m); zero where nothing was measured.
        de: their derivatives, (samples, m, p); p = 0 without.
        x: states before each sample, (samples, n).
        z: memories of the laws, (samples, l, parts).
        f: forces of the laws at the samples, (samples, l).
        gains: of the predictor.
        sampled: the sampled system.
        averages: what the laws do on the average of the motion.
    """

    e: Array
    de: Array
    x: Array
    z: Array
    f: Array
    gains: Gains
    sampled: Sampled
    averages: LawAverages

    def moved(self, x: Array | None = None) -> tuple[Array, Array]:
        """Return displacements and velocities of the coordinates, (samples, coordinates) each.

        Args:
            x: states, (samples, n); those before each sample without.
        """
        n, x = self.sampled.system.coordinates, self.x if x is None else x
        return x[:, :n], x[:, n : 2 * n]

    @property
    def covariances(self) -> Array:
        """Of the innovations and what is uncertain beside, (samples, m, m)."""
        innovation, blur = self.gains.innovation, self.averages.blur
        S = innovation[np.minimum(np.arange(len(self.e)), len(innovation) - 1)]
        return S if blur is None else S + blur[:, :, None] * np.eye(S.shape[1])

    @property
    def begun(self) -> bool:
        """Whether its laws followed the motion from an estimated start."""
        return self.sampled.driven is None and self.averages.start is not None


@dataclass(frozen=True)
class Simulation:
    """A simulation with the laws, their forces behind the analyser's filter, beside a recording.

    Attributes:
        e: what the outputs read beyond it, (samples, m); zero where nothing was measured.
        de: derivatives with respect to the first q unknowns of the stepping loop, (samples, m, q).
        x, z, f: states, memories and filtered forces, as those of a run.
        forces: of the laws over the parts of the samples, as they are, (parts, l).
        moved: displacements, then rates, at their ports where each part begins and where the last
            one ends, (parts + 1, 2 l).
    """

    e: Array
    de: Array
    x: Array
    z: Array
    f: Array
    forces: Array
    moved: Array


def run(
    assembly: Assembly,
    trial: Trial,
    plant: Sampled,
    gain: Gains,
    slopes: Slopes | None = None,
    x0: Array | None = None,
    z0: Array | None = None,
    begin_s: float = 0.0,
    dx0: Array | None = None,
    averages: LawAverages | None = None,
    added: Added | None = None,
) -> Run:
    """Step the predictor over one recording.

    Args:
        assembly: for laws and numbers.
        trial: the recording.
        plant: its sampled system.
        gain: gains of the predictor.
        slopes: derivatives with respect to p unknowns; without, only the first state changes.
        x0: state before the first sample, (n,), or rest.
        z0: memories of the laws before it, (l, parts), or zero.
        begin_s: time of the first sample [s].
        dx0: derivatives of the first state, (n, p).
        averages: what the laws do on the average of the motion; they blur nothing without.
        added: what comes to the state before a sample; no laws are simulated then.
    """
    numbers, averages, n = numbers_of(assembly), averages or LawAverages(), len(plant.A)
    d = slopes or no_slopes(plant, gain, numbers, 0 if dx0 is None else dx0.shape[1])
    p = len(d.order)
    known = averages.start if x0 is None else x0
    begun = np.zeros(n) if known is None else plain(known)
    dfirst = np.zeros((n, p)) if dx0 is None else plain(dx0[:, d.order])
    memories = no_memory(assembly.laws) if z0 is None else plain(z0)
    trust = trust_in(gain, averages.blur)
    if plant.driven is None:
        passed = _stepped(
            plant, assembly, trial, gain_matrices(gain), trust, doubt_of(gain, trust, d), begun,
            dfirst, memories, begin_s, d, added,
        )  # fmt: skip
        return Run(*passed, gain, plant, averages)
    told = p if dx0 is not None else d.numbers.shape[2]
    found = simulated(plant, assembly, trial, begun, plain(dfirst[:, :told]), memories, begin_s, d)
    filtering = averages.filtering(plant)
    e, de, deviation = deviations(filtering, trial, gain, trust, found, d)
    f = found.f + deviation @ averages.tangent(plant.system).T
    return Run(e, de, found.x + deviation, found.z, f, gain, plant, averages)


def passed(
    here: Assembly, index: int, plant: Sampled, gain: Gains, averages: LawAverages,
    slopes: Slopes | None, added: Added | None = None,
) -> Run:  # fmt: skip
    """Return the pass over one recording of an assembly, with derivatives where there are slopes.

    Those by what changes the samples themselves are differences of passes. The arguments are those
    of ``run``, and which recording it is.
    """
    of = partial(run, here, plant=plant, gain=gain, averages=averages, added=added)
    found = of(here.trials[index], slopes=slopes)
    for place, assembly in slopes.taken_back.items() if slopes else ():
        moved = of(assembly.trials[index])
        found.de[:, :, place] = (moved.e - found.e) / STEP
    return found


def _stepped(
    plant: Sampled, assembly: Assembly, trial: Trial, gain: Array, trust: Array, doubt: Array,
    x0: Array, dx0: Array, z0: Array, begin_s: float, d: Slopes, added: Added | None,
) -> tuple[Array, Array, Array, Array, Array]:  # fmt: skip
    """Return innovations, their derivatives, states, memories and forces of a plant with laws."""
    (samples, m), laws = trial.y.shape, len(assembly.laws)
    joining, joining_at = added or (np.zeros(len(x0)), -1)
    e, de = np.empty((samples, m)), np.empty((samples, m, len(d.order)))
    x, f = np.empty((samples, len(x0))), np.empty((samples, laws))
    z = np.empty((samples, *z0.shape))
    step, read, dstep, dread = plant.lifted, read_matrix(plant), d.step, d.read
    u, between = trial.u, trial.between
    if d.missed.size:
        # what lines miss is in the outputs already; its derivatives come as inputs that they read
        n, r = len(x0), u.shape[1]
        at, seen = plant.W.shape[1] + np.repeat([n + r, n + 2 * r], m), np.repeat(n + r, m)
        step, dstep = _with_inputs(step, at), _with_inputs(dstep, at)
        read, dread = np.insert(read, seen, np.eye(m), axis=1), np.insert(dread, seen, 0.0, axis=1)
        u, between = (np.pad(a, ((0, 0), (0, m))) for a in (u, between))
    predict(
        addresses(assembly.laws), step.over, step.reach, step.push, plain(read),
        np.vstack([plant.system.drift, plant.system.rate]), numbers_of(assembly), gain, trust,
        doubt, plain(u), plain(between), plain(d.missed), plain(trial.y), x0, z0,
        joining, joining_at, begin_s, trial.step_s, plain(assembly.scales), dstep.over, dstep.reach,
        dstep.push, dread, d.gain, d.numbers, dx0, d.order, e, de, x, z, f,
    )  # fmt: skip
    return e, de, x, z, f


def _with_inputs(step: Lifted, at: NDArray[np.int64]) -> Lifted:
    """Return a step, or its derivatives, with inputs that move nothing."""
    return Lifted(np.insert(step.over, at, 0.0, 1), np.insert(step.reach, at, 0.0, 2), step.push)


def simulated(
    plant: Sampled, assembly: Assembly, trial: Trial, x0: Array, dx0: Array, z0: Array,
    begin_s: float, d: Slopes,
) -> Simulation:  # fmt: skip
    """Return a simulation whose laws' forces pass the filter before they drive and are seen.

    Args:
        plant: the sampled system.
        assembly: for the laws.
        trial: the recording.
        x0: state before the first sample, (n,).
        dx0: its derivatives, (n, q).
        z0: memories of the laws there, (l, parts).
        begin_s: time of the first sample [s].
        d: derivatives.
    """
    assert plant.driven is not None
    (samples, m), numbers = trial.y.shape, numbers_of(assembly)
    laws, q, own = len(numbers), dx0.shape[1], plant.driven.plant
    weights = plant.driven.weights
    fine = trial.finely(assembly.held, plant.steps)
    parts = (samples + 2 * REACH + 1) * plant.steps  # as far as the filter reaches
    forces, dforces = np.empty((parts, laws)), np.empty((parts, laws, q))
    ports = np.vstack([plant.system.drift, plant.system.rate])
    z, moved = np.empty((samples, *z0.shape)), np.empty((parts + 1, 2 * laws))
    modes = plant.driven.simulated.modes
    simulate(addresses(assembly.laws), modes.of_step(simulation_matrix(plant)), modes.near,
             ports @ modes.to, numbers, plain(fine), modes.back @ x0, z0, begin_s, plant.steps,
             trial.step_s, plain(assembly.scales), modes.of_step(d.simulated), d.numbers,
             modes.back @ dx0, forces, dforces, z, moved)  # fmt: skip
    more, du = (plain(part) for part in
                filtered(forces, dforces, weights, plant.steps, samples))  # fmt: skip
    e, de, x = np.empty((samples, m)), np.empty((samples, m, q)), np.empty((samples, len(x0)))
    none, n, held = np.zeros((samples, 0)), len(x0), own.W.shape[1]
    still, over, dover = no_memory(()), own.lifted, d.step
    predict(
        addresses(()), over.over, over.reach, over.push, read_matrix(own), np.zeros((0, n)),
        numbers[:0], np.zeros((1, n + held, m)), np.zeros((0, 0, 0)), np.zeros((0, 0, 0, 0)),
        plain(np.hstack([trial.u, more[:, :laws], 0 * more[:, laws:]])),
        plain(np.hstack([trial.between, more])), du if q else np.zeros((0, 0, 0)), plain(trial.y),
        x0, still, np.zeros(n), -1, begin_s, trial.step_s,
        np.ones((0, 4)), dover.over, dover.reach, dover.push, d.read,
        np.zeros((1, n + held, m, q)), d.numbers[:0], dx0, np.arange(q), e, de, x,
        np.zeros((samples, *still.shape)), none.copy(),
    )  # fmt: skip
    measured = ~np.isnan(trial.y)
    if d.missed.size:
        de[:, :, : d.missed.shape[2]] -= d.missed * measured[:, :, None]
    if assembly.ringing is not None:
        every = np.concatenate([forces[:, :, None], dforces], axis=2)
        drives = np.concatenate([more[:, :, None], du], axis=2)
        with np.errstate(all="ignore"):  # laws that run away are hopeless, with what they ring
            beyond = assembly.ringing.beyond(
                every, drives, plant.driven.twice, plant.steps, trial.step_s
            )
        e -= beyond[:, :, 0] * measured
        de -= beyond[:, :, 1:] * measured[:, :, None]
    return Simulation(e, de, x, z, more[:, :laws].copy(), forces, moved)


def deviations(
    plant: Sampled, trial: Trial, gain: Gains, trust: Array, beyond: Simulation, d: Slopes
) -> tuple[Array, Array, Array]:
    """Return innovations, their derivatives, and deviations from a simulation, (samples, n).

    None before the first sample, with which the simulation begins.

    Args:
        plant: of the deviations.
        trial: the recording.
        gain: of the predictor.
        trust: as ``predict`` takes it.
        beyond: the simulation.
        d: derivatives.
    """
    (samples, m), n, p = beyond.e.shape, len(plant.A), len(d.order)
    e, de, x = np.empty((samples, m)), np.empty((samples, m, p)), np.empty((samples, n))
    still, systems = no_memory(()), d.deviating.shape[2]
    none = np.zeros((1, 0, 0))  # no ports
    dstep = np.concatenate([d.deviating, np.zeros((n, 2 * m, systems))], axis=1)
    dread = np.concatenate([d.read_deviating, np.zeros((m, m, systems))], axis=1)
    # what lies beyond the simulation is an input that is taken off readings of nothing
    predict(
        addresses(()), np.hstack([deviation_matrix(plant), np.zeros((n, 2 * m))]), none, none,
        np.hstack([plant.system.C, -np.eye(m)]), np.zeros((0, n)), np.zeros((0, 0)),
        gain_matrices(gain), trust, doubt_of(gain, trust, d), plain(beyond.e),
        np.zeros((samples, m)),
        beyond.de if beyond.de.size else np.zeros((0, 0, 0)),
        plain(np.where(np.isnan(trial.y), np.nan, 0.0)), np.zeros(n), still, np.zeros(n),
        -1, 0.0, trial.step_s, np.ones((0, 4)), dstep, none[..., None], none[..., None], dread,
        d.gain, np.zeros((0, 0, 0)), np.zeros((n, p)), d.order, e, de, x,
        np.zeros((samples, *still.shape)), np.zeros((samples, 0)),
    )  # fmt: skip
    return e, de, x
