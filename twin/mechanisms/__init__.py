"""The mechanisms: one file each, found by walking this folder; a lab's own by an entry point.

A package adds mechanisms of its own with an entry point of the group "frame_twin.mechanisms" for
each class. They need not be named anywhere else.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from importlib import import_module
from importlib.metadata import entry_points
from inspect import isabstract
from itertools import combinations
from pkgutil import iter_modules
from typing import Any

from twin.errors import ModelError, available
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model.linear import LinearModel
from twin.second_order import SecondOrderModel

GROUP = "frame_twin.mechanisms"
"""The entry-point group of mechanisms from elsewhere."""

__all__ = ["from_json", "places", "vocabulary"]


@lru_cache(maxsize=1)
def _found() -> dict[str, type[Mechanism]]:
    modules = [import_module(f"{__name__}.{info.name}") for info in iter_modules(__path__)]
    classes = [
        thing
        for module in modules
        for thing in vars(module).values()
        if isinstance(thing, type) and thing.__module__ == module.__name__
    ]
    classes += [point.load() for point in entry_points(group=GROUP)]
    concrete = (c for c in classes if issubclass(c, Mechanism) and not isabstract(c))
    return {c.name: c for c in sorted(concrete, key=lambda c: c.name)}


def vocabulary() -> dict[str, type[Mechanism]]:
    """Return every mechanism there is by its name, in alphabetical order."""
    return dict(_found())


def from_json(data: Mapping[str, Any]) -> Mechanism:
    """Return the mechanism that ``Mechanism.as_json`` described.

    Raises:
        ModelError: no such mechanism, a value it does not have, or no location.
    """
    name = data.get("mechanism")
    if name not in _found():
        raise ModelError(f"no mechanism '{name}'; there are {available(_found())}")
    if not isinstance(data.get("location"), str):
        raise ModelError(f"{name}: no location, such as storey1 or acc_floor1")
    empty = _found()[name](data["location"])
    known = empty.as_json()["values"]
    values = data.get("values", {})
    for key, value in values.items():
        if key not in known:
            raise ModelError(f"{name}: no value '{key}'; there are {available(known)}")
        if not isinstance(value, int | float):
            raise ModelError(f"{name}: '{key}' must be a number, not {value!r}")
    return empty.with_values({key: float(value) for key, value in values.items()})


def places(
    cls: type[Mechanism], model: LinearModel | SecondOrderModel, channels: Mapping[str, str]
) -> list[str]:
    """Return all places that a mechanism can be at.

    Args:
        cls: of the mechanism.
        model: whose ports, bodies and bases they are.
        channels: of the recordings -> its quantity ("acc", "force", ...).
    """
    if issubclass(cls, ChannelFault) and not cls.of_motor:
        of_kind = [name for name, kind in channels.items() if kind in cls.of_kinds]
        if cls.on == "channels":
            pairs = combinations(of_kind, 2)
            return ["+".join(pair) for pair in pairs if channels[pair[0]] == channels[pair[1]]]
        return of_kind
    if cls.on == "channel" or cls.on == "channels":
        return []
    if cls.on == "actuator":
        if issubclass(cls, ChannelFault):
            return list(model.driven)
        # a slide's dry friction is a force along it, as that of any joint
        joints = model.driven.values()
        return [name for name in joints if model.ports[name].unit == cls.port_unit]
    better = [p for other in _found().values() if other.also_named == cls.name
              for p in places(other, model, channels)]  # fmt: skip
    found = [place for place in model.places(cls.on) if place not in better]
    if issubclass(cls, Disturbance):
        found += [place for place in model.places("base") if place not in found]
    return found
