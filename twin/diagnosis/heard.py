"""A narrow unmeasured force that was found somewhere, tried at every place and with edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import signal

from twin import physics
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.predict import unmeasured
from twin.diagnosis.refining import refined
from twin.physics.unmeasured_force import UnmeasuredForce

SAMPLES = 4096
"""Of a piece of the spectrum in which a band's edges are looked for."""

LINES = 3
"""Lines of that spectrum within which a force is a sinusoid, without edges to speak of."""

BROAD_HZ = 0.5
"""Bandwidth from which on a force takes up whatever there is, wherever it acts."""

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
        for place in physics.places(type(own), floors, ()):
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
