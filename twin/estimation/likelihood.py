"""The innovations likelihood of a model with unknowns, its gradient and its Fisher information.

    log p(y | z) = -1/2 sum_k ( e_k^T S_k^-1 e_k + log det 2 pi S_k )

with the innovations e of a one-step predictor that has the laws inside (Ljung 1999, section 7.4).
The state before the first sample is Gaussian with a wide covariance and so integrated out: by gains
that change until they settle, or in closed form beside stationary ones (``first_state``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.estimation.acting import while_acting
from twin.estimation.averages import averages_at
from twin.estimation.density import Part, density
from twin.estimation.first_state import Beginning, Settled, measured, settled
from twin.estimation.kalman import gains
from twin.estimation.law_averages import LawAverages
from twin.estimation.model import Assembly, Model, Trial
from twin.estimation.parallel import each
from twin.estimation.passing import Run, passed, run
from twin.estimation.sensitivities import LEVEL_STEP, Slopes, plants_of, slopes_of
from twin.estimation.system import Sampled

Array = NDArray[np.float64]
Begun = tuple[Settled, Array]
"""A stationary filter, and the first state that a pass begins with, (n,)."""

ROUNDS, ENOUGH = 10, 1e-3
"""Steps at most to the first state of a recording that laws follow, and what one gains [nat] after
which none is worth another: a tenth of what a step of a fit is worth."""


@dataclass(frozen=True)
class Value:
    """Log likelihood, its gradient (p,) and Fisher information (p, p) in prior deviations."""

    log_likelihood: float
    gradient: Array
    information: Array
    runs: tuple[Run, ...]
    trials: tuple[Trial, ...]

    @property
    def averages(self) -> tuple[LawAverages, ...]:
        """What the laws do on the average of each recording."""
        return tuple(run.averages for run in self.runs)


def passes(
    model: Model, z: Array, averages: Sequence[LawAverages] | None = None
) -> tuple[Run, ...]:
    """Return the predictor's pass over every recording at values z, (p,).

    Args:
        model: with its unknowns and recordings.
        z: their values in prior deviations, (p,).
        averages: what the laws do on the average of each recording, where it is known already.

    Raises:
        NoLikelihoodError: no stationary filter, or a model that cannot be.
    """
    here = model.assemble(z)
    plants = plants_of(here, model)
    known = averages or each(lambda i: averages_at(model, here, plants, i), len(here.trials))
    return tuple(each(lambda i: _passed(here, plants, i, known[i]), len(here.trials)))


def _passed(here: Assembly, plants: Sequence[Sampled], index: int, averages: LawAverages,
            slopes: Slopes | None = None, begun: Begun | None = None) -> Run:  # fmt: skip
    """Return the pass over one recording, with derivatives where there are slopes."""
    plant, trial = plants[here.which[index]], here.trials[index]
    if begun is not None:
        settled, state = begun
        return passed(here, index, plant, settled.gain, averages, slopes, (state, settled.first))
    averages = while_acting(averages, plant, here.errors)
    noise = averages.beginning(here.noises[index])
    filtering = averages.filtering(plant)
    gain = gains(filtering, noise, equivalent=averages.equivalent, missing=trial.missing)
    return passed(here, index, plant, gain, averages, slopes)


def _begun(
    here: Assembly, plants: Sequence[Sampled], index: int, averages: LawAverages, derivatives: bool
) -> Begun | None:
    """Return the stationary filter of a recording and a first state.

    With derivatives, and where laws follow the motion, it is the likeliest, found by steps of Gauss
    and Newton. None where gains cannot be stationary: between the first sample and the last
    some are missing, the state is more uncertain at times, or laws begin with an estimated one.

    Raises:
        NoLikelihoodError: no stationary filter, or a model that runs away.
    """
    trial, plant = here.trials[index], plants[here.which[index]]
    between, known = measured(trial.y), averages.start is not None
    if averages.kicks or averages.acting is not None or known or between is None:
        return None
    found = settled(plant, here.noises[index], between, averages.blur, averages.equivalent)
    state, begin = np.zeros(len(plant.A)), trial.until(found.last)
    if averages.blur is not None:
        averages = replace(averages, blur=averages.blur[: found.last])
    for _ in range(ROUNDS if here.laws else int(derivatives)):
        added = state, found.first
        there = run(here, begin, plant, found.gain, averages=averages, added=added)
        likeliest = found.of(gaussian(there, begin), state).state
        step, state = likeliest - state, likeliest
        if float(step @ found.gramian @ step) < 2 * ENOUGH:
            break
    return found, state


def evaluate(
    model: Model,
    z: Array,
    derivatives: bool = True,
    averages: Sequence[LawAverages] | None = None,
    near: Sequence[LawAverages] | None = None,
    free: NDArray[np.bool_] | None = None,
    filtered: bool = False,
) -> Value:
    """Return the log likelihood at values z, (p,), and its derivatives unless they are not asked.

    Other arguments and errors are those of ``passes``; ``free`` says with respect to which
    unknowns, (p,), all without, and others get 0; ``near`` are averages of values nearby;
    ``filtered`` asks for passes of filters that know nothing of the first state, as ``passes`` are.
    """
    here = model.assemble(z)
    plants = plants_of(here, model)
    known = averages or each(
        lambda i: averages_at(model, here, plants, i, near[i] if near else None, not derivatives),
        len(here.trials),
    )
    moving = np.ones(len(model.unknowns), bool) if free is None else free
    sloped = derivatives and bool(np.any(moving))
    begun: Sequence[Begun | None] = [None] * len(here.trials)
    if not filtered:
        begun = each(lambda i: _begun(here, plants, i, known[i], sloped), len(here.trials))
    slopes = None
    if sloped:
        stationary = [pair and pair[0] for pair in begun]
        slopes = slopes_of(model, z, here, plants, known, moving, settled=stationary)
    p = len(model.unknowns)
    log_likelihood, gradient, information = 0.0, np.zeros(p), np.zeros((p, p))

    def one(index: int) -> tuple[Run, dict[int, Array]]:
        own = slopes[index] if slopes else None
        found = _passed(here, plants, index, known[index], own, begun[index])
        return found, {} if own is None else _by_errors(here, plants, index, found, own)

    passed = each(one, len(here.trials))
    for index, (result, by_errors) in enumerate(passed):
        trial, pair = here.trials[index], begun[index]
        part = gaussian(result, trial)
        told = pair and pair[0].of(part, pair[1])
        log_likelihood += told.log_likelihood if told else part.value + result.averages.start_odds
        if slopes is None:
            continue
        dS, columns = slopes[index].until(len(part.balance)), slopes[index].columns
        white = part.whitened(result.de)
        if pair is not None and told:
            _add_first_state(pair[0], told, slopes[index], white, gradient, information)
        gradient[columns] -= white.T @ part.white.ravel()
        settled = len(dS) - 1
        balance = np.concatenate([part.balance[:settled], part.balance[settled:].sum(0)[None]])
        gradient[columns] -= 0.5 * np.einsum("tij,tijp->p", balance, dS)
        information[np.ix_(columns, columns)] += white.T @ white
        S = result.gains.innovation[[*range(settled), -1]]
        half = np.einsum("tij,tjkp->tikp", np.linalg.inv(S), dS)
        flat = half.reshape(-1, len(columns))
        counts = np.ones(len(S))
        counts[-1] = len(trial.y) - len(S) + 1
        turned = (counts[:, None, None, None] * half).swapaxes(1, 2).reshape(-1, len(columns))
        information[np.ix_(columns, columns)] += 0.5 * flat.T @ turned
        for place, slope in by_errors.items():
            column = columns[place]
            # what a share of a force is off by goes with no other level
            turned = np.einsum("kij,kjl,kml->kim", part.roots, slope, part.roots)
            shown = np.einsum("ki,kij,kj->", part.white, turned, part.white)
            gradient[column] += 0.5 * (shown - np.einsum("kii->", turned))
            information[column, column] += 0.5 * np.sum(turned**2)
    runs = tuple(run for run, _ in passed)
    return Value(log_likelihood, gradient, information, runs, here.trials)


def _add_first_state(
    found: Settled, told: Beginning, slopes: Slopes, white: Array, gradient: Array,
    information: Array,
) -> None:  # fmt: skip
    """Add what a first state that is integrated out does to gradient and information.

    Args:
        found: the stationary filter.
        told: what the recording tells of the state.
        slopes: of the pass.
        white: whitened derivatives of the innovations, (rows, p).
        gradient: of all unknowns; added to.
        information: of all unknowns; added to.
    """
    columns = np.array(slopes.columns, int)
    across = found.slopes.T @ white[found.rows]
    information[np.ix_(columns, columns)] -= across.T @ found.posterior @ across
    if slopes.settled is not None:
        more = np.einsum("i,j,ijk->k", told.pull, told.pull, slopes.settled.spread)
        gradient[columns[slopes.settled_columns]] += slopes.settled.odds + 0.5 * more


def _by_errors(
    here: Assembly, plants: Sequence[Sampled], index: int, found: Run, slopes: Slopes
) -> dict[int, Array]:
    """Return slopes of the innovations' covariances by how far laws are off, (samples, m, m).

    By place in the columns of the slopes, where those of the innovations are filled in.
    """
    out = {}
    for place, other in slopes.erring.items():
        if found.averages.acting is None:
            continue
        moved = _passed(other, plants, index, found.averages)
        found.de[:, :, place] = (moved.e - found.e) / LEVEL_STEP
        out[place] = (moved.covariances - found.covariances) / LEVEL_STEP
    return out


def gaussian(result: Run, trial: Trial) -> Part:
    """Return the log density of one recording's innovations and what its derivatives need.

    Args:
        result: the predictor's pass.
        trial: the recording; what is missing in it does not count.

    Raises:
        NoLikelihoodError: a covariance that is not positive.
    """
    return density(result.e, trial.y, result.gains.innovation, result.averages.blur)
