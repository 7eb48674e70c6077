"""Units of measured channels, converted to SI."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from twin.errors import RecordingError
from twin.quantity import KIND_NAMES, KIND_OF_UNIT, OTHER, QUANTITIES, SI_UNIT

SI = {**SI_UNIT, "time": "s"}
"""The SI unit of each kind of column."""

EXAMPLES = {**{kind: q.examples for kind, q in QUANTITIES.items()}, "time": "[s], [ms]"}
"""Units to suggest for each kind of column."""

_NAME_AND_UNIT = re.compile(r"^(.*?)\s*\[([^\[\]]*)\]$", re.DOTALL)
_GRAVITY = re.compile(r"^(m|µ|μ|u)?g[n0]?$")
_STRAIN = re.compile(r"^(?:[mnuµμ]?m/m|in/in|[uµμ]?(?:strain|ε)|[uµμ]e|microstrain)$")
_SPELLINGS = {
    **{"Nm": "N m", "N-m": "N m", "Nmm": "N mm", "N-mm": "N mm", "lbf-in": "lbf in"},
    **{f"{u}{e}": "microstrain" for u in "uµμ" for e in "eε"},
    **{"Volt": "volt", "Volts": "volt", "-": ""},
}
_OFFSET = ("degC", "°C", "degF", "°F")
_LONGEST = 40


def split_name(text: str) -> tuple[str, str | None]:
    """Split "acc_floor1 [m/s^2]" into name and unit; the unit is None where there is none."""
    match = _NAME_AND_UNIT.match(text.strip())
    return (match[1], match[2].strip()) if match else (text.strip(), None)


def si_factor(unit: str, kind: str, where: str) -> float:
    """Return what a value in ``unit`` is multiplied by to be in SI.

    Args:
        unit: as written between the brackets, such as "mm/s^2"; "g" and "mg" of an acceleration
            are standard gravity (9.80665 m/s^2) and a thousandth of it, not grams.
        kind: one of ``twin.quantity``, or time.
        where: what carries the unit ("test.csv: column 'a'"), the start of an error message.

    Raises:
        RecordingError: an unknown unit, or one of another quantity.
    """
    if unit == SI[kind]:
        return 1.0  # the usual case does not wait for pint
    quantity = KIND_NAMES.get(kind, kind)
    hint = f"units of {quantity} are written as {EXAMPLES[kind]}"
    parsed = _parse(_spelled(unit, kind))
    if parsed is None:
        raise RecordingError(f"{where}: unknown unit {shown(unit, brackets=True)}; {hint}")
    factor, base = parsed
    expected_factor, expected_base = _parse(_spelled(SI[kind], kind)) or (1.0, None)
    if base != expected_base:
        raise RecordingError(
            f"{where}: the unit {shown(unit, brackets=True)} is not one of {quantity}; {hint}"
        )
    return factor / expected_factor


def quantity_of(unit: str, where: str) -> tuple[str, str, float]:
    """Return what a unit says of a column: kind, SI unit and the factor to it.

    Args:
        unit: as written between the brackets; "g" and "mg" are accelerations, not masses.
        where: what carries the unit, the start of an error message.

    Returns:
        The kind ("other" for a quantity without a name of its own), the SI unit, the factor.

    Raises:
        RecordingError: an unknown unit.
    """
    if unit in KIND_OF_UNIT:
        return KIND_OF_UNIT[unit], unit, 1.0
    if _GRAVITY.match(unit):
        return "acc", SI["acc"], si_factor(unit, "acc", where)
    if unit in _OFFSET:
        return OTHER, unit, 1.0  # a temperature is not converted by a factor
    parsed = _parse(_spelled(unit, ""))
    if parsed is None:
        raise RecordingError(
            f"{where}: unknown unit {shown(unit, brackets=True)}; units are written as [N], "
            "[m/s^2], [g], [mm], [rad], [V], [1]"
        )
    factor, base = parsed
    for kind in SI_UNIT:
        if kind not in ("strain", "number") and base == _base_of(kind):
            return kind, SI[kind], si_factor(unit, kind, where)
    text = f"{base:~C}".replace("**", "^")
    if not text:
        kind = "strain" if _STRAIN.match(unit) else "number"
        return kind, SI[kind], factor
    return OTHER, text, factor


def is_unit(text: str) -> bool:
    """Return whether this is a unit of anything."""
    try:
        quantity_of(text, "")
    except RecordingError:
        return False
    return True


def _spelled(unit: str, kind: str) -> str:
    """Return a unit as pint spells it."""
    if kind == "acc" and _GRAVITY.match(unit):
        prefix = {"m": "milli", "g": ""}.get(unit[0], "micro")
        return f"{prefix}standard_gravity"
    return _SPELLINGS.get(unit, unit)


@cache
def _base_of(kind: str) -> Any:
    return (_parse(SI[kind]) or (1.0, None))[1]


def shown(text: str, brackets: bool = False) -> str:
    """Return foreign text so that it fits into a one-line message: short, printable, quoted."""
    plain = "".join(c if c.isprintable() else "?" for c in text)
    short = plain if len(plain) <= _LONGEST else plain[: _LONGEST - 3] + "..."
    return f"[{short}]" if brackets else f"'{short}'"


def _parse(unit: str) -> tuple[float, Any] | None:
    """Return (factor to base units, base units), or None for what is no unit."""
    if len(unit) > _LONGEST or (not unit.strip() and unit != ""):
        return None
    registry = _registry()
    try:
        # "m/s2", as many analysers write it
        parsed = registry.parse_units(re.sub(r"\bs2\b", "s^2", unit))
        factor, base = registry.get_base_units(parsed)
        return float(factor), base
    except Exception:  # pint answers damaged text with a dozen kinds of exception
        return None


@cache
def _registry() -> Any:
    import pint  # 0.3 s: only recordings that are not in SI pay for it

    return pint.UnitRegistry()
