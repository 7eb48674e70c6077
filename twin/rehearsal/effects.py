"""What can be concealed: every mechanism at every place, and its size in its own unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.errors import TwinError, available
from twin.mechanisms import places, vocabulary
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism, Surroundings
from twin.model.linear import LinearModel
from twin.quantity import QUANTITIES
from twin.rehearsal.plan import Plan

Array = NDArray[np.float64]

BY_FIELD: Mapping[str, tuple[str, str]] = {
    "sensor_spikes": ("height", "the channel's"),
    "sensor_dropout": ("length", "s"),
    "sensor_quantisation": ("step", "the channel's"),
}
"""What is read off the samples has no parameter: the field that says how large it is, its unit."""

CHANNELS = "the channel's"
"""How a unit is written that is the channel's own."""

LEAST_TIMES, MOST_TIMES = 1e-7, 1e3
"""Multiples of a visible effect that a size is looked for among: a gain of 5 % to the thousandth
power is still a number."""

SHAPES = 5
"""First guesses of a mechanism that are compared as rivals: gaps, corners and frequencies to both
sides of the reference's; each costs a response."""


@dataclass(frozen=True)
class Effect:
    """A mechanism at a place with a size of one, of which others are multiples.

    Attributes:
        reference: the mechanism at size one: a middle first guess of its own.
        shapes: first guesses of different shapes, neighbours beside each other.
        middle: which of them is the reference.
        unit: of the size.
        own: what the structure itself has there in that unit, for a share; 0 for nothing.
    """

    reference: Mechanism
    shapes: tuple[Mechanism, ...]
    middle: int
    unit: str
    own: float = 0.0

    @property
    def label(self) -> tuple[str, str]:
        """Mechanism and place."""
        return self.reference.name, self.reference.place

    @property
    def title(self) -> str:
        """The two in words: mass at floor1."""
        return f"{self.label[0]} at {self.label[1]}"

    @property
    def sized(self) -> bool:
        """Whether there can be more or less of it."""
        return self.at(2.0) != self.reference

    @property
    def shrinks(self) -> bool:
        """Whether a stronger effect has a smaller number, as a level that clips has."""
        one, two = self.size(1.0), self.size(2.0)
        return one is not None and two is not None and abs(two) < abs(one)

    def at(self, times: float) -> Mechanism:
        """Return it so many times as large as the reference."""
        return sized(self.reference, times)

    def size(self, times: float) -> float | None:
        """Return the size of that in its own unit; None for what has no size."""
        mechanism = self.at(times)
        if mechanism.name in BY_FIELD:
            return float(getattr(mechanism, BY_FIELD[mechanism.name][0]))
        if (name := strength_of(self.reference)) is None:
            return None
        return float(mechanism.values[name])

    def times(self, size: float) -> float:
        """Return which multiple of the reference has a size, found by bisection of logarithms.

        Raises:
            TwinError: none has.
        """
        low, high = np.log(LEAST_TIMES), np.log(MOST_TIMES)
        with np.errstate(all="ignore"):
            first, last = (self.size(float(np.exp(x))) for x in (low, high))
            if first is None or last is None or not min(first, last) <= size <= max(first, last):
                raise TwinError(f"{self.title}: has no size of {size:g} {self.unit}")
            for _ in range(100):
                middle = (low + high) / 2
                value = self.size(float(np.exp(middle)))
                assert value is not None
                if (value < size) == (first < last):
                    low = middle
                else:
                    high = middle
        return float(np.exp((low + high) / 2))


def sized(mechanism: Mechanism, times: float) -> Mechanism:
    """Return a mechanism with an effect so many times as strong."""
    if mechanism.name in BY_FIELD:
        field = BY_FIELD[mechanism.name][0]
        changed: dict[str, Any] = {field: times * getattr(mechanism, field)}
        return replace(mechanism, **changed)
    return mechanism.scaled(times)


def strength_of(mechanism: Mechanism) -> str | None:
    """Return the first parameter that a stronger effect has another value of."""
    stronger = mechanism.scaled(2.0).values
    return next((n for n, value in mechanism.values.items() if stronger[n] != value), None)


def adds(mechanism: Mechanism) -> bool:
    """Return whether a fault adds a process of its own to its channel: hum, drift."""
    if not isinstance(mechanism, ChannelFault):
        return False
    made = mechanism.instrument(1.0)
    return made is not None and made.G.size > 0


