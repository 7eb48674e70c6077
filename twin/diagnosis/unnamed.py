"""A law without a name: whether what is missing is outside the vocabulary."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.base import surroundings
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit, fit
from twin.diagnosis.motion import motion_of
from twin.diagnosis.predict import ahead, from_rest, noise_floors, nrmse
from twin.diagnosis.refining import refined
from twin.diagnosis.scene import Candidate, Scene
from twin.diagnosis.stage import DECISIVE, LITTLE, Stage, explained, fitted, is_narrow
from twin.mechanisms.mechanism import Disturbance
from twin.mechanisms.restoring_force import RestoringForce

Array = NDArray[np.float64]

FORESEES = 0.85
"""A law without a name must take the error two seconds ahead to this share of what both a random
force and the twin without either miss: a force that follows the motion can be foreseen in part."""

MOTION = ("missing_physics", "parameter")
"""Verdicts of what acts on the motion: a faulty channel does not."""

POOR = 1.6
POOR_SHARE = 0.3
"""An explanation that misses two seconds ahead by this many times what noise alone would do, and by
this share of what the twin without it misses, is none."""

UNNAMED = 200.0
UNNAMED_SHARE = 0.02
"""What a law without a name must bring beyond the best that has one, and as a share of what that
one explains: it is flexible enough to take up a named law's small inexactness."""

CLEARER = 0.5
"""Where it takes the error two seconds ahead to this share of the named one's, what any mechanism
must bring is enough."""


def unnamed_law(
    bench: Bench,
    nothing: Fit,
    best: Fit,
    stages: Sequence[Stage],
    heights: Mapping[str, float],
    tell: Callable[[str], None],
    follower: Fit | None = None,
) -> tuple[Fit, Fit | None]:
    """Return the best fit with names, and that of a law without one where it beats it by far.

    It is tried where a latent force enters best, and only when the best explanation leaves its
    filter something to follow, or explains less than a random force that ``follower`` has shown
    to follow the motion.
    """
    if not best.hypothesis.found:
        return best, None
    last = stages[-1]
    broad = not is_narrow(best.hypothesis.found[0])
    done = last.before is best and explained(best, last.where, bench)
    poor = is_poor(bench, nothing, best) or _outdone(bench, best, follower)
    if not poor and ((done and not broad) or not _about_motion(best)):
        return best, None
    moved, known, plain = motion_of(bench, nothing)
    scene = Scene(known, plain, tuple(moved), heights)
    motion = scene.motion()
    storeys = [p for p in stages[0].where if p.startswith("storey")]
    storeys.sort(key=lambda p: -stages[0].where[p])
    found: list[tuple[Fit, float]] = []
    for place in storeys[:2]:
        tell(f"fitting a law without a name at {place}")
        (start,) = RestoringForce.starts(place, surroundings(bench, motion, heights, place))
        law = fitted(bench, nothing, Candidate(start, 0.0))
        if law is not None and np.isfinite(missed := foresees_off(bench, law)):
            found.append((law, missed))
    if not found:
        return best, None
    unnamed, missed = min(found, key=lambda pair: pair[0].bic)
    if unnamed.bic < best.bic:
        # the flexible law may have found the way that the named one missed
        along = replace(best.hypothesis, base=unnamed.hypothesis.base)
        with suppress(np.linalg.LinAlgError):
            again = refined(bench, [along], unnamed.slack, unnamed.starts)
            best = min(best, again, key=lambda f: f.bic)
    if broad:  # a force that follows the motion is a law, however well noise fits
        otherwise = min(foresees_off(bench, best), foresees_off(bench, nothing))
        if missed < FORESEES * otherwise:
            return best, unnamed
    if poor and unnamed.bic < nothing.bic - DECISIVE:
        return best, unnamed
    wins = unnamed.bic < best.bic - _needed(bench, nothing, best, missed)
    return best, unnamed if wins else None


def _needed(bench: Bench, nothing: Fit, best: Fit, missed: float) -> float:
    """Return the drop of the BIC that a law without a name, which misses so much, must bring."""
    if missed < CLEARER * foresees_off(bench, best):
        return DECISIVE
    return max(UNNAMED, UNNAMED_SHARE * (nothing.bic - best.bic))


def _outdone(bench: Bench, best: Fit, follower: Fit | None) -> bool:
    """Return whether a random force explains more than the laws; noise levels may have changed.

    Not beside faults of instruments, and not where the laws' own free run was the judge: there
    noise of the measured force is taken for nothing, and a random force would stand for it.
    """
    if follower is None or not _about_motion(best) or len(bench.slacks) == 1:
        return False
    try:
        again = fit(bench, follower.hypothesis, follower.slack, follower.starts, iterations=1)
    except np.linalg.LinAlgError:
        return False
    return again.bic < best.bic - DECISIVE


def runs_off(bench: Bench, found: Fit) -> float:
    """Return the error of the free run over the training recordings."""
    return _missed(bench, lambda: from_rest(bench, found.hypothesis, found.slack))


def foresees_off(bench: Bench, found: Fit) -> float:
    """Return the error two seconds ahead on the training recordings."""
    return _missed(bench, lambda: ahead(bench, found.hypothesis, found.slack, found.starts))


def _missed(bench: Bench, simulated: Callable[[], Sequence[Array]]) -> float:
    """Return the NRMSE of simulated outputs; infinite where there are none."""
    try:
        value = nrmse(bench.trials, simulated())
    except np.linalg.LinAlgError:
        return np.inf
    return value if np.isfinite(value) else np.inf


def is_poor(bench: Bench, nothing: Fit, best: Fit) -> bool:
    """Return whether the best explanation leaves most of what there is to explain.

    Unmeasured forces cannot be foreseen: for them the filter's own slack tells. Several parameters
    are a calibration: what they leave is looked for further.
    """
    moving = [m.verdict for m in best.hypothesis.found if m.verdict in MOTION]
    if not moving or (len(moving) > 1 and set(moving) == {"parameter"}):
        return False
    if all(isinstance(m, Disturbance) for m in best.hypothesis.found):
        return best.slack > LITTLE
    missed = foresees_off(bench, best)
    if not np.isfinite(missed):
        return True
    if missed < POOR_SHARE * foresees_off(bench, nothing):
        return False
    return missed > POOR * noise_floors(bench, best.hypothesis, best.slack, seed=0)[1]


def _about_motion(best: Fit) -> bool:
    """Return whether the explanation is one of forces: a faulty channel is no law of motion."""
    return all(m.verdict in MOTION for m in best.hypothesis.found)
