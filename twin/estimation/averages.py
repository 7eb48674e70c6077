"""What laws do on the average of a recording's motion, and where they begin.

Where a law jumps an output is more uncertain than its noise, by variances that the forces
themselves tell (``Model.blur``), and by those of a state that is estimated. The state that laws
with corners begin with is integrated out by Laplace's method, for they are not linear about its
prior.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.estimation.acting import while_acting
from twin.estimation.density import density
from twin.estimation.instants import blown, unknown_instants
from twin.estimation.kalman import EquivalentLinear, gains
from twin.estimation.law_averages import LawAverages, both
from twin.estimation.laws import no_memory
from twin.estimation.model import Assembly, Model, Trial
from twin.estimation.passing import Run, Simulation, deviations, run, simulated
from twin.estimation.sensitivities import no_slopes, numbers_of
from twin.estimation.start import ROUGHLY, STEPS, estimated_start
from twin.estimation.system import Noise, Sampled, System, transition
from twin.estimation.trust import trust_in
from twin.estimation.unknown_forces import unknown_forces

Array = NDArray[np.float64]

SHARES = (0.1, 0.3, 1.0, 10.0, 100.0)
"""Of the dashpot that a law is on the average of a motion, what it may be for small deviations from
it, beside none: little where friction slides, any where it holds. Where one is known nearby its
neighbours are tried."""

ROUNDS = 10
"""Gauss-Newton steps at most to the state that a simulation begins with, each followed by another
dashpot, where none is known nearby: fits go on from there."""


def averages_at(
    model: Model, here: Assembly, plants: Sequence[Sampled], index: int,
    near: LawAverages | None = None, roughly: bool = False,
) -> LawAverages:  # fmt: skip
    """Return what the laws do on the average of a recording, by a pass that knows nothing of it.

    Their forces are replaced by k d + c v with the least mean square error.

    Args:
        model: whose laws they are.
        here: the model at values of its unknowns.
        plants: its sampled systems.
        index: of the recording.
        near: what they do at values nearby, which begin where these did; of a model with other
            states or laws it tells nothing.
        roughly: whether laws may begin roughly where they are likeliest to: values are compared,
            or a step is tried.
    """
    plant, trial = plants[here.which[index]], here.trials[index]
    if not here.laws:
        return _known(here, index)
    near = near if near is not None and near.may_begin(plant.system) else None
    if plant.driven is not None:
        blur = _ringing(model, here, plant.system, trial) if model.blurred else None
        kicks, seen = blown(here, index, plant)
        known = LawAverages(blur=both(both(blur, trial.blur), seen), kicks=kicks)
        value, found = _holding(here, index, plant, known, near, None, roughly)
        for _ in range(ROUNDS - 1 if near is None else 0):
            last = value
            value, found = _holding(here, index, plant, known, found, last, roughly)
            if not value > last + ROUGHLY:
                break
        return found
    return _following(model, here, index, plant, near, roughly)


def _known(here: Assembly, index: int) -> LawAverages:
    """Return what is uncertain in a recording beside a linear system."""
    samples = len(here.trials[index].y)
    blur = here.blurs[index] if here.blurs else here.trials[index].blur
    kicks = here.kicks[index] if here.kicks else {}
    return LawAverages(blur=blur, kicks={k: more for k, more in kicks.items() if k < samples})


def _following(
    model: Model, here: Assembly, index: int, plant: Sampled, near: LawAverages | None,
    roughly: bool,
) -> LawAverages:  # fmt: skip
    """Return averages of laws that follow the motion that is estimated.

    Those with corners follow it from a start that is estimated with them: a filter that begins
    anywhere takes friction for that of another motion.
    """
    trial, noise = here.trials[index], here.noises[index]
    if near is None or near.equivalent is None:
        passed = run(here, trial, plant, gains(plant, noise, missing=trial.missing))
        found = _of_pass(model, here, trial, noise, passed)
        if not model.blurred or found.equivalent is None:
            return found
        guess = here.near(index, plant.system)
        start = estimated_start(here, trial, plant, noise, found, guess=guess, roughly=roughly)
    else:
        blur = None if near.blur is None else near.blur[: len(trial.y)]
        kicks = {k: more for k, more in near.kicks.items() if k < len(trial.y)}
        found = replace(near, blur=blur, kicks=kicks)
        slopes = near.start_slopes if roughly else None
        start = estimated_start(here, trial, plant, noise, found, 1, near.start, slopes)
    found = found.begun(start)
    noise = found.beginning(noise)
    gain = gains(plant, noise, equivalent=found.equivalent, missing=trial.missing)
    again = _of_pass(model, here, trial, noise, run(here, trial, plant, gain, averages=found))
    return found if again.equivalent is None else again.begun(start)


def _of_pass(model: Model, here: Assembly, trial: Trial, noise: Noise, passed: Run) -> LawAverages:
    """Return averages of laws that follow the motion that a pass estimated."""
    if not (np.all(np.isfinite(passed.f)) and np.all(np.isfinite(passed.x))):
        return LawAverages()  # laws that run away here: another step will not go there
    plant, system = passed.sampled, passed.sampled.system
    blur = both(model.blur(passed.f, system) if model.blurred else None, trial.blur)
    slopes = np.zeros((len(here.laws), 2))
    for j, row in enumerate(system.drift):
        motion = np.column_stack([passed.x @ row, passed.x @ system.rate[j]])
        size = np.maximum(np.sqrt(np.mean(motion**2, axis=0)), 1e-300)
        slopes[j] = np.linalg.lstsq(motion / size, passed.f[:, j], rcond=None)[0] / size
    tangent = LawAverages(slopes=slopes).tangent(system)
    bare = while_acting(LawAverages(None, blur), plant, here.errors, passed.f)
    if not np.all(np.isfinite(tangent)):
        return bare
    with np.errstate(all="ignore"):  # laws that run away here: another step will not go there
        bent = system.A + system.E @ tangent
        whole = transition(bent, np.zeros((len(bent), 0)), plant.steps * plant.step_s, 0)[0]
    equivalent = EquivalentLinear(whole - plant.whole, system.F @ tangent)
    if not (np.all(np.isfinite(equivalent.whole)) and np.all(np.isfinite(equivalent.C))):
        return bare
    if model.blurred:
        with np.errstate(all="ignore"):  # where laws run away it has no density
            unknown = unknown_forces(here, passed, noise, equivalent, tangent)
            bare = replace(bare, blur=both(bare.blur, unknown**2 @ (system.F**2).T))
    return replace(bare, equivalent=equivalent, slopes=slopes)


def _holding(
    here: Assembly, index: int, plant: Sampled, averages: LawAverages, near: LawAverages | None,
    known: float | None, roughly: bool,
) -> tuple[float, LawAverages]:  # fmt: skip
    """Return averages with the start of the laws' simulation and dashpots for deviations from it.

    Of several dashpots the likeliest is taken. What was found nearby is tried as it is, so that the
    likelihood has no jumps where it can be followed.

    Args:
        here: the model at values of its unknowns.
        index: of the recording.
        plant: its sampled system.
        averages: without either.
        near: with both, as they were found nearby.
        known: log likelihood with these, where it was found for the very values.
        roughly: see ``averages_at``.

    Returns:
        The log likelihood with them, and the averages.
    """
    trial, noise = here.trials[index], here.noises[index]
    near = near or averages
    none = no_slopes(plant, gains(averages.filtering(plant), noise, missing=trial.missing),
                     numbers_of(here))  # fmt: skip

    def simulation(start: Array) -> Simulation:
        return simulated(plant, here, trial, start, np.zeros((len(start), 0)),
                         no_memory(here.laws), 0.0, none)  # fmt: skip

    def likelihood(of: LawAverages, there: Simulation) -> tuple[float, LawAverages]:
        try:
            filtering = of.filtering(plant)
            bare = replace(of, blur=averages.blur, kicks=averages.kicks, acting=None, errors=())
            late = unknown_instants(here, plant, noise, bare, there)
            of = replace(bare, blur=both(averages.blur, late))
            of = while_acting(of, plant, here.errors, there.f)
            gain = gains(filtering, of.beginning(noise), missing=trial.missing)
            trust = trust_in(gain, of.blur)
            e, _, _ = deviations(filtering, trial, gain, trust, there, none)
            value = density(e, trial.y, gain.innovation, of.blur).value + of.start_odds
        except np.linalg.LinAlgError:
            return -np.inf, of
        return (value if np.isfinite(value) else -np.inf), of

    blur = near.blur if near.blur is not None and len(near.blur) == len(trial.y) else averages.blur
    before = replace(averages, slopes=near.slopes, blur=blur, kicks=near.kicks)
    steps = STEPS if near.start is None else 1
    guess = here.near(index, plant.system)
    start = estimated_start(here, trial, plant, noise, before, steps, near.start, guess=guess,
                            roughly=roughly)  # fmt: skip
    there = simulation(start.state)
    v = there.x @ plant.system.rate.T
    work = np.maximum(np.sum(there.f * v, axis=0), 0.0)
    dashpots = work / np.maximum(np.sum(v**2, axis=0), 1e-300)
    begun = averages.begun(start)
    tried = [replace(begun, share=share, slopes=np.outer(dashpots * share, (0.0, 1.0)))
             for share in _shares(near)]  # fmt: skip
    scored = [likelihood(of, there) for of in tried]
    if near.start is not None:
        kept = replace(near, blur=blur)
        there = simulation(near.start) if known is None else there
        scored.append(likelihood(kept, there) if known is None else (known, kept))
    return max(scored, key=lambda pair: pair[0])


def _shares(near: LawAverages) -> tuple[float, ...]:
    """Return the shares of dashpots to try beside what was found nearby, all where nothing was."""
    every = (0.0, *SHARES)
    if near.start is None:
        return every
    at = every.index(near.share)
    return every[max(at - 1, 0) : at + 2]


def _ringing(model: Model, here: Assembly, system: System, trial: Trial) -> Array:
    """Return variances of outputs, (samples, m), because a filtered input rings about its jumps.

    A law that holds follows the ringing with its force, as far as it can; the force that was
    filtered did not ring.
    """
    size = np.zeros(len(here.laws))
    for j, law in enumerate(here.laws):
        _, d, v = here.scales[j, :3]
        size[j] = abs(float(law.force(d, v, 0.0, 0.0, *here.numbers[j, : law.count])))
    held = np.einsum("ln,nr->lr", system.rate, system.B)
    held /= np.einsum("ln,nl->l", system.rate, system.E)[:, None]
    return np.minimum(model.blur(trial.rest @ held.T, system), size**2 @ (system.F**2).T)
