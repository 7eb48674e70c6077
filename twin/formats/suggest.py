"""A guess at what the columns of somebody else's file are, for the user to confirm."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from twin.channel import implied_kind
from twin.formats.table import Column
from twin.quantity import SI_UNIT

_WORDS = (
    ("force", r"force|hammer|load|kraft|impact"),
    ("torque", r"torque|moment"),
    ("acc", r"acc|beschl|vibr"),
    ("strain", r"strain|gauge|dms"),
    ("angle", r"angle|theta|encoder|rot"),
    ("vel", r"vel|speed|geschw"),
    ("disp", r"disp|pos|laser|lvdt|weg"),
    ("voltage", r"volt"),
)
_SHORT = {"F": "force", "f": "force", "a": "acc", "A": "acc", "x": "disp", "M": "torque"}


def suggest_map(columns: Sequence[Column], offered: Mapping[str, str]) -> dict[str, str]:
    """Return column -> "channel [unit]" for the columns whose quantity can be guessed.

    Args:
        columns: of the file.
        offered: the model's channels, name -> kind; {} without a model: a column then keeps its
            name.

    Returns:
        A guess, never more: of channels of one kind the one with the column's number, else the
        next in order.
    """
    found: dict[str, str] = {}
    left = {name: kind for name, kind in offered.items() if "." not in name}
    for column in columns:
        kind = _kind(column)
        if kind is None or column.problem:
            continue
        names = [name for name, each in left.items() if each == kind]
        number = re.findall(r"\d+", column.name)
        same = [n for n in names if number and re.findall(r"\d+", n)[-1:] == number[-1:]]
        name = column.name if column.name in left else next(iter([*same, *names]), None)
        if name is None and offered:
            continue
        left.pop(name or "", None)
        found[column.name] = f"{name or column.name} [{column.unit or SI_UNIT[kind]}]"
    return found


def _kind(column: Column) -> str | None:
    if implied := implied_kind(column.name):
        return implied
    if column.unit:
        from twin.errors import RecordingError
        from twin.units import quantity_of

        try:
            kind = quantity_of(column.unit, "")[0]
        except RecordingError:
            return None
        return kind if kind in SI_UNIT else None
    for kind, words in _WORDS:
        if re.search(words, column.name, re.IGNORECASE):
            return kind
    match = re.fullmatch(r"([A-Za-z])_?\d*", column.name)
    return _SHORT.get(match[1]) if match else None
