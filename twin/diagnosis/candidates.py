"""What may be added to a hypothesis: every mechanism at every place, with priors and first guesses.

A first guess says where a fit starts; the prior says what is plausible. Both come from the scales
of the motion at the place, never from what another recording showed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import Motion, motion_of
from twin.diagnosis.plant import axis_of
from twin.diagnosis.problem import Problem
from twin.diagnosis.scales import Scales
from twin.estimation.law_averages import LawAverages
from twin.estimation.likelihood import passes
from twin.mechanisms.mechanism import Mechanism, Surroundings

Array = NDArray[np.float64]

LEAST_SPREAD = 1.5
"""Prior deviation of a positive parameter's logarithm at least: a factor of four and a half either
way. First guesses that span more make it wider."""

NEARBY = 1e-3
"""Share of itself by which a strength is changed, to see how its parameter goes with it."""


@dataclass(frozen=True)
class Candidate:
    """One mechanism at one place.

    Attributes:
        starts: the mechanism with each of its first guesses.
        priors: parameter -> (mean, deviation), of the logarithm where its scale is "log", of the
            share where it is known as one.
    """

    starts: tuple[Mechanism, ...]
    priors: dict[str, tuple[float, float]]

    @property
    def label(self) -> tuple[str, str]:
        """Name and place."""
        return self.starts[0].name, self.starts[0].place

    def width(self, found: Mechanism, gain: float) -> float:
        """Return by how much the log evidence rises less than the log likelihood does [nat].

        That is log(prior deviation / posterior deviation) of a strength, for a posterior that is
        Gaussian in it (MacKay 2003, eq. 28.6): a rise g says that the strength is known to
        1 / sqrt(2 g) of itself. Other parameters are left out, for the samples may not tell them.

        Args:
            found: the mechanism at the strength that was found.
            gain: the rise of the log likelihood with it.
        """
        name = next(iter(found.parameters), None)
        if name is None or not gain > 0:
            return 0.0
        log = found.parameters[name].scale == "log"
        ends = [found.values[name], found.scaled(1 + NEARBY).values[name]]
        told = np.log(np.abs(ends)) if log else np.array(ends)
        step = abs(float(told[1] - told[0])) / NEARBY  # what the unknown moves as it doubles
        prior = self.priors[name][1]
        return 0.5 * float(np.log1p(2 * gain * (prior / step) ** 2)) if step > 0 else 0.0


def priors_of(starts: Sequence[Mechanism]) -> dict[str, tuple[float, float]]:
    """Return the priors that first guesses span, unless the mechanism states its own."""
    first = starts[0]
    own = first.priors()
    out = {}
    for name, parameter in first.parameters.items():
        if name in first.shares:
            out[name] = first.shares[name][1:]
            continue
        values = np.array([s.values[name] for s in starts], float)
        if parameter.scale == "log":
            logs = np.log(np.maximum(np.abs(values), 1e-300))
            spread = max(float(np.std(logs)), LEAST_SPREAD)
            out[name] = own.get(name, (float(np.mean(logs)), spread))
        else:
            spread = float(np.sqrt(np.mean(values**2)))
            centre = 0.0 if np.min(values) < 0 or spread == 0 else float(np.mean(values))
            out[name] = own.get(name, (centre, max(spread, 1e-300)))
    return out


def motions(
    problem: Problem, hypothesis: Hypothesis, z: Array,
    averages: Sequence[LawAverages] | None = None,
) -> tuple[Motion, ...]:  # fmt: skip
    """Return the motion of every recording as the predictor estimates it.

    Args:
        problem: whose recordings they are.
        hypothesis: the model.
        z: its values, (p,).
        averages: of its laws, as the fit ended with them; found anew without.
    """
    n = len(problem.model.coordinates)
    return tuple(motion_of(run, n, problem.step_s) for run in passes(hypothesis, z, averages))


def scales_of(problem: Problem, moved: Sequence[Motion]) -> Scales:
    """Return the scales of the motion at every port."""
    q = np.vstack([m.q for m in moved])
    v = np.vstack([m.v for m in moved])
    compliance = np.linalg.pinv(problem.model.K)
    out = {}
    for name, port in problem.model.ports.items():
        drift, rate = (float(np.sqrt(np.mean((x @ port.row) ** 2))) for x in (q, v))
        seen = float(port.row @ compliance @ port.row)
        mass = 1 / max(float(port.row @ np.linalg.solve(problem.model.M, port.row)), 1e-300)
        force = drift / seen if seen > 0 else 0.0
        inertia = mass * float(np.sqrt(np.mean((np.vstack([m.a for m in moved]) @ port.row) ** 2)))
        out[name] = (max(force, inertia), drift, rate)
    return Scales(out)


def surroundings(
    problem: Problem, moved: Sequence[Motion], place: str, height: float = 1.0,
    peaks: tuple[float, ...] = (),
) -> Surroundings:  # fmt: skip
    """Return the scales at a place from which a mechanism makes its first guesses."""
    model = problem.model
    reading = np.zeros(1)
    if place in model.outputs:
        column = model.outputs.index(place)
        reading = np.concatenate([r.y[:, column] for r in problem.recordings])
    elif place in model.inputs:
        column = model.inputs.index(place)
        reading = np.concatenate([r.u[:, column] for r in problem.recordings])
    port = model.ports.get(place)
    row = port.row if port is not None else np.zeros(len(model.coordinates))
    if place in model.bodies and port is None:
        rows = model.bodies[place].translation
        row = rows[int(np.argmax(np.linalg.norm(rows, axis=1)))]
    base = model.base[axis_of(model, place)] if place in model.places("base") else None
    if base is not None:
        row = base.row / max(base.mass, 1e-300)
    reading = reading[np.isfinite(reading)]
    drift = np.concatenate([m.q @ row for m in moved])
    rate = np.concatenate([m.v @ row for m in moved])
    seen = float(row @ np.linalg.pinv(model.K) @ row)
    stiffness = 1 / seen if seen > 0 else 0.0
    mass = 1 / max(float(row @ np.linalg.solve(model.M, row)), 1e-300)
    if place in model.bodies:
        mass = model.bodies[place].mass
    inside = problem.frequencies[problem.frequencies > 0]
    w = 2 * np.pi * (inside[0] if len(inside) else 1.0)
    total = (
        next(iter(model.base.values())).mass
        if model.base
        else sum(b.mass for b in model.bodies.values())
    )
    if base is not None:
        mass = max(base.fixed_mass, 0.02 * total)
        stiffness = w**2 * total
    if not stiffness > 0:
        stiffness = w**2 * mass
    return Surroundings(
        stiffness=stiffness, damping=2 * 0.01 * stiffness / w, mass=mass, mass_above=total,
        height=port.height if port is not None else height, drift=drift, rate=rate, reading=reading,
        natural_frequencies=tuple(float(f) for f in inside), 
        duration_s=max(len(r.y) for r in problem.recordings) * problem.step_s,
        sampling_hz=problem.sampling_hz, peaks=peaks,
    )  # fmt: skip
