"""Replay mechanisms on a model, and say in words what the model then holds."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco

from twin.channel import split_axis
from twin.errors import ModelError, available
from twin.mechanisms.base import places_of_base
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.mechanisms.rest import Rest


def replay(spec: mujoco.MjSpec, mechanisms: Iterable[Mechanism]) -> None:
    """Edit a model by mechanisms, those of a lower stage first, otherwise in their order.

    Raises:
        ModelError: the model has no such place or channel; the message lists those it has.
    """
    for mechanism in in_order(mechanisms):
        _check(spec, mechanism)
        try:
            mechanism.apply(spec)
        except ValueError as error:
            raise ModelError(f"{mechanism.name} at {mechanism.place}: {error}") from None


def in_order(mechanisms: Iterable[Mechanism]) -> list[Mechanism]:
    """Return mechanisms in the order in which they edit a model or its matrices."""
    return sorted(mechanisms, key=lambda mechanism: mechanism.stage)


def in_words(mechanisms: Iterable[Mechanism]) -> str:
    """Return what mechanisms a model has and what MJCF cannot hold of them, a line each."""
    lines = []
    for mechanism in in_order(mechanisms):
        values = [
            f"{name} {mechanism.values[name]!r} {parameter.unit}"
            for name, parameter in mechanism.parameters.items()
        ]
        line = ", ".join([f"{mechanism.name} at {mechanism.place}", *values])
        if mechanism.mjcf:
            line += f" (not in this file: {mechanism.mjcf})"
        lines.append(line)
    return "\n".join(lines)


def _check(spec: mujoco.MjSpec, mechanism: Mechanism) -> None:
    """Check the place of what edits nothing, so that ``apply`` cannot."""
    if isinstance(mechanism, Disturbance) and mechanism.place not in places_of_base():
        Rest(spec).motion(mechanism.place)
    if isinstance(mechanism, ChannelFault):
        there = [element.name for element in (*spec.sensors, *spec.actuators) if element.name]
        for channel in mechanism.channels:
            if not {channel, split_axis(channel)[0]} & set(there):
                raise ModelError(f"no channel '{channel}'; there are {available(there)}")
