"""Tuning: the front of reduction against torque and swing, and the controller to take."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from twin.control.absorber import DesignModel
from twin.control.closed_loop import run
from twin.control.controller import Controller
from twin.control.loop import spectral_radius, stability_margin, steady_vibration
from twin.control.perturbation import Perturbation
from twin.control.plant import Plant, frame_frequencies
from twin.control.study import Settings, worst_case
from twin.control.uncertainty import Uncertainty
from twin.control.weights import Covariances, Weights
from twin.errors import ControlError

Array = NDArray[np.float64]

SPACE: dict[str, tuple[float, float]] = {
    "velocity": (1e-2, 1e1),
    "angle": (1e-6, 1e-2),
    "torque": (1e-4, 1e-1),
    "disturbance": (3e-3, 0.3),
    "angle_noise": (1e-4, 1e-2),
}
"""What is searched, on a logarithmic scale; displacements have the weight one."""

EXTRA_DELAY = (0.25, 1.0)
RAMP_S = (6.0, 14.0)


@dataclass(frozen=True)
class Limits:
    """What the rig stands.

    Attributes:
        swing_rad: largest angle of the pendulum [rad].
        torque_nm: largest torque [N m].
    """

    swing_rad: float = 0.8
    torque_nm: float = 0.5

    def __post_init__(self) -> None:
        for name in ("swing_rad", "torque_nm"):
            if not getattr(self, name) > 0:
                raise ControlError(f"the limit {name} must be positive, not {getattr(self, name)}")


@dataclass(frozen=True)
class Trial:
    """One controller to be tried.

    Attributes:
        settings: of the controller.
        model: the identified one, which it is designed on.
        plant: to simulate, as it is and once perturbed and late by one more sample.
        uncertainty: of the identified model.
        draws: of it, each with and without one more sample of delay.
        seed: of draws, noise and excitation.
    """

    settings: Settings
    model: DesignModel
    plant: Plant
    uncertainty: Uncertainty
    draws: int = 40
    seed: int = 0


def candidates(count: int, seed: int, base: Settings) -> tuple[Settings, ...]:
    """Return ``base`` and settings spread evenly over ``SPACE``; the same seed, the same ones."""
    names = [*SPACE]
    low = np.array([np.log10(SPACE[name][0]) for name in names] + [EXTRA_DELAY[0], RAMP_S[0]])
    high = np.array([np.log10(SPACE[name][1]) for name in names] + [EXTRA_DELAY[1], RAMP_S[1]])
    power = int(np.ceil(np.log2(max(count - 1, 1))))
    points = qmc.scale(qmc.Sobol(len(low), seed=seed).random_base2(power), low, high)
    found = [base]
    for *logs, delay, ramp in points[: count - 1].tolist():
        value = {name: 10.0**x for name, x in zip(names, logs, strict=True)}
        weights = Weights(1.0, value["velocity"], value["angle"], 0.0, value["torque"])
        covariances = replace(
            Covariances(), disturbance=value["disturbance"], angle=value["angle_noise"]
        )
        found.append(
            replace(base, weights=weights, covariances=covariances, extra_delay=delay, ramp_s=ramp)
        )
    return tuple(found)


def trials(
    settings: Sequence[Settings],
    model: DesignModel,
    plant: Plant,
    uncertainty: Uncertainty,
    seed: int,
) -> dict[str, Trial]:
    """Return the trials of a campaign by name."""
    return {
        f"{number:04d}": Trial(one, model, plant, uncertainty, seed=seed)
        for number, one in enumerate(settings)
    }


def identity(tasks: Mapping[str, Trial]) -> str:
    """Return a fingerprint of everything that decides the results."""
    text = "".join(f"{name}{task!r}" for name, task in tasks.items())
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def robustness(controller: Controller, trial: Trial) -> tuple[float, Array]:
    """Return the share of stable draws and their steady reduction in the worst case.

    The reduction is that of the less calmed floor, by linear theory, (2 draws,); -1 where unstable.
    """
    rng = np.random.default_rng(np.random.SeedSequence([trial.seed, 7]))
    shares = []
    for _ in range(trial.draws):
        truth = trial.uncertainty.drawn(trial.model, rng)
        for delay in (trial.plant.delay, trial.plant.delay + 1):
            shares.append(worst_reduction(controller, truth, delay))
    return float(np.mean(np.array(shares) > -1)), np.array(shares)


def worst_reduction(controller: Controller, truth: DesignModel, delay: int) -> float:
    """Return the steady reduction of the less calmed floor at the truth's own frequencies."""
    if spectral_radius(controller, truth, delay) >= 1:
        return -1.0
    frequency = np.array(frame_frequencies(truth.structure))
    free = steady_vibration(None, truth, frequency)
    held = steady_vibration(controller, truth, frequency, delay)
    peaks = [np.abs(v.displacement).sum(axis=0) for v in (held, free)]
    return float(np.min(1 - peaks[0] / peaks[1]))


