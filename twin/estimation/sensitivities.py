"""Derivatives of sampled systems, gains and laws' numbers with respect to the unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.estimation.first_state import Settled
from twin.estimation.first_state_slopes import SettledSlopes, settled_slopes
from twin.estimation.kalman import Gains, gains, silent
from twin.estimation.lifted import Lifted
from twin.estimation.neighbours import neighbouring_gains
from twin.estimation.parallel import each
from twin.estimation.system import Sampled, sampled

if TYPE_CHECKING:
    from twin.estimation.law_averages import LawAverages
    from twin.estimation.model import Assembly, Model, Unknown

Array = NDArray[np.float64]

STEP, LEVEL_STEP = 1e-4, 3e-4
"""Steps of the differences of matrices and gains, in prior standard deviations, and of what noise
levels make of gains: between rounding, of gains whose recursion begins 1e10 times as wide as the
noise (1e-6 over the step), and curvature (1e-4 where a resonance moves by a per cent; a level's is
its step, and scales both sides of the balance that it is found by)."""

LATEST = 1024
"""Samples within which a blow's kick counts in the derivatives of gains: they need every sample's
to the last one."""

ORDER = ("system", "law", "noise", "samples", "error")
"""Roles in the order of the stepping loop's columns: what each changes is a part of what the first
does (a noise level changes gains alone, a fault taken back in the samples none of them). What an
error of laws changes needs passes of its own."""


@dataclass(frozen=True)
class Slopes:
    """Derivatives of one trial's matrices with respect to the unknowns, these in the last axis.

    Attributes:
        step, read, gain, numbers: as the stepping loop takes them, in its order.
        simulated: of the steps of the laws' simulation, where there is one.
        deviating, read_deviating: of what steps deviations from it, and of how outputs read them.
        innovation: of the innovations' covariances, (t, m, m, p), in the order of ``columns``.
        columns: the unknowns that change this trial, as they are counted in the model.
        order: the place in ``columns`` of each of the stepping loop's columns, (p,).
        missed: of what inputs do to the outputs beyond their lines, (samples, m, .), for the first
            of the stepping loop's unknowns; none where nothing of it changes.
        taken_back: for unknowns that change the samples themselves, their place in ``columns`` and
            the assembly a step away.
        erring: the same, for unknowns that say how far laws are off while they act.
        settled: where the first state is integrated out beside stationary gains.
        settled_columns: the places in ``columns`` of the unknowns that change these.
    """

    step: Lifted
    read: Array
    gain: Array
    numbers: Array
    simulated: Array
    deviating: Array
    read_deviating: Array
    innovation: Array
    missed: Array
    columns: list[int]
    order: NDArray[np.int64]
    taken_back: dict[int, Assembly]
    erring: dict[int, Assembly]
    settled: SettledSlopes | None = None
    settled_columns: NDArray[np.int64] | None = None

    def until(self, count: int) -> Array:
        """Return ``innovation`` at the first samples and the last one, (t, m, m, p), t <= count.

        Gains after a gap may settle sooner than those without it, whose slopes these are.
        """
        settled = min(len(self.innovation), count) - 1
        return np.concatenate([self.innovation[:settled], self.innovation[-1:]])


def plants_of(assembly: Assembly, model: Model) -> list[Sampled]:
    """Return the sampled systems of an assembly."""
    step_s = model.trials[0].step_s
    low_pass = assembly.low_pass if assembly.laws else None
    own = assembly.own or assembly.systems
    return [
        sampled(s, step_s, assembly.steps, assembly.held, low_pass, alone)
        for s, alone in zip(assembly.systems, own, strict=True)
    ]


def simulation_matrix(plant: Sampled) -> Array:
    """Return x+ of a simulation over a part of a sample, by (x, u, u+, f), (n, n + 2 r + l)."""
    own = plant if plant.driven is None else plant.driven.simulated
    return np.hstack([own.A, own.B0, own.B1, own.E])


def predicting(plant: Sampled) -> Sampled:
    """Return the system that inputs step: that without laws where they are simulated."""
    return plant if plant.driven is None else plant.driven.plant


def deviation_matrix(plant: Sampled) -> Array:
    """Return x+ of deviations over a sample, by (x, n), (n, n + w)."""
    return np.hstack([plant.A, plant.W])


def read_matrix(plant: Sampled) -> Array:
    """Return the outputs by (x, u, f), (m, n + r + l)."""
    system = plant.system
    return np.hstack([system.C, system.D, system.F])


def gain_matrices(gain: Gains) -> Array:
    """Return corrections of state and held disturbances, (t, n + w, m)."""
    return np.concatenate([gain.state, gain.held], axis=1)


def numbers_of(assembly: Assembly) -> Array:
    """Return the laws' numbers, no wider than the law that takes most, (l, most)."""
    most = max((law.count for law in assembly.laws), default=0)
    return np.array(assembly.numbers[:, :most], float)


