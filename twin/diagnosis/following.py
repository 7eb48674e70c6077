"""Whether a force that nobody measured grows with the motion: then it is a law, not a disturbance.

Wind and traffic do not know how hard the frame is being shaken. What a law leaves over does: it
dies away after every hit, and is stronger in the recording that was taken at a higher level.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.predict import from_rest, unmeasured

Array = NDArray[np.float64]

WINDOW_S = 0.5
"""Length of the windows whose power is compared [s]."""

FOLLOWS = 0.35
"""Correlation with the recorded motion from which a force follows it: laws outside the vocabulary
reached 0.45 and more, disturbances 0.2 at most."""

CAUSED = 0.1
"""The same with what the measured forces alone would cause: a lorry that passes shakes the frame
and is felt in both, but comes when it likes."""

FEWEST = 10
"""Windows that it takes to tell."""

SILENT = 1e-12
"""Power that is added to every window's, as a share of the loudest."""


def follows_motion(bench: Bench, nothing: Fit, found: Fit) -> bool:
    """Return whether the last finding, a disturbance, follows the motion that the tests cause."""
    index = len(found.hypothesis.found) - 1
    heard = unmeasured(bench, found.hypothesis, found.slack, found.starts)[index]
    length = max(round(WINDOW_S / bench.step_s), 1)
    recorded = _correlation(heard, [trial.y for trial in bench.trials], length)
    caused = _correlation(heard, from_rest(bench, nothing.hypothesis, nothing.slack), length)
    return recorded > FOLLOWS and caused > CAUSED


def _correlation(heard: Sequence[Array], outputs: Sequence[Array], length: int) -> float:
    """Return the correlation of the logarithms of two powers, window by window over all trials.

    Zero where there are too few windows to tell, or one of the two is silent or always the same.
    """
    forces = [_powers(force[:, None], length) for force in heard]
    motions = [_powers(y[-len(f) :], length) for f, y in zip(heard, outputs, strict=True)]
    one, other = (np.concatenate(powers) for powers in (forces, motions))
    if len(one) < FEWEST or not min(one.max(), other.max()) > 0:
        return 0.0
    logarithms = [np.log(powers + SILENT * powers.max()) for powers in (one, other)]
    if not all(np.std(values) > 0 for values in logarithms):
        return 0.0
    return float(np.corrcoef(*logarithms)[0, 1])


def _powers(x: Array, length: int) -> Array:
    """Return the mean squares of a signal's windows, (windows,)."""
    count = len(x) // length
    windows = x[: count * length].reshape(count, length * x.shape[1])
    return np.asarray(np.mean(windows**2, axis=1))
