"""The unknowns of a mechanism, and the mechanism at values of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from twin.estimation.model import Unknown
from twin.mechanisms.mechanism import ChannelFault, Law, Mechanism


def unknowns_of(mechanism: Mechanism, priors: Mapping[str, tuple[float, float]]) -> list[Unknown]:
    """Return the unknowns of a mechanism, in the order of its parameters.

    Args:
        mechanism: at any values.
        priors: mean and deviation of each parameter, or of its logarithm.
    """
    role: Any = "law" if isinstance(mechanism, Law) else "system"
    if isinstance(mechanism, ChannelFault) and mechanism.in_samples:
        role = "samples"
    # what a law takes over of the structure's stiffness, a share of its own, is linear
    linear = {*mechanism.shares, *(whole for whole, _, _ in mechanism.shares.values())}
    out = []
    for name, parameter in mechanism.parameters.items():
        mean, deviation = priors[name]
        title = f"{mechanism.name} {mechanism.place} {name}"
        own: Any = "system" if name in linear else role
        out.append(Unknown(title, mean, deviation, parameter.scale == "log", own))
    return out


def mechanism_at(mechanism: Mechanism, values: Iterator[float]) -> Mechanism:
    """Return a mechanism at the next values of its unknowns."""
    out = {name: next(values) for name in mechanism.parameters}
    for name, (whole, _, _) in mechanism.shares.items():
        out[name] *= out[whole]
    return mechanism.with_values(out)
