"""The innovations likelihood of a model with unknowns, its gradient and its Fisher information.

    log p(y | z) = -1/2 sum_k ( e_k^T S_k^-1 e_k + log det 2 pi S_k )

with the innovations e of a one-step predictor that has the laws inside (Ljung 1999, section 7.4).
The state before the first sample is Gaussian with a wide covariance and so integrated out.

Where a law jumps an output is more uncertain than its noise, by variances B that the forces
themselves tell (``Model.blur``): S there is S + B, and the predictor believes it less, by
S (S + B)^-1. The forces are those of a pass without B.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.estimation.density import Part, density
from twin.estimation.kalman import EquivalentLinear, Gains, gains
from twin.estimation.laws import addresses
from twin.estimation.model import Assembly, Model, Trial
from twin.estimation.parallel import each
from twin.estimation.sensitivities import (
    STEP,
    Slopes,
    gain_matrices,
    no_slopes,
    numbers_of,
    plants_of,
    read_matrix,
    slopes_of,
    step_matrix,
)
from twin.estimation.stepping import predict
from twin.estimation.system import Sampled, transition

Array = NDArray[np.float64]

SHARP = 1e-3
"""Share of an output's innovation variance below which another variance changes nothing: 0.05 % of
its weight."""


@dataclass(frozen=True)
class LawAverages:
    """What laws do on the average of one recording's motion; of a linear model nothing.

    Attributes:
        equivalent: what they add to the linear system, for the gains.
        blur: variances of the outputs beside their noise's, (samples, m).
    """

    equivalent: EquivalentLinear | None = None
    blur: Array | None = None


@dataclass(frozen=True)
class Run:
    """The predictor's pass over one recording.

    Attributes:
        e: innovations, (samples, m); zero where nothing was measured.
        de: their derivatives, (samples, m, p); p = 0 without.
        x: states before each sample, (samples, n).
        z: memories of the laws, (samples, l).
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


@dataclass(frozen=True)
class Value:
    """Log likelihood, its gradient (p,) and Fisher information (p, p) in prior deviations."""

    log_likelihood: float
    gradient: Array
    information: Array
    runs: tuple[Run, ...]
    trials: tuple[Trial, ...]


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
) -> Run:
    """Step the predictor over one recording.

    Args:
        assembly: for laws and numbers.
        trial: the recording.
        plant: its sampled system.
        gain: gains of the predictor.
        slopes: derivatives with respect to p unknowns; without, only the first state changes.
        x0: state before the first sample, (n,), or rest.
        z0: memories of the laws before it, (l,), or zero.
        begin_s: time of the first sample [s].
        dx0: derivatives of the first state, (n, p).
        averages: what the laws do on the average of the motion; they blur nothing without.
    """
    laws, numbers, system = len(assembly.laws), numbers_of(assembly), plant.system
    averages = averages or LawAverages()
    n, (samples, m) = len(plant.A), trial.y.shape
    d = slopes or no_slopes(plant, gain, numbers, 0 if dx0 is None else dx0.shape[1])
    p = len(d.order)
    e, de = np.empty((samples, m)), np.empty((samples, m, p))
    x, z, f = np.empty((samples, n)), np.empty((samples, laws)), np.empty((samples, laws))
    c = np.ascontiguousarray
    predict(
        addresses(assembly.laws), step_matrix(plant), read_matrix(plant),
        np.vstack([system.drift, system.rate]), numbers,
        gain_matrices(gain), _trust(gain, averages.blur), c(trial.u), c(trial.between), c(trial.y),
        np.zeros(n) if x0 is None else c(x0, dtype=float),
        np.zeros(laws) if z0 is None else c(z0, dtype=float),
        begin_s, plant.steps, trial.step_s, (~assembly.held).astype(float), c(assembly.scales),
        d.step, d.read, d.gain, d.numbers,
        np.zeros((n, p)) if dx0 is None else c(dx0[:, d.order]), d.order, e, de, x, z, f,
    )  # fmt: skip
    return Run(e, de, x, z, f, gain, plant, averages)


def _trust(gain: Gains, blur: Array | None) -> Array:
    """Return S (S + B)^-1 of every sample, (samples, m, m); none where nothing is blurred."""
    if blur is None:
        return np.zeros((0, 0, 0))
    S = gain.innovation[np.minimum(np.arange(len(blur)), len(gain.innovation) - 1)]
    m = S.shape[1]
    trust = np.broadcast_to(np.eye(m), S.shape).copy()
    hit = np.flatnonzero(np.any(blur > SHARP * np.diagonal(S, axis1=1, axis2=2), axis=1))
    wide = S[hit].copy()
    wide[:, range(m), range(m)] += blur[hit]
    trust[hit] = np.linalg.solve(wide, S[hit]).swapaxes(1, 2)
    return trust


