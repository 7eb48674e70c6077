"""Whether what is not linear in a model matters at the amplitudes of a test, by a number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.model.free_run import free_run
from twin.model.linear import LinearModel
from twin.model.nonlinear import NonlinearElement

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Effect:
    """What one element's nonlinearity does to a free run.

    Attributes:
        element: the element.
        share: largest change of any output that it makes, RMS over the output's RMS; infinite for
            an input beyond an actuator's limit, NaN for what has no law here.
        output: where that is.
        drift: largest displacement at its port [m or rad], or an actuator's largest input.
    """

    element: NonlinearElement
    share: float
    output: str
    drift: float

    def __str__(self) -> str:
        at = f" at up to {self.drift:.3g}" if np.isfinite(self.drift) else ""
        if np.isnan(self.share):
            return f"{self.element}{at}: its effect has no number here"
        return f"{self.element}{at}: changes {self.output} by {100 * self.share:.2g} % of its RMS"


def effects(
    model: LinearModel, elements: Sequence[NonlinearElement], inputs: Array, rate_hz: float
) -> tuple[Effect, ...]:
    """Return how much each element changes a free run of the linear model, the largest first.

    The element's force along the linear motion is applied to the linear model: the first step of an
    iteration that is exact for what is small, and far beyond any threshold for what is not.

    Args:
        model: linear equations of the model that has the elements.
        elements: from ``nonlinear_elements``.
        inputs: in the order of ``model.inputs``, (samples, r).
        rate_hz: samples per second.
    """
    u = np.asarray(inputs, float)
    y = free_run(model, u, rate_hz) - model.rest
    found = [_effect(model, element, u, y, rate_hz) for element in elements]
    return tuple(sorted(found, key=lambda e: -np.inf if np.isnan(e.share) else -e.share))


def _effect(
    model: LinearModel, element: NonlinearElement, u: Array, y: Array, rate_hz: float
) -> Effect:
    if np.isfinite(element.limit):
        peak, name = 0.0, element.port
        if name in model.inputs:
            peak = float(np.max(np.abs(u[:, model.inputs.index(name)]), initial=0.0))
        elif name in model.outputs:
            column = model.outputs.index(name)
            peak = float(np.max(np.abs(y[:, column] + model.rest[column]), initial=0.0))
        return Effect(element, np.inf if peak > element.limit else 0.0, name, peak)
    if element.law is None or element.port not in model.ports:
        return Effect(element, np.nan, "", np.nan)
    row = model.port(element.port)
    seen = model.seeing(np.vstack([row, 0 * row]), np.vstack([0 * row, row]))
    drift, rate = free_run(seen, u, rate_hz).T
    pushed = replace(
        model,
        inputs=("force",),
        B=-row[:, None],
        Cu=np.zeros((len(model.outputs), 1)),
        base={},
    )
    change = free_run(pushed, element.law(drift, rate)[:, None], rate_hz) - model.rest
    rms = np.sqrt(np.mean(y**2, axis=0))
    share = np.sqrt(np.mean(change**2, axis=0)) / np.where(rms > 0, rms, np.inf)
    worst = int(np.argmax(share))
    return Effect(element, float(share[worst]), model.outputs[worst], float(np.max(np.abs(drift))))
