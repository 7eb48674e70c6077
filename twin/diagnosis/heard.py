"""A narrow unmeasured force that was found somewhere, tried at every place and with edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.places import places
from twin.diagnosis.plant import build
from twin.diagnosis.predict import unmeasured
from twin.diagnosis.refining import refined
from twin.diagnosis.trials import SHAKE_TABLE
from twin.mechanisms.mechanism import Disturbance
from twin.mechanisms.unmeasured_force import UnmeasuredForce

SAMPLES = 4096
"""Of a piece of the spectrum in which a band's edges are looked for."""

LINES = 3
"""Lines of that spectrum within which a force is a sinusoid, without edges to speak of."""

BROAD_HZ = 0.5
"""Bandwidth from which on a force takes up whatever there is, wherever it acts."""

ALIKE = 1e-4
"""Departure from proportion that no recording shows."""

TAIL = 0.02
"""Share of the power that lies below, and above, the edges of a band."""


def elsewhere(bench: Bench, found: Fit) -> list[Fit]:
    """Return fits with the same unmeasured force elsewhere, and with a band of steep edges.

    Its band is its own: a place at which it was not found has not been heard. And where
    the band's shape is wrong, the place that suits that shape best wins.
    """
    own = found.hypothesis.found[-1]
    if not isinstance(own, UnmeasuredForce) or own.bandwidth > BROAD_HZ:
        return []
    floors = [c for c in bench.model.coordinates if c.startswith("floor")]
    mass = float(sum(bench.model.M[i, i] for i in map(bench.model.coordinates.index, floors)))
    base = replace(found.hypothesis, found=found.hypothesis.found[:-1])
    out = []
    for force in (own, *_edged(bench, found)):
        for place in places(type(own), bench.model, ()):
            if (place, force.edged) == (own.place, own.edged):
                continue
            # newtons at a floor, metres a second squared at the ground
            factor = mass ** float((own.place == "ground") - (place == "ground"))
            moved = replace(force, place=place, rms=factor * force.rms)
            try:
                out.append(refined(bench, [base.including(moved)], found.slack, found.starts))
            except np.linalg.LinAlgError:
                continue
    return out


def best_of_each(fits: list[Fit]) -> list[Fit]:
    """Return the best fit of each mechanism and place, the best first."""
    best: dict[tuple[str, str], Fit] = {}
    for fit in sorted(fits, key=lambda f: f.bic):
        best.setdefault(fit.hypothesis.labels[-1], fit)
    return list(best.values())


def _edged(bench: Bench, found: Fit) -> list[UnmeasuredForce]:
    """Return the force with the band in which it was heard, if it has one."""
    own = found.hypothesis.found[-1]
    assert isinstance(own, UnmeasuredForce)
    if own.edged:
        return []
    index = len(found.hypothesis.found) - 1
    heard = unmeasured(bench, found.hypothesis, found.slack, found.starts)[index]
    pieces = min(SAMPLES, *(len(x) for x in heard))
    rate = 1 / bench.step_s
    power = sum(signal.welch(x, rate, nperseg=pieces)[1] for x in heard)
    frequency = np.fft.rfftfreq(pieces, bench.step_s)
    share = np.cumsum(power) / np.sum(power)
    low, high = np.interp([TAIL, 1 - TAIL], share, frequency)
    rms = float(np.sqrt(np.mean(np.concatenate(heard) ** 2)))
    if not (high - low > LINES * frequency[1] and low > 0 and rms > 0):
        return []
    middle, width = float(low + high) / 2, float(high - low)
    return [replace(own, rms=rms, frequency=middle, bandwidth=width, edged=1.0)]


def even_odds(bench: Bench, fits: Sequence[Fit], chances: Sequence[float]) -> list[float]:
    """Return probabilities in which places that no sensor tells apart share theirs evenly.

    Sensors above a place feel a force there and a motion of the ground in the same proportion at
    every frequency: only the shape of a spectrum that nobody knows favours either.
    """
    out = list(chances)
    same = [i for i, fit in enumerate(fits) if i == 0 or alike(bench, fits[0], fit)]
    for i in same:
        out[i] = sum(chances[j] for j in same) / len(same)
    return out


def alike(bench: Bench, one: Fit, other: Fit) -> bool:
    """Return whether two fits end with unmeasured forces that all sensors feel in proportion."""
    forces = one.hypothesis.found[-1], other.hypothesis.found[-1]
    if not all(isinstance(force, Disturbance) for force in forces):
        return False
    if one.hypothesis.labels[:-1] != other.hypothesis.labels[:-1]:
        return False
    felt = [_felt(bench, force.place) for force in forces]
    inner = np.abs(np.sum(felt[0].conj() * felt[1], axis=1))
    size = np.linalg.norm(felt[0], axis=1) * np.linalg.norm(felt[1], axis=1)
    return bool(np.all(inner > (1 - ALIKE) * size))


def _felt(bench: Bench, place: str) -> NDArray[np.complex128]:
    """Return what the sensors feel of a place at frequencies about the modes, (.., outputs).

    Without damping: what it adds rests on whether dashpots move with the ground.
    """
    model, outputs = replace(bench.model, R=np.zeros_like(bench.model.R)), bench.trials[0].outputs
    shaken = place == "ground" and "ground" not in model.coordinates
    plant = build(model, (), (SHAKE_TABLE if shaken else f"force_{place}",), outputs)
    own = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(model.M, model.K))))
    eye = np.eye(len(plant.A))
    return np.array(
        [
            (plant.C @ np.linalg.solve(1j * w * eye - plant.A, plant.B) + plant.D)[:, 0]
            for w in np.geomspace(own.min() / 3, 3 * own.max(), 20)
        ]
    )