def slopes_of(
    model: Model,
    z: Array,
    here: Assembly,
    plants: Sequence[Sampled],
    averages: Sequence[LawAverages],
    free: NDArray[np.bool_],
    listens: bool = True,
    settled: Sequence[Settled | None] | None = None,
) -> tuple[Slopes, ...]:
    """Return the derivatives of each trial at z, by differences of assemblies.

    Args:
        model: with its unknowns.
        z: their values, (p,).
        here: the model there.
        plants: its sampled systems.
        averages: what laws do on the average of each trial; taken as the same a step away.
        free: with respect to which unknowns, (p,).
        listens: whether the predictor corrects itself by the outputs; a simulation does not.
        settled: filters of recordings whose gains are stationary.
    """
    unknowns = model.unknowns
    moved: dict[int, tuple[Assembly, Sequence[Sampled]]] = {}
    for group in _together(unknowns, free):
        near = z.copy()
        near[group] += _step_of(unknowns[group[0]])
        assembly = model.assemble(near)
        own = plants_of(assembly, model) if unknowns[group[0]].role == "system" else plants
        moved |= {index: (assembly, own) for index in group}
    return tuple(
        each(
            lambda i: _of_trial(
                i,
                unknowns,
                here,
                plants,
                moved,
                averages[i],
                free,
                listens,
                settled[i] if settled else None,
            ),
            len(model.trials),
        )
    )


def _step_of(unknown: Unknown) -> float:
    return LEVEL_STEP if unknown.role in ("noise", "error") else STEP


def _together(unknowns: Sequence[Unknown], free: NDArray[np.bool_]) -> list[list[int]]:
    """Return free unknowns that may be moved at once: noise levels of different trials."""
    alone, places = [], dict[int, list[int]]()
    for index in np.flatnonzero(free).tolist():
        unknown = unknowns[index]
        if unknown.role == "noise" and unknown.trial is not None:
            places.setdefault(unknown.trial, []).append(index)
        else:
            alone.append([index])
    longest = max((len(own) for own in places.values()), default=0)
    return alone + [[own[i] for own in places.values() if i < len(own)] for i in range(longest)]


