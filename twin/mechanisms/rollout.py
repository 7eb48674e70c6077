"""The motion of a linear structure with mechanisms, by the estimator's own stepping loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError
from twin.estimation.kalman import Gains
from twin.estimation.laws import MOST_NUMBERS
from twin.estimation.passing import run
from twin.estimation.system import System, sampled
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange
from twin.mechanisms.replay import in_order
from twin.model.free_run import free_run
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

STEPS = 16
"""Parts of a sample in which laws are stepped: the midpoint rule's error falls with the square,
that of the instant at which dry friction begins to hold with the first power."""


TINY = 1e-12
"""Least size of a law's force, displacement and rate, so that none is divided by [SI]."""


def rollout(
    model: LinearModel,
    mechanisms: Sequence[Mechanism],
    inputs: Mapping[str, Array],
    rate_hz: float,
    steps: int = STEPS,
) -> dict[str, Array]:
    """Return the outputs of a structure with mechanisms, from rest.

    Args:
        model: linear equations of the structure without the mechanisms.
        mechanisms: what it has beyond them; faults of channels change what is returned.
        inputs: all of ``model.inputs``, linear between samples, each (samples,).
        rate_hz: samples per second.
        steps: parts of a sample in which laws are stepped.

    Returns:
        Output -> samples, SI, what it reads at rest included.

    Raises:
        ModelError: the model has no such place or channel, or a mechanism is random.
    """
    ordered = in_order(mechanisms)
    random = [m for m in ordered if isinstance(m, Disturbance)]
    if random:
        raise ModelError(f"{random[0].name} at {random[0].place} is random: it has no one motion")
    columns = {name: np.asarray(inputs[name], float) for name in model.inputs}
    columns = _faulty(ordered, columns, rate_hz, of_motor=True)
    u = np.column_stack([columns[name] for name in model.inputs])
    for mechanism in ordered:
        if isinstance(mechanism, StructuralChange):
            model = mechanism.edit(model)
    laws = [m for m in ordered if isinstance(m, Law)]
    y = _with_laws(model, laws, u, rate_hz, steps) if laws else free_run(model, u, rate_hz)
    return _faulty(ordered, dict(zip(model.outputs, y.T, strict=True)), rate_hz, of_motor=False)


def _with_laws(
    model: LinearModel, laws: Sequence[Law], u: Array, rate_hz: float, steps: int
) -> Array:
    n, m = len(model.coordinates), len(model.outputs)
    linear = model.state_space()
    rows = np.array([model.port(law.place) for law in laws])
    push = -np.linalg.solve(model.M, rows.T)
    none = np.zeros((2 * n, 0))
    system = System(
        *(linear.A, linear.B, linear.C, linear.D),
        np.vstack([0 * push, push]),
        model.Ca @ push,
        np.hstack([rows, 0 * rows]),
        np.hstack([0 * rows, rows]),
        none,
        np.zeros((m, 0)),
        none,
    )
    held = np.zeros(u.shape[1], bool)
    plant = sampled(system, 1 / rate_hz, steps, held)
    numbers = np.zeros((len(laws), MOST_NUMBERS))
    for row, law in zip(numbers, laws, strict=True):
        row[: len(law.numbers)] = law.numbers
    bare: Any = SimpleNamespace(
        laws=tuple(law.compiled for law in laws),
        numbers=numbers,
        scales=_scales(model, laws, u, rate_hz),
        held=held,
    )
    trial: Any = SimpleNamespace(u=u, between=u, y=np.zeros((len(u), m)), step_s=1 / rate_hz)
    deaf = Gains(
        np.zeros((1, 2 * n, m)), np.zeros((1, 0, m)), np.eye(m)[None], np.zeros((2 * n, 2 * n))
    )
    # innovations against a reading of nothing are the prediction's opposite
    return np.asarray(model.rest - run(bare, trial, plant, deaf).e)


def _scales(model: LinearModel, laws: Sequence[Law], u: Array, rate_hz: float) -> Array:
    """Return sizes of force, displacement and rate at each law's port in the linear motion."""
    rows = np.array([model.port(law.place) for law in laws])
    x = free_run(model.seeing(rows, 0 * rows), u, rate_hz)
    v = free_run(model.seeing(0 * rows, rows), u, rate_hz)
    scales = np.ones((len(laws), 3))
    for j, law in enumerate(laws):
        drift, rate = float(np.std(x[:, j])), float(np.std(v[:, j]))
        force = float(np.abs(law.force(np.array(drift), np.array(rate), np.array(0.0), 0.0)))
        scales[j] = np.maximum([force, drift, rate], TINY)
    return scales


def _faulty(
    mechanisms: Sequence[Mechanism], columns: dict[str, Array], rate_hz: float, of_motor: bool
) -> dict[str, Array]:
    for fault in mechanisms:
        if isinstance(fault, ChannelFault) and fault.of_motor == of_motor:
            columns = fault.distort(columns, rate_hz)
    return columns
