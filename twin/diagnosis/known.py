"""What the user's model holds beyond linear equations, its values with priors about the model's.

A friction or a cubic spring that is written in the model is known about as well as a damping is:
the value is a number that is estimated, and the law no more exact than any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.scales import Scales
from twin.estimation.model import Unknown
from twin.mechanisms.mechanism import Law, Mechanism

Array = NDArray[np.float64]

RESOLVED, RESOLVED_DEVIATION = 0.02, 1.5
"""Share of the rate at its port below which an estimate does not resolve a corner, and the prior
deviation of its logarithm: a factor of four and a half either way."""

TOLD = 3.0
"""Standard deviations beyond which a value that differs from the model's is worth a word."""


@dataclass(frozen=True)
class OfKnown:
    """A value of a mechanism that the model holds: of which one, which parameter, the unknown."""

    of: int
    parameter: str
    unknown: Unknown


def unknowns_of(
    known: Sequence[Mechanism], share: float, scales: Scales | None = None
) -> tuple[OfKnown, ...]:
    """Return the values that are not known exactly.

    How sharply an estimate resolves a corner is not in the model: that lies about a fiftieth of
    the rate there, as widely as for a law that is found.

    Args:
        known: what the model holds.
        share: prior deviation of each value, as a share of it.
        scales: of the motion at the laws' ports.
    """
    out = []
    for index, mechanism in enumerate(known):
        linear = {*mechanism.shares, *(whole for whole, _, _ in mechanism.shares.values())}
        for name, parameter in mechanism.parameters.items():
            value = float(mechanism.values[name])
            if name in mechanism.shares or not value:
                continue  # a share goes with its whole, and a share of nothing is nothing
            log = parameter.scale == "log" and value > 0
            mean, deviation = (float(np.log(value)), share) if log else (value, share * abs(value))
            if isinstance(mechanism, Law) and name == mechanism.resolved_by and scales is not None:
                rate = scales.at(mechanism.place)[2]
                mean, deviation = float(np.log(RESOLVED * rate)), RESOLVED_DEVIATION
            role: Literal["law", "system"] = "system"
            if isinstance(mechanism, Law) and name not in linear:
                role = "law"
            title = f"known {index + 1} {mechanism.name} {mechanism.place} {name}"
            out.append(OfKnown(index, name, Unknown(title, mean, deviation, log, role)))
    return tuple(out)


def valued(
    known: Sequence[Mechanism], unknowns: Sequence[OfKnown], z: Array
) -> tuple[Mechanism, ...]:
    """Return what the model holds at values z of its unknowns, (u,).

    What one of its values is a share of takes that value along.
    """
    given: list[dict[str, float]] = [{} for _ in known]
    for own, x in zip(unknowns, z, strict=True):
        given[own.of][own.parameter] = own.unknown.value(float(x))
    out = []
    for mechanism, values in zip(known, given, strict=True):
        for name, (whole, _, _) in mechanism.shares.items():
            if values.get(whole):
                ratio = mechanism.values[name] / mechanism.values[whole]
                values[name] = ratio * values[whole]
        out.append(mechanism.with_values(values))
    return tuple(out)


def differences(known: Sequence[Mechanism], valued: Sequence[Mechanism]) -> tuple[Mechanism, ...]:
    """Return what estimates add to laws of one strength, whose forces add up.

    Args:
        known: what the model holds.
        valued: the same with the estimates.
    """
    out = []
    for before, after in zip(known, valued, strict=True):
        if isinstance(before, Law) and len(before.parameters) == 1:
            (name,) = before.parameters
            change = float(after.values[name]) - float(before.values[name])
            if change:
                out.append(before.with_values({name: change}))
    return tuple(out)


def shifts(
    known: Sequence[Mechanism], unknowns: Sequence[OfKnown], z: Array, std: Array
) -> tuple[str, ...]:
    """Say which of the model's values the recordings put elsewhere, beyond their deviation.

    Args:
        known: what the model holds.
        unknowns: their values.
        z: estimates, in prior deviations, (u,).
        std: their standard deviations, (u,).
    """
    lines = []
    for own, x, spread in zip(unknowns, z, std, strict=True):
        mechanism, unknown = known[own.of], own.unknown
        resolved = isinstance(mechanism, Law) and own.parameter == mechanism.resolved_by
        if resolved or abs(x) < TOLD * spread:
            continue
        value = unknown.value(float(x))
        slope = unknown.deviation * (abs(value) if unknown.log else 1.0)
        unit = mechanism.parameters[own.parameter].unit
        lines.append(
            f"{mechanism.name} at {mechanism.place}, which the model holds: {own.parameter} "
            f"{value:.4g} +- {slope * spread:.2g} {unit} by the recordings, "
            f"{mechanism.values[own.parameter]:.4g} in the model"
        )
    return tuple(lines)