def _of_trial(
    trial: int,
    unknowns: Sequence[Unknown],
    here: Assembly,
    plants: Sequence[Sampled],
    moved: dict[int, tuple[Assembly, Sequence[Sampled]]],
    averages: LawAverages,
    free: NDArray[np.bool_],
    listens: bool,
    settled: Settled | None,
) -> Slopes:
    plant, equivalent = plants[here.which[trial]], averages.equivalent
    own, filtering = predicting(plant), averages.filtering(plant)
    # gains after a gap, a late blow or one at a stop are taken to follow as those without it
    missing = here.trials[trial].begins_without
    kicks = {k: P for k, P in averages.kicks.items() if k < LATEST}
    early = replace(averages, kicks=kicks if averages.acting is None else {})
    own_noise = early.beginning(here.noises[trial])
    if settled is not None:
        base = settled.gain
    elif listens:
        base = gains(filtering, own_noise, equivalent=equivalent, missing=missing)
    else:
        base = silent(plant)
    step, read, gain = own.lifted, read_matrix(own), gain_matrices(base)
    simulation, deviation = simulation_matrix(plant), deviation_matrix(filtering)
    columns = [
        i for i, u in enumerate(unknowns) if free[i] and (u.trial is None or u.trial == trial)
    ]
    order = sorted(range(len(columns)), key=lambda i: ORDER.index(unknowns[columns[i]].role))
    p = len(columns)
    systems = sum(unknowns[i].role == "system" for i in columns)
    laws = systems + sum(unknowns[i].role == "law" for i in columns)
    taken_back, erring = {}, {}
    dstep = _still(step, systems)
    dread = np.zeros((*read.shape, systems))
    dsimulation = np.zeros((*simulation.shape, systems))
    ddeviation = np.zeros((*deviation.shape, systems))
    dread_deviation = np.zeros((*filtering.system.C.shape, systems))
    numbers = numbers_of(here)
    dnumbers = np.zeros((*numbers.shape, laws))
    missed = here.trials[trial].missed
    dmissed = np.zeros((0, 0, 0) if missed is None else (*missed.shape, systems))
    dgain, dS = np.zeros((*gain.shape, p)), np.zeros((*base.innovation.shape, p))
    at_columns, found = np.array(order, np.int64), None
    changed, near, steps = [], [], []
    for at, place in enumerate(order):
        assembly, others = moved[columns[place]]
        other = others[assembly.which[trial]]
        near_filter = filtering if other is plant else averages.filtering(other)
        if at < systems:
            ddeviation[:, :, at] = (deviation_matrix(near_filter) - deviation) / STEP
            dread_deviation[:, :, at] = (near_filter.system.C - filtering.system.C) / STEP
            near_step = predicting(other).lifted
            for name in ("over", "reach", "push"):
                slope = (getattr(near_step, name) - getattr(step, name)) / STEP
                getattr(dstep, name)[..., at] = slope
            dread[:, :, at] = (read_matrix(predicting(other)) - read) / STEP
            dsimulation[:, :, at] = (simulation_matrix(other) - simulation) / STEP
            moved_on = assembly.trials[trial].missed
            if missed is not None and moved_on is not None:
                dmissed[:, :, at] = (moved_on - missed) / STEP
        if at < laws:
            dnumbers[:, :, at] = (numbers_of(assembly) - numbers) / STEP
        if unknowns[columns[place]].role == "samples":
            taken_back[place] = assembly
        elif unknowns[columns[place]].role == "error":
            erring[place] = assembly
        elif listens and (at < systems or at >= laws):
            changed.append(at)
            steps.append(_step_of(unknowns[columns[place]]))
            near.append((near_filter, early.beginning(assembly.noises[trial])))
    if near and settled is not None:
        found = settled_slopes(settled, near, np.array(steps), own_noise, equivalent)
        dgain[-1][..., changed], dS[-1][..., at_columns[changed]] = found.gain, found.innovation
    elif near:
        # the last one is the model itself, so that rounding is alike in both
        near.append((filtering, own_noise))
        gains_near, covariances = neighbouring_gains(near, len(gain) - 1, equivalent, missing)
        dgain[..., changed] = (gains_near[..., :-1] - gains_near[..., -1:]) / steps
        dS[..., at_columns[changed]] = (covariances[..., :-1] - covariances[..., -1:]) / steps
    if not np.any(dmissed):
        dmissed = np.zeros((0, 0, 0))
    return Slopes(dstep, dread, dgain, dnumbers, dsimulation, ddeviation, dread_deviation, dS,
                  dmissed, columns, at_columns, taken_back, erring,
                  found, at_columns[changed])  # fmt: skip


def no_slopes(plant: Sampled, gain: Gains, numbers: Array, p: int = 0) -> Slopes:
    """Return derivatives with respect to nothing but the first state, which p unknowns change."""
    own = predicting(plant)
    (samples, n, m), held = gain.state.shape, gain.held.shape[1]
    return Slopes(
        _still(own.lifted, 0), np.zeros((*read_matrix(own).shape, 0)),
        np.zeros((samples, n + held, m, p)), np.zeros((*numbers.shape, 0)),
        np.zeros((*simulation_matrix(plant).shape, 0)), np.zeros((n, n + held, 0)),
        np.zeros((m, n, 0)),
        np.zeros((*gain.innovation.shape, p)), np.zeros((0, 0, 0)), [], np.arange(p), {}, {},
    )  # fmt: skip


def _still(step: Lifted, count: int) -> Lifted:
    """Return no derivatives with respect to so many unknowns."""
    return Lifted(*(np.zeros((*part.shape, count)) for part in (step.over, step.reach, step.push)))
