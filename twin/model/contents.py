"""All that a compiled model holds beyond linear equations."""

from __future__ import annotations

import mujoco

from twin.model.clocks import drifting_springs
from twin.model.imperfect import imperfect_instruments
from twin.model.nonlinear import NonlinearElement, structural_elements
from twin.model.rest import Reduced, settle


def nonlinear_elements(model: mujoco.MjModel, weights: bool = True) -> tuple[NonlinearElement, ...]:
    """Return the elements of a compiled model that are not linear about its rest, or not ideal.

    Args:
        model: the model.
        weights: whether what hangs on a joint counts, a matter of geometry.

    Raises:
        ModelError: the model has no rest.
    """
    reduced = Reduced(model)
    settle(reduced)
    reduced.at_rest()
    structure = tuple(structural_elements(model, reduced.data, weights))
    return (*structure, *drifting_springs(model), *imperfect_instruments(reduced, model))
