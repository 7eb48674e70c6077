"""Which estimator foresees: the twin and the slack that forecasts two seconds ahead start from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import ahead, noise_floors, squared_errors
from twin.diagnosis.trials import Trial
from twin.mechanisms.mechanism import Disturbance

Array = NDArray[np.float64]

SOUND = 1.1
"""An explanation that misses two seconds ahead by less than this many times what noise alone does
foresees as well as can be."""

CLEARLY = 0.98
UNSOUND = 0.8
NOWHERE = 1.02
UNSOUND_NOWHERE = 0.95
"""It foresees better than the calibrated twin where it misses less than ``CLEARLY`` of what that
one misses, over all training recordings, and in none of them more than ``NOWHERE`` times as much:
what is right on one kind of test only need not be so on the next, and a smaller gain comes and goes
with the noise. Where it is not sound, less than ``UNSOUND`` and ``UNSOUND_NOWHERE`` of it."""

FARTHER = 2.0
"""An explanation that is not sound holds for motions like those it was fitted to: a recording that
is so many times as strong in every channel as any of them is left to the calibrated twin."""


@dataclass(frozen=True)
class Estimator:
    """What forecasts two seconds ahead start from.

    Attributes:
        hypothesis: of the twin.
        slack: force noise that its filter assumes.
        strongest: RMS of each output up to which it is trusted, one an output; None for any.
    """

    hypothesis: Hypothesis
    slack: float
    strongest: tuple[float, ...] | None = None

    def covers(self, trial: Trial) -> bool:
        """Return whether a trial's motion is one that it is trusted with."""
        return self.strongest is None or bool(np.any(_rms(trial) <= self.strongest))


def foreseeing(bench: Bench, best: Fit, calibrated: Fit) -> Estimator:
    """Return the estimator that foresees the training recordings best.

    A model that is right foresees best with the slack it was fitted with. Where it is not, a filter
    that listens more knows the state better; and what cannot be foreseen, as broad noise, is better
    left to the filter's slack. What foresees no better than the calibrated twin is left to that.
    """
    whole, plain = best.hypothesis, calibrated.hypothesis
    if not whole.found or plain == whole:
        return Estimator(whole, best.slack)
    options = [(_missed(bench, whole, best.slack), whole, best.slack)]
    sound = bool(np.sum(options[0][0]) <= SOUND**2 * _least(bench, best))  # NaN is not
    if not sound:
        laws = without_disturbances(whole)
        tried = (whole,) if laws == whole else (whole, laws)
        options += [(_missed(bench, h, s), h, s) for h in tried for s in bench.slacks]
    least, hypothesis, slack = min(options, key=lambda option: float(np.sum(option[0])))
    other = _missed(bench, plain, calibrated.slack)
    enough, nowhere = (CLEARLY, NOWHERE) if sound else (UNSOUND, UNSOUND_NOWHERE)
    if np.sum(least) < enough**2 * np.sum(other) and np.all(least < nowhere**2 * other):
        if sound:
            return Estimator(hypothesis, slack)
        strongest = FARTHER * np.max([_rms(trial) for trial in bench.trials], axis=0)
        return Estimator(hypothesis, slack, tuple(strongest))
    return Estimator(plain, calibrated.slack)


def without_disturbances(whole: Hypothesis) -> Hypothesis:
    """Return the hypothesis with those findings only that can be foreseen."""
    return replace(whole, found=tuple(m for m in whole.found if not isinstance(m, Disturbance)))


def _rms(trial: Trial) -> Array:
    """Return the RMS of every output, (m,)."""
    return np.asarray(np.sqrt(np.mean(trial.y**2, axis=0)))


def _missed(bench: Bench, hypothesis: Hypothesis, slack: float) -> Array:
    """Return the squared error two seconds ahead, infinite where it runs away, (trials,)."""
    try:
        errors = squared_errors(bench.trials, ahead(bench, hypothesis, slack))
    except np.linalg.LinAlgError:
        return np.full(len(bench.trials), np.inf)
    return np.where(np.isfinite(errors), errors, np.inf)


def _least(bench: Bench, best: Fit) -> float:
    """Return the squared error two seconds ahead that noise alone leaves, over all trials."""
    try:
        floor = noise_floors(bench, best.hypothesis, best.slack, seed=0)[1]
    except np.linalg.LinAlgError:
        return np.nan
    return floor**2 * sum(float(np.sum(trial.y**2)) for trial in bench.trials)
