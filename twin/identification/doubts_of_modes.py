"""What the identified modes themselves say against their data."""

from __future__ import annotations

import numpy as np

from twin.identification.result import Identification

GRAVITY = 9.80665
"""Readings in g taken for m/s^2, or the reverse, are off by this factor [m/s^2]."""

SLIP = 0.01
"""Probability, before anything is known, that a channel's unit is wrong by that factor."""

SPREAD = 1.0
"""Standard deviation of the logarithm of two masses' ratio in a structure."""

AGAINST = 0.1
"""Share of the largest component that one of the other sign has at least: below, it is a node."""


def doubts_of_modes(found: Identification) -> list[str]:
    """Return one line for each thing that no structure, or hardly one, shows."""
    return [f"warning: {line}" for line in (*_outside(found), *_masses(found), *_signs(found))]


def _outside(found: Identification) -> list[str]:
    """Modes where the records hold nothing: the band's edges attract poles."""
    if found.fit is None:
        return []
    low, high = found.fit.w_min / (2 * np.pi), found.fit.w_max / (2 * np.pi)
    f = found.modal.natural_freq
    width = found.modal.damping_ratio * f
    outside = f[(f + width < low) | (f - width > high)]
    if not len(outside):
        return []
    at = ", ".join(f"{x:.4g}" for x in outside)
    return [
        f"the mode at {at} Hz lies outside the band from {low:.4g} to {high:.4g} Hz that is "
        "excited and analysed: nothing there has been measured"
    ]


def _masses(found: Identification) -> list[str]:
    """Negative masses, and masses so far apart that a slip of a unit is the likelier reason.

    The logarithm of a ratio of masses is taken as normal with standard deviation ``SPREAD``; a
    slip of a unit, of probability ``SLIP``, moves it by twice the logarithm of ``GRAVITY``,
    because a mass that both answers and is answered to enters with its reading squared.
    """
    if found.second_order is None:
        return []
    mass = np.diag(found.second_order.M)
    places = found.second_order.coordinates
    lines = [
        f"acc_{place}: the mass at {place} comes out negative: force and acceleration there "
        "disagree in sign, one of them is reversed"
        for place, m in zip(places, mass, strict=True)
        if m <= 0
    ]
    positive = np.flatnonzero(mass > 0)
    if lines or len(positive) < 2:
        return lines
    shift = 2 * np.log(GRAVITY)
    for i in positive:
        z = np.log(mass[i] / np.median(np.delete(mass, i)))
        odds = np.log(SLIP) + (z**2 - (abs(z) - shift) ** 2) / (2 * SPREAD**2)
        if odds > 0:
            size, unit = ("larger", "small") if z > 0 else ("smaller", "large")
            lines.append(
                f"acc_{places[i]}: the mass at {places[i]} comes out {np.exp(abs(z)):.3g} times "
                f"{size} than elsewhere: unless it is, the readings are too {unit} by about 9.81 "
                "(g for m/s^2) against the other channels"
            )
    return lines


def _signs(found: Identification) -> list[str]:
    """Sensors that move against the others in the lowest mode of a structure that stands.

    Of springs between masses that all move one way the lowest mode has one sign (Perron and
    Frobenius: the flexibility has no negative entry).
    """
    if found.second_order is None or len(found.outputs) < 2:
        return []
    if np.linalg.eigvalsh(found.second_order.K).min() <= 0:
        return []
    shape = found.modal.mode_shape[:, int(np.argmin(found.modal.natural_freq))]
    turned = np.real(shape / shape[int(np.argmax(np.abs(shape)))])
    driven = [f"acc_{n.partition('_')[2]}" for n in found.inputs]
    known = [i for i, n in enumerate(found.outputs) if n in driven]
    sign = np.sign(turned[known[0]]) if known else np.sign(np.sum(turned))
    against = [n for n, x in zip(found.outputs, sign * turned, strict=True) if x < -AGAINST]
    if not against:
        return []
    return [
        f"{', '.join(against)}: moves against the others in the lowest mode, as no sway of storeys "
        "does: unless the sensors point different ways, its sign is reversed"
    ]
