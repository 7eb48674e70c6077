"""Times of day and dates as measuring programs print them, as seconds."""

from __future__ import annotations

import re
from datetime import datetime, timedelta

DAY_S = 86400.0

_CLOCK = re.compile(r"^(?:(?P<date>[0-9]{4}-[0-9]{2}-[0-9]{2})[T ])?"
                    r"(?P<h>[0-9]{1,2}):(?P<m>[0-9]{2}):(?P<s>[0-9]{2}(?:[.,][0-9]+)?)"
                    r"(?P<zone>Z|[+-][0-9]{2}:?[0-9]{2})?$")  # fmt: skip


def is_clock(text: str) -> bool:
    """Return whether this is "12:30:01.25" or "2026-05-01T12:30:01.25Z"."""
    return bool(_CLOCK.match(text.strip()))


def seconds_of(cells: list[str]) -> list[float]:
    """Return the seconds since the first of these times, over midnight where they have no date.

    Raises:
        ValueError: a cell that is no such time, or no date of the calendar.
    """
    found: list[float] = []
    days, origin = 0, None
    for cell in cells:
        match = _CLOCK.match(cell.strip())
        if not match:
            raise ValueError(cell)
        second = float(match["s"].replace(",", "."))
        if int(match["m"]) > 59 or int(match["h"]) > 23 or second >= 61:
            raise ValueError(cell)
        since = 3600.0 * int(match["h"]) + 60.0 * int(match["m"]) + second
        if match["date"]:
            date = datetime.fromisoformat(match["date"])
            origin = origin or date
            since += (date - origin) / timedelta(seconds=1)
        elif found and since + days * DAY_S < found[-1] - DAY_S / 2:
            days += 1
        since += days * DAY_S
        found.append(since)
    return [round(since - found[0], 9) for since in found] if found else []
