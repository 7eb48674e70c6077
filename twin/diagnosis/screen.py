"""Screen every mechanism at every place: what each would explain, before any is fitted in full.

Along the smoothed motion the force of a law is known but for its strength, and a known force
enters the innovations of a linear filter linearly: so a regression says how much of them it
explains. What is linear is fitted at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin import mechanisms
from twin.diagnosis.base import bent, surroundings
from twin.diagnosis.bench import Bench
from twin.diagnosis.filtering import Gain
from twin.diagnosis.fitting import Slopes, fit, gains_of, log_likelihood
from twin.diagnosis.places import places
from twin.diagnosis.refining import with_slack, with_widths
from twin.diagnosis.regression import Regression
from twin.diagnosis.scene import Candidate, Scene
from twin.mechanisms.base_compliance import BaseCompliance
from twin.mechanisms.mechanism import (
    ChannelFault,
    Disturbance,
    Law,
    Mechanism,
    Surroundings,
)
from twin.mechanisms.slight import SlightChange

Array = NDArray[np.float64]

WORTH_FOLLOWING = 5.0
"""Gain in log likelihood that a slight change must promise along the motion to be followed."""

MOST_STRAIGHT = 4
"""How many faults are tried from a straight base."""

FORGETFUL = 0.03
"""Slack at which a filter forgets within some periods: then a resonance may be off in frequency by
more than a record resolves, and its fit still finds the way."""


def screen(scene: Scene, without: Sequence[tuple[str, str]] = ()) -> list[Candidate]:
    """Return the best first values of every mechanism at every place, the most promising first."""
    bench = scene.bench
    motion = scene.motion()
    peaks = scene.peaks()
    regression = Regression(scene)
    out = []
    channels = [*bench.trials[0].outputs, *bench.trials[0].inputs]
    channels = [c for c in channels if not c.startswith("law_")]
    for name, cls in mechanisms.vocabulary().items():
        for place in places(cls, bench.model, channels):
            if (name, place) in without or not _possible(cls, place, bench):
                continue
            around = surroundings(bench, motion, scene.heights, place, peaks)
            starts = [s for s in cls.starts(place, around) if not _lost(s, bench)]
            if not starts:
                continue
            if issubclass(cls, Law):
                out.append(regression.best([s for s in starts if isinstance(s, Law)]))
            else:
                slight = _slight(regression, cls, place, around)
                if slight is None:
                    out.append(_fitted(regression, starts))
                elif slight.gain > WORTH_FOLLOWING:
                    out.append(_fitted(regression, (slight.mechanism, *starts)))
                else:
                    out.append(slight)
    return sorted((c for c in out if np.isfinite(c.gain)), key=lambda c: -c.gain)


def _possible(cls: type[Mechanism], place: str, bench: Bench) -> bool:
    """Return whether the model and the recordings have what the mechanism needs."""
    if cls.on in ("channel", "channels"):
        return True
    if cls.on == "actuator":
        return "pendulum" in bench.model.coordinates
    if cls.generic:
        return False
    return not (cls.name == "base_compliance" and "ground" in bench.model.coordinates)


def _slight(
    regression: Regression, cls: type[Mechanism], place: str, around: Surroundings
) -> Candidate | None:
    """Return the best of a grid of slight changes, at the strength that it would have."""
    return regression.slight(cls.light(place, around)) if issubclass(cls, SlightChange) else None


def _lost(start: Mechanism, bench: Bench) -> bool:
    """Return whether a fault loses what an input was: that is neither undone nor predicted."""
    if not isinstance(start, ChannelFault) or start.place in bench.trials[0].outputs:
        return False
    return start.limit() is not None or start.filter_hz() is not None


def _fitted(regression: Regression, starts: Sequence[Mechanism]) -> Candidate:
    """Fit a linear mechanism from the best of its starts, in a few steps."""
    scene = regression.scene
    if isinstance(starts[0], ChannelFault) and starts[0].limit() is not None:
        return _clipped(scene, starts)
    candidates = [Candidate(starts[0], -np.inf)]
    for value, start in ranked(scene, starts)[: starts[0].valleys]:
        candidates.append(_followed(scene, start, value, scene.fit.slack, regression.slopes))
    if isinstance(starts[0], SlightChange) and scene.fit.slack < FORGETFUL:
        # a filter that forgets likes none of them as they stand: in their own order, then
        for start in starts[: starts[0].valleys]:
            candidates.append(_followed(scene, start, -np.inf, FORGETFUL))
    if isinstance(starts[0], ChannelFault | BaseCompliance) and bent(scene.fit.hypothesis):
        # what the base was bent for may have been this: from a straight one, too
        best = max(candidates, key=lambda c: c.gain).mechanism
        straight, slack, slopes = regression.straight
        # a base moves with what is above it: there the slopes change
        known = slopes if isinstance(starts[0], ChannelFault) else None
        for start in (*starts[:MOST_STRAIGHT], best):
            candidates.append(_followed(straight, start, -np.inf, slack, known))
    return max(candidates, key=lambda c: c.gain)


def ranked(scene: Scene, starts: Sequence[Mechanism]) -> list[tuple[float, Mechanism]]:
    """Return log likelihoods and first guesses as they stand, the likeliest first."""
    bench, fit0 = scene.bench, scene.fit
    ranked = []
    for start in starts:
        hypothesis = fit0.hypothesis.including(start)
        try:
            gains = gains_of(bench, hypothesis, fit0.slack)
            begin = [_grown(s, g) for s, g in zip(fit0.starts, gains, strict=True)]
            rows = bench.innovations([hypothesis], gains, begin)
        except np.linalg.LinAlgError:
            continue
        ranked.append((log_likelihood([row[0] for row in rows]), start))
    return sorted(ranked, key=lambda pair: -pair[0])


def _followed(
    scene: Scene,
    start: Mechanism,
    value: float,
    slack: float,
    slopes: Slopes | None = None,
) -> Candidate:
    """Follow one first guess for a few steps, along known slopes for what was found before."""
    bench, fit0 = scene.bench, scene.fit
    promised = Candidate(start, value - fit0.log_likelihood)
    if not start.parameters:
        return promised
    try:
        hypothesis = fit0.hypothesis.including(start)
        found = fit(bench, hypothesis, slack, fit0.starts, start.steps, slopes=slopes)
    except np.linalg.LinAlgError:
        return promised
    if slack != fit0.slack:
        found = with_slack(bench, found)
    if isinstance(start, Disturbance):
        found = with_widths(bench, found)
    rest = replace(found.hypothesis, found=found.hypothesis.found[:-1])
    gained = found.log_posterior - fit0.log_posterior
    return Candidate(found.hypothesis.found[-1], gained, rest)


def _clipped(scene: Scene, starts: Sequence[Mechanism]) -> Candidate:
    """Return the level that explains most when predictions beyond it are cut off there."""
    bench, fit0 = scene.bench, scene.fit
    best = Candidate(starts[0], -np.inf)
    for start in starts:
        assert isinstance(start, ChannelFault)
        level = start.limit() or np.inf
        row = bench.trials[0].outputs.index(start.place)
        cut = []
        for trial, e in zip(bench.trials, fit0.innovations, strict=True):
            predicted = trial.y[:, row] - e[:, row]
            changed = e.copy()
            changed[:, row] = trial.y[:, row] - np.clip(predicted, -level, level)
            cut.append(changed)
        gained = log_likelihood(cut) - fit0.log_likelihood
        if gained > best.gain:
            best = Candidate(start, gained)
    return best


def _grown(start: Array, gains: Gain) -> Array:
    n = len(gains.filtered)
    return np.concatenate([start, np.zeros(n)])[:n]
