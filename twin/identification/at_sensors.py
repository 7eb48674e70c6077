"""A model's modes as its sensors see them, to be laid beside those identified there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twin.errors import ModelError
from twin.modal import ModalModel
from twin.model import Twin
from twin.model.linear import LinearModel


def sensed(twin: Twin, names: Sequence[str]) -> tuple[str, ...]:
    """Return those of some channels that are sensors of a model."""
    found = []
    for name in names:
        try:
            twin.linear((), (name,))
        except ModelError:
            continue
        found.append(name)
    return tuple(found)


def driven(twin: Twin, names: Sequence[str]) -> tuple[str, ...]:
    """Return those of some channels that drive a model: actuators and its shaken ground."""
    found = []
    for name in names:
        try:
            twin.linear((name,), ())
        except ModelError:
            continue
        found.append(name)
    return tuple(found)


def modes_of(model: LinearModel) -> tuple[ModalModel, np.ndarray]:
    """Return the oscillating modes of linear equations at their sensors, and their residues.

    The residue of output o and input j at the pole s is lim (p - s) H_oj(p) for p -> s, with H the
    response from input to output; of accelerations the shapes are those of accelerations.

    Returns:
        The modes by frequency, and residues, (modes, outputs, inputs).
    """
    system = model.state_space()
    values, right = np.linalg.eig(system.A)
    left = np.linalg.inv(right)
    rates = np.abs(values)
    keep = np.flatnonzero((values.imag > 1e-9 * rates) & (values.real < 0))
    keep = keep[np.argsort(rates[keep])]
    shapes = system.C @ right[:, keep]
    residues = shapes.T[:, :, None] * (left[keep] @ system.B)[:, None, :]
    modal = ModalModel(
        rates[keep] / (2 * np.pi), -values.real[keep] / rates[keep], shapes, model.outputs
    )
    return modal, residues


def modes_at_sensors(twin: Twin, outputs: Sequence[str]) -> ModalModel:
    """Return a model's modes with their shapes at some sensors; at its places where it has none.

    Raises:
        ModelError: the model has no rest, or a mode does not oscillate.
    """
    names = sensed(twin, outputs)
    return modes_of(twin.linear((), names))[0] if names else twin.modes()
