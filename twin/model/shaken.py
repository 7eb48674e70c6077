"""What a shaken base does to masses that are not the model's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from twin.model.linear import LinearModel
from twin.model.port import AXES, Body, ground_inputs


def with_inertia(model: LinearModel, changes: Sequence[tuple[Body, float]]) -> LinearModel:
    """Return a model whose shaken base pushes masses that have changed.

    Args:
        model: its mass matrix holds the changes already.
        changes: bodies, and by which share of it the mass of each has changed.
    """
    if not any(name.startswith("acc_ground") for name in model.inputs):
        return model
    B, base = np.array(model.B), dict(model.base)
    for axis in base:
        row = np.array(base[axis].row)
        for body, share in changes:
            row += body.mass * share * body.translation[AXES.index(axis)]
        base[axis] = replace(base[axis], row=row)
    for axis, column in ground_inputs(model.inputs, model.base).items():
        B[:, column] += model.base[axis].row - base[axis].row
    return replace(model, B=B, base=base)
