"""One palette for figures and Rerun: Okabe and Ito's, told apart by colour-blind readers too."""

from __future__ import annotations

MEASURED = "#56B4E9"
IDENTIFIED = "#E69F00"
TRUE = "#009E73"
FORCE = "#CC79A7"
REJECTED = "#999999"
FRAME = "#B8C4D0"
GROUND = "#6B7480"
LOCATED = "#D55E00"

SERIES = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#F0E442")
"""For what comes in any number: outputs, modes."""


def measured_and_identified(number: int, count: int) -> tuple[str, str]:
    """Return the colours of an output's measured and identified response.

    Of one or two outputs the house's; of several each has a colour of its own, and points are told
    from lines.
    """
    own = SERIES[number % len(SERIES)]
    return (MEASURED, IDENTIFIED) if count <= 2 else (own, own)


def rgb(colour: str) -> tuple[int, int, int]:
    """Return "#56B4E9" as (86, 180, 233)."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