def effects_of(
    plan: Plan, model: LinearModel, kinds: Mapping[str, str], around: Mapping[str, Surroundings]
) -> tuple[Effect, ...]:
    """Return everything the plan conceals, by mechanism and place.

    Args:
        plan: which mechanisms and places; what stands for no physics of its own is left out.
        model: linear equations of the twin with the plan's inputs and outputs.
        kinds: channel -> quantity.
        around: place -> what is known there; ``every_place`` says for which it is wanted.

    Raises:
        TwinError: a place that no mechanism can have; the message lists those there are.
    """
    found, there = [], every_place(plan, model, kinds)
    for name in plan.places or ():
        if not any(name in names for names in there.values()):
            every = dict.fromkeys(place for names in there.values() for place in names)
            raise TwinError(f"conceal.places: no place '{name}'; there are {available(every)}")
    for name, names in there.items():
        cls = vocabulary()[name]
        for place in names:
            if plan.places is not None and place not in plan.places:
                continue
            effect = _effect(cls, place, around[place], model, kinds, plan.values.get(name, {}))
            if effect is not None:
                found.append(effect)
    if not found:
        raise TwinError("conceal: none of these mechanisms can be at one of these places")
    return tuple(found)


def every_place(
    plan: Plan, model: LinearModel, kinds: Mapping[str, str]
) -> dict[str, tuple[str, ...]]:
    """Return the places of each mechanism that the plan conceals."""
    wanted = plan.mechanisms or tuple(n for n, c in vocabulary().items() if not c.generic)
    return {name: tuple(places(vocabulary()[name], model, kinds)) for name in wanted}


def _effect(
    cls: type[Mechanism], place: str, around: Surroundings, model: LinearModel,
    kinds: Mapping[str, str], values: Mapping[str, float],
) -> Effect | None:  # fmt: skip
    starts: list[Mechanism]
    if cls.name in BY_FIELD:
        starts = [_read_off(cls, place, around)]
    else:
        offered = cls.starts(place, around)
        starts = [s for s in offered if np.isfinite(list(s.values.values())).all()]
    if not starts:
        return None
    starts = [start.with_values(values) for start in starts]
    # a loop without a plateau is none in MuJoCo: what is concealed must be what is simulated
    held = [start for start in starts if getattr(start, "shape", 0.0) > -0.5]
    reference = held[len(held) // 2]
    different: dict[tuple[float, ...], Mechanism] = {}
    for start in starts:
        different.setdefault(_shape(start), start)
    different[_shape(reference)] = reference
    every = list(different.values())
    middle = every.index(reference)
    first = int(np.clip(middle - SHAPES // 2, 0, max(len(every) - SHAPES, 0)))
    shapes = tuple(every[first : first + SHAPES])
    unit = _unit(reference, model, kinds)
    return Effect(reference, shapes, middle - first, unit, _own(reference, around))


def _shape(mechanism: Mechanism) -> tuple[float, ...]:
    """Return what is the same however strong a mechanism is; two of one shape differ in size."""
    values, twice = mechanism.values, mechanism.scaled(2.0).values
    strong = [n for n in values if values[n] != twice[n]]
    scale = next((abs(values[n]) for n in strong if values[n]), 1.0)
    if mechanism.name == "sensor_gain":  # its size is a distance from one
        return (float(np.sign(values["gain"] - 1)),)
    return tuple(
        float(f"{values[n] / scale if n in strong else values[n]:.6g}") for n in sorted(values)
    )


def _read_off(cls: type[Mechanism], place: str, around: Surroundings) -> Mechanism:
    """Return a fault of a tenth of the reading, or of a tenth of a second."""
    level = float(np.sqrt(np.mean(around.reading**2)))
    field = BY_FIELD[cls.name][0]
    made: dict[str, Any] = {field: 0.1 if field == "length" else 0.1 * level}
    if cls.name == "sensor_spikes":  # one in two seconds
        made["often"] = 0.5
    if cls.name == "sensor_dropout":
        made["begin"] = 0.3 * around.duration_s
    return replace(cls(place), **made)


def _unit(mechanism: Mechanism, model: LinearModel, kinds: Mapping[str, str]) -> str:
    """Return the unit of a size, empty for a pure number."""
    unit = _written(mechanism, model)
    kind = kinds.get(mechanism.place.split("+")[0], "other")
    if unit.startswith(CHANNELS) and kind in QUANTITIES:
        unit = QUANTITIES[kind].unit + unit.removeprefix(CHANNELS)
    return "" if unit == "1" else unit


def _written(mechanism: Mechanism, model: LinearModel) -> str:
    if mechanism.name in BY_FIELD:
        return BY_FIELD[mechanism.name][1]
    if (name := strength_of(mechanism)) is None:
        return ""
    place, unit = mechanism.place, "m"
    if isinstance(mechanism, Disturbance) and place in model.places("base"):
        unit = "m/s^2"
    elif place in model.ports:
        unit = model.port_of(place).unit
    return type(mechanism).units(unit)[name]


def _own(mechanism: Mechanism, around: Surroundings) -> float:
    """Return what the structure has at the place in the unit of the mechanism's strength."""
    name = strength_of(mechanism)
    if name is None or isinstance(mechanism, ChannelFault | Disturbance):
        return 0.0
    has = {"N/m": around.stiffness, "N s/m": around.damping, "kg": around.mass}
    return float(has.get(type(mechanism).parameters[name].unit, 0.0))
