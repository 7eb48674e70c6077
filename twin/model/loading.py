"""A linear model with masses added: at a body's centre, or at a site."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from twin.errors import ModelError, available
from twin.model.port import AXES, ground_inputs

if TYPE_CHECKING:
    from twin.model.linear import LinearModel


def loaded(model: LinearModel, name: str, mass: float) -> LinearModel:
    """Return the model with a mass at a body's centre, or at a site [kg]; its weight acts, too.

    Raises:
        ModelError: there is no such body or site that moves.
    """
    at = model.bodies.get(name) or model.sites.get(name)
    if at is None:
        there = available([*model.bodies, *model.sites])
        raise ModelError(f"no place '{name}' that moves; there are {there}")
    rows, bodies = at.translation, dict(model.bodies)
    if name in bodies:
        bodies[name] = replace(at, mass=at.mass + mass)
    B, base = np.array(model.B), dict(model.base)
    for axis, ground in model.base.items():
        row = ground.row + mass * rows[AXES.index(axis)]
        base[axis] = replace(ground, mass=ground.mass + mass, row=row)
    for axis, column in ground_inputs(model.inputs, model.base).items():
        B[:, column] -= mass * rows[AXES.index(axis)]
    heavier = model.adding(M=mass * rows.T @ rows, K=mass * at.weight)
    return replace(heavier, bodies=bodies, base=base, B=B)


def carried(model: LinearModel, name: str) -> float:
    """Return the mass that hangs on a joint or tendon [kg].

    Raises:
        ModelError: no such port, or one that carries nothing: no joint or tendon.
    """
    bodies = model.port_of(name).carries
    if not bodies:
        there = [port.name for port in model.ports.values() if port.carries]
        raise ModelError(f"'{name}' carries nothing; what does is {available(there)}")
    return sum(model.bodies[body].mass for body in bodies if body in model.bodies)