def evaluate(trial: Trial) -> dict[str, Any]:
    """Design one controller, try it on the draws and, if all are stable, in MuJoCo.

    Returns:
        Plain types: stable (share of the draws), reduction_p5 (5th percentile over the draws),
        margin; and from the simulations reduction (the less calmed floor's, steady), swing_rad and
        torque_nm as the plant is, worst_* over both simulations.
    """
    plant = trial.plant
    try:
        controller = trial.settings.design(trial.model, plant.delay)
    except ControlError as error:
        return {"stable": 0.0, "error": str(error)}
    stable, shares = robustness(controller, trial)
    result: dict[str, Any] = {
        "stable": stable,
        "reduction_p5": float(np.percentile(shares, 5)),
        "margin": stability_margin(controller, trial.model, plant.delay),
    }
    if stable < 1:
        return result
    rng = np.random.default_rng(np.random.SeedSequence([trial.seed, 8]))
    drawn = Perturbation.drawn(len(plant.twin.floors), trial.uncertainty.spread, rng)
    simulated = []
    for truth in (plant, plant.perturbed(drawn, 1)):
        outcome = run(truth, controller, worst_case(truth), seed=trial.seed)
        steady = min(outcome.reduction.steady.values())
        simulated.append((steady, outcome.peak_swing_rad, outcome.peak_torque_nm))
    worst = np.array(simulated)
    names = ("reduction", "swing_rad", "torque_nm")
    result.update(zip(names, simulated[0], strict=True))
    extremes = (worst[:, 0].min(), worst[:, 1].max(), worst[:, 2].max())
    result.update({f"worst_{n}": float(x) for n, x in zip(names, extremes, strict=True)})
    return result


def front(results: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """Return the trials that no other beats in reduction, swing and torque at once, best first."""
    tried = {name: r for name, r in results.items() if "reduction" in r}
    points = {
        name: np.array([-r["worst_reduction"], r["worst_swing_rad"], r["worst_torque_nm"]])
        for name, r in tried.items()
    }
    kept = [
        name
        for name, point in points.items()
        if not any(np.all(o <= point) and np.any(o < point) for o in points.values())
    ]
    return tuple(sorted(kept, key=lambda name: points[name][0]))


def pick(results: Mapping[str, Mapping[str, Any]], limits: Limits) -> str:
    """Return the trial with the largest reduction that can be relied on, within the limits.

    That is the smaller of the worst simulated one and the 5th percentile over the draws.

    Raises:
        ControlError: none is within the limits; says by how much the nearest misses them.
    """
    tried = {name: r for name, r in results.items() if "reduction" in r}
    if not tried:
        share = max((float(r["stable"]) for r in results.values()), default=0.0)
        raise ControlError(
            f"none of {len(results)} controllers is stable for all draws of the identified model; "
            f"the best is for {share:.0%}"
        )
    given = {"worst_swing_rad": limits.swing_rad, "worst_torque_nm": limits.torque_nm}
    within = [n for n, r in tried.items() if all(r[key] <= top for key, top in given.items())]
    if within:
        return max(within, key=lambda n: min(tried[n]["worst_reduction"], tried[n]["reduction_p5"]))
    nearest = min(tried, key=lambda n: max(tried[n][key] / top for key, top in given.items()))
    label = {"worst_swing_rad": ("swings", "rad"), "worst_torque_nm": ("needs", "N m")}
    missed = [
        f"{label[key][0]} {tried[nearest][key]:.3g} {label[key][1]}, "
        f"{tried[nearest][key] - top:.3g} more than {top:g}"
        for key, top in given.items()
        if tried[nearest][key] > top
    ]
    raise ControlError(
        f"none of {len(tried)} stable controllers meets the limits: the nearest "
        f"{' and '.join(missed)}"
    )
