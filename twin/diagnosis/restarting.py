"""What else a search may begin with, where what it began with led nowhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.scene import Candidate
from twin.diagnosis.stage import Stage, fitted, is_lawful
from twin.mechanisms.sensor_clipping import SensorClipping

OTHERWISE = 0.3
"""Share of an unmeasured force's drop of the BIC that another first mechanism must bring."""


def other_beginnings(bench: Bench, nothing: Fit, first: Stage) -> Iterator[Stage]:
    """Yield the first stage with something else in front, the likeliest first.

    Of two effects at once neither may explain as much alone as an unmeasured force does.

    Args:
        bench: model and trials of the first stage.
        nothing: the fit of nothing missing.
        first: the stage that the search began with.
    """
    if not first.fits:
        return
    if (ended := _range_ended(bench, nothing, first)) is not None:
        yield ended
    if is_lawful(first.fits[0]):
        return
    chosen = min((f for f in first.fits if is_lawful(f)), key=lambda f: f.bic, default=None)
    if chosen is not None and nothing.bic - chosen.bic >= OTHERWISE * (
        nothing.bic - first.fits[0].bic
    ):
        yield replace(first, fits=(chosen, *(f for f in first.fits if f is not chosen)))


def _range_ended(bench: Bench, nothing: Fit, first: Stage) -> Stage | None:
    """Return the stage of a range that ends where readings pile up, whatever else there is.

    A law that the other channels show is found only once what is cut off is not compared.
    """
    fits = []
    for name in bench.trials[0].outputs:
        reading = np.concatenate([trial.columns[name] for trial in bench.trials])
        clipping = SensorClipping.piled(name, reading)
        mine = first.fits[0].hypothesis.labels[-1]
        if clipping is None or mine == (clipping.name, clipping.place):
            continue
        fit = fitted(bench, nothing, Candidate(clipping, 0.0))
        fits += [fit] if fit is not None else []
    best = min(fits, key=lambda f: f.bic, default=None)
    return None if best is None else replace(first, fits=(best,))