def averages_at(model: Model, here: Assembly, plants: Sequence[Sampled], index: int) -> LawAverages:
    """Return what the laws do on the average of a recording, by a pass that knows nothing of it.

    Their forces are replaced by k d + c v with the least mean square error.
    """
    if not here.laws:
        return LawAverages()
    plant, trial = plants[here.which[index]], here.trials[index]
    passed = run(here, trial, plant, gains(plant, here.noises[index], missing=trial.missing))
    system = plant.system
    blur = model.blur(passed.f, system) if model.blurred else None
    rows = []
    for j, row in enumerate(system.drift):
        motion = np.column_stack([passed.x @ row, passed.x @ system.rate[j]])
        size = np.maximum(np.sqrt(np.mean(motion**2, axis=0)), 1e-300)
        k, c = np.linalg.lstsq(motion / size, passed.f[:, j], rcond=None)[0] / size
        rows.append(k * row + c * system.rate[j])
    tangent = np.array(rows)
    if not np.all(np.isfinite(tangent)):
        return LawAverages(None, blur)
    with np.errstate(all="ignore"):  # laws that run away here: another step will not go there
        bent = system.A + system.E @ tangent
        whole = transition(bent, np.zeros((len(bent), 0)), plant.steps * plant.step_s, 0)[0]
    equivalent = EquivalentLinear(whole - plant.whole, system.F @ tangent)
    finite = np.all(np.isfinite(equivalent.whole)) and np.all(np.isfinite(equivalent.C))
    return LawAverages(equivalent if finite else None, blur)


def open_loop(gain: Gains) -> Gains:
    """Return gains that listen to nothing: the predictor is then a simulation."""
    return Gains(0 * gain.state[-1:], 0 * gain.held[-1:], gain.innovation, gain.predicted)


def passes(
    model: Model, z: Array, averages: Sequence[LawAverages] | None = None
) -> tuple[Run, ...]:
    """Return the predictor's pass over every recording at values z, (p,).

    Args:
        model: with its unknowns and recordings.
        z: their values in prior deviations, (p,).
        averages: what the laws do on the average of each recording, where it is known already.

    Raises:
        ValueError: no stationary filter, or a model that cannot be.
    """
    here = model.assemble(z)
    plants = plants_of(here, model)
    known = averages or each(lambda i: averages_at(model, here, plants, i), len(here.trials))
    return tuple(each(lambda i: _passed(here, plants, i, known[i]), len(here.trials)))


def _passed(here: Assembly, plants: Sequence[Sampled], index: int, averages: LawAverages,
            slopes: Slopes | None = None) -> Run:  # fmt: skip
    """Return the pass over one recording, with derivatives where there are slopes."""
    plant, trial = plants[here.which[index]], here.trials[index]
    noise = here.noises[index]
    gain = gains(plant, noise, equivalent=averages.equivalent, missing=trial.missing)
    result = run(here, trial, plant, gain, slopes, averages=averages)
    for place, assembly in slopes.taken_back.items() if slopes else ():
        moved = run(here, assembly.trials[index], plant, gain, averages=averages)
        result.de[:, :, place] = (moved.e - result.e) / STEP
    return result


def evaluate(
    model: Model,
    z: Array,
    derivatives: bool = True,
    averages: Sequence[LawAverages] | None = None,
) -> Value:
    """Return the log likelihood at values z, (p,), and its derivatives unless they are not asked.

    Arguments and errors are those of ``passes``.
    """
    here = model.assemble(z)
    plants = plants_of(here, model)
    known = averages or each(lambda i: averages_at(model, here, plants, i), len(here.trials))
    slopes = None
    if derivatives:
        slopes = slopes_of(model, z, here, plants, [a.equivalent for a in known])
    p = len(model.unknowns)
    log_likelihood, gradient, information = 0.0, np.zeros(p), np.zeros((p, p))
    runs: list[Run] = each(
        lambda i: _passed(here, plants, i, known[i], slopes[i] if slopes else None),
        len(here.trials),
    )
    for index, result in enumerate(runs):
        trial = here.trials[index]
        part = gaussian(result, trial)
        log_likelihood += part.value
        if slopes is None:
            continue
        dS, columns = slopes[index].innovation, slopes[index].columns
        white = part.whitened(result.de)
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
    return Value(log_likelihood, gradient, information, tuple(runs), here.trials)


def gaussian(result: Run, trial: Trial) -> Part:
    """Return the log density of one recording's innovations and what its derivatives need.

    Args:
        result: the predictor's pass.
        trial: the recording; what is missing in it does not count.

    Raises:
        ValueError: a covariance that is not positive.
    """
    return density(result.e, trial.y, result.gains.innovation, result.averages.blur)
