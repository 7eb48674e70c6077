"""Units of parameters at ports that slide and at ports that turn."""

from __future__ import annotations

import re

_POWER = re.compile(r"^(?P<unit>[A-Za-z]+)(?:\^(?P<power>[0-9]+))?$")
_TURNED = {"N": "N m", "m": "rad", "kg": "kg m^2"}


def of_port(unit: str, written: str, port: str) -> str:
    """Return a unit, written for ports of one kind, for a port of another.

    Args:
        unit: products and one quotient of units ("N s/m"); other text stays as it is.
        written: "m" or "rad", what the unit was written for.
        port: "m" or "rad", what it is wanted for.

    >>> of_port("N s^2/m^2", "m", "rad")
    'N m s^2/rad^2'
    """
    if written == port:
        return unit
    parts = [part.split() for part in unit.split("/")]
    if any(_POWER.match(factor) is None for part in parts for factor in part):
        return unit
    return "/".join(_part(part, port == "rad") for part in parts)


def _part(factors: list[str], turns: bool) -> str:
    if turns:
        return " ".join(_turned(factor) for factor in factors)
    text = " ".join(factors)
    for slid, turned in _TURNED.items():
        if slid != "m":
            text = text.replace(turned, slid)
    return text.replace("rad", "m")


def _turned(factor: str) -> str:
    match = _POWER.match(factor)
    assert match is not None
    if match["unit"] in _TURNED and match["power"] and match["unit"] == "m":
        return f"rad^{match['power']}"
    return _TURNED.get(factor, factor)
