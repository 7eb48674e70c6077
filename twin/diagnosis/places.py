"""Where this engine looks for each mechanism, on a chain of storeys."""

from __future__ import annotations

from collections.abc import Sequence

from twin import mechanisms
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model.port import GROUND
from twin.place import split_channel
from twin.second_order import PENDULUM, SecondOrderModel

KINDS = ("acc", "disp", "force")
"""Quantities whose instruments it knows."""

UNKNOWN = frozenset(
    {
        "clock",
        "sensor_crosstalk",
        "sensor_drift",
        "sensor_dropout",
        "sensor_hum",
        "sensor_quantisation",
        "sensor_resonance",
        "sensor_spikes",
        "sensor_unexplained",
    }
)
"""Mechanisms that it cannot estimate."""


def places(cls: type[Mechanism], model: SecondOrderModel, channels: Sequence[str]) -> list[str]:
    """Return all places of a chain that a mechanism can be at.

    Args:
        cls: of the mechanism.
        model: M, R, K of the chain.
        channels: of the recordings.
    """
    if cls.name in UNKNOWN:
        return []
    if cls.on == "actuator":
        return [PENDULUM] if PENDULUM in model.coordinates else []
    if issubclass(cls, Disturbance):
        return [*model.places("body"), GROUND]
    if cls.on == "base":
        return [GROUND]
    if cls.on == "motion":
        return list(model.places("body"))
    parts = ((name, split_channel(name)) for name in channels)
    kinds = {name: part[0] for name, part in parts if part is not None and part[0] in KINDS}
    found = mechanisms.places(cls, model, kinds)
    return found if issubclass(cls, ChannelFault) else [p for p in found if p != PENDULUM]
