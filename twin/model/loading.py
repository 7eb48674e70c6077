"""A linear model with masses added: at a body's centre, or at a site."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError, available
from twin.model.port import AXES, ground_inputs

if TYPE_CHECKING:
    from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def loaded(model: LinearModel, name: str, mass: float) -> LinearModel:
    """Return the model with a mass at a body's centre, or at a site [kg].

    Raises:
        ModelError: there is no such body or site that moves.
    """
    rows = translation(model, name)
    bodies, added = dict(model.bodies), mass * rows.T @ rows
    if name in bodies:
        bodies[name] = replace(bodies[name], mass=bodies[name].mass + mass)
    B, base = np.array(model.B), dict(model.base)
    for axis, ground in model.base.items():
        row = ground.row + mass * rows[AXES.index(axis)]
        base[axis] = replace(ground, mass=ground.mass + mass, row=row)
    for axis, column in ground_inputs(model.inputs, model.base).items():
        B[:, column] -= mass * rows[AXES.index(axis)]
    return replace(model.adding(M=added), bodies=bodies, base=base, B=B)


def translation(model: LinearModel, name: str) -> Array:
    """Return the rows of a body's centre or of a site along x, y, z, (3, n)."""
    if name in model.bodies:
        return model.bodies[name].translation
    along = [p for p in model.ports.values() if p.element == f"site {name}" and p.unit == "m"]
    if not along:
        sites = [p.element for p in model.ports.values() if p.element.startswith("site ")]
        there = [*model.bodies, *dict.fromkeys(sites)]
        raise ModelError(f"no place '{name}' that moves; there are {available(there)}")
    rows = np.zeros((3, len(model.coordinates)))
    for port in along:
        rows[int(np.argmax(port.base))] = port.row
    return rows


def carried(model: LinearModel, name: str) -> float:
    """Return the mass that hangs on a joint or tendon [kg].

    Raises:
        ModelError: no such port, or one that carries nothing: no joint or tendon.
    """
    bodies = model.port_of(name).carries
    if not bodies:
        there = [port.name for port in model.ports.values() if port.carries]
        raise ModelError(f"'{name}' carries nothing; what does is {available(there)}")
    return sum(model.bodies[body].mass for body in bodies)
