"""What every rig has: masses, storey stiffnesses and dampings a little off those of its model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import place_vector
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.mechanism import Mechanism, Surroundings
from twin.mechanisms.stiffness import Stiffness
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]

TOLERANCE = 0.004
"""Standard deviation of a rig's masses and stiffnesses about its model's: how well parts are made
and weighed. A change well beyond it is a finding."""

BENT = 5.0
"""Tolerances from which a parameter is off by more than chance would have it."""

DAMPING_TOLERANCE = 0.1
"""The same for its dampings, which are never known that well."""


def storeys_of(model: SecondOrderModel) -> list[str]:
    """Return the names of the storeys."""
    return [f"storey{c.removeprefix('floor')}" for c in model.coordinates if c.startswith("floor")]


def storey_values(model: SecondOrderModel, matrix: Array) -> dict[str, float]:
    """Return the chain of springs (or dashpots) that comes nearest to a matrix, by storey."""
    names = storeys_of(model)
    columns = [np.outer(b, b).ravel() for b in (place_vector(model, s) for s in names)]
    if "ground" in model.coordinates:
        b = place_vector(model, "ground")
        columns.append(np.outer(b, b).ravel())
    values = np.linalg.lstsq(np.column_stack(columns), matrix.ravel(), rcond=None)[0]
    typical = float(np.mean(np.abs(values)))
    return {s: max(float(v), 0.05 * typical) for s, v in zip(names, values, strict=False)}


def base_hypothesis(
    model: SecondOrderModel,
    tolerance: float = TOLERANCE,
    damping_tolerance: float = DAMPING_TOLERANCE,
) -> Hypothesis:
    """Return the hypothesis that nothing is missing: only tolerances about the model."""
    stiffness, damping = storey_values(model, model.K), storey_values(model, model.R)
    base: list[Mechanism] = []
    spread = []
    # dashpots of storeys and of floors: modal damping is not a chain of storey dashpots
    for place, value in stiffness.items():
        base.append(Stiffness(place, 0.0))
        spread.append(tolerance * value)
    for place, value in damping.items():
        base.append(Damping(place, 0.0))
        spread.append(damping_tolerance * value)
    for index, place in enumerate(model.coordinates):
        if place.startswith("floor"):
            base.append(Mass(place, 0.0))
            spread.append(tolerance * float(model.M[index, index]))
            base.append(Damping(place, 0.0))
            spread.append(damping_tolerance * float(np.mean(list(damping.values()))))
    return Hypothesis(tuple(base), tuple(spread))


def surroundings(
    bench: Bench,
    motion: Mapping[str, Array],
    heights: Mapping[str, float],
    place: str,
    peaks: tuple[float, ...] = (),
) -> Surroundings:
    """Return what is known at a place.

    Args:
        bench: model and trials.
        motion: "storey1", "rate storey1", ... -> pooled estimated motion, (samples,).
        heights: of the storeys [m].
        place: a storey, a floor, the ground, the pendulum, or one or two channels.
        peaks: frequencies at which what is unexplained stands out [Hz].
    """
    model = bench.model
    stiffness, damping = storey_values(model, model.K), storey_values(model, model.R)
    M = np.diag(model.M)
    floors = [i for i, c in enumerate(model.coordinates) if c.startswith("floor")]
    digits = "".join(c for c in place.split("+")[0].split("_")[-1] if c.isdigit())
    number = min(int(digits or 1), len(floors))
    mass = float(M[floors[number - 1]])
    if place == "ground":
        known = bench.ground_mass > 0
        mass = bench.ground_mass if known else float(M[floors].sum())
    key = f"storey{number}"
    channel = "torque_pendulum" if place == "pendulum" else place.split("+")[0]
    readings = [t.columns[channel] for t in bench.trials if channel in t.columns]
    where = place if place in motion else key
    frequencies = np.sqrt(np.maximum(np.linalg.eigvals(np.linalg.solve(model.M, model.K)).real, 0))
    return Surroundings(
        stiffness=stiffness[key],
        damping=damping[key],
        mass=mass,
        mass_above=float(M[floors[number - 1 :]].sum()),
        height=heights.get(key, 1.0),
        drift=motion[where],
        rate=motion[f"rate {where}"],
        reading=np.concatenate(readings) if readings else np.zeros(1),
        natural_frequencies=tuple(sorted(float(f) / (2 * np.pi) for f in frequencies)),
        duration_s=max(t.samples / t.sampling_hz for t in bench.trials),
        sampling_hz=bench.trials[0].sampling_hz,
        peaks=peaks,
    )


def bent(hypothesis: Hypothesis) -> list[int]:
    """Return which parameters are off by far more than their tolerance, worst first."""
    off = [
        (abs(m.values["change"]) / tolerance, index)
        for index, (m, tolerance) in enumerate(
            zip(hypothesis.base, hypothesis.tolerance, strict=True)
        )
    ]
    return [index for share, index in sorted(off, reverse=True) if share > BENT]


def level(hypothesis: Hypothesis) -> Hypothesis:
    """Return the hypothesis with its base as the model has it."""
    return replace(hypothesis, base=tuple(m.with_values({"change": 0.0}) for m in hypothesis.base))
