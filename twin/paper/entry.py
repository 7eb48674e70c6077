"""One line of the ledger, and how its verdict is found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from decimal import Decimal
from typing import Any

from twin.paper.printed import Array, Printed

GIVEN = "given"
AGREES = "agrees"
CONSISTENT = "consistent"
CUT_OFF = "cut off"
HOLDS = "holds"
CONTRADICTS = "contradicts"
OPEN = "open"
NOT_PRINTED = "not printed"

VERDICTS = {
    GIVEN: "a datum",
    AGREES: "to the printed digits",
    CONSISTENT: "some inputs that round to the printed ones give the printed digits",
    CUT_OFF: "the printed digits are ours, not rounded",
    HOLDS: "an equation recovers what it should",
    CONTRADICTS: "none of these",
    OPEN: "the text does not determine it",
    NOT_PRINTED: "the paper leaves the number out",
}
"""What each verdict means."""


@dataclass(frozen=True)
class Entry:
    """One line of the ledger.

    Attributes:
        equation: where the number or the statement stands.
        quantity: what it is.
        printed: as printed; empty where the paper prints no number.
        ours: recomputed, with one digit more; empty for a datum.
        values: the recomputed number, or the ends of its range; empty for a datum.
        unit: SI unit of both.
        route: what ours is computed from.
        verdict: one of ``VERDICTS``.
        contradictions: ids of the contradictions it takes part in.
        note: what else a reader has to know.
    """

    equation: str
    quantity: str
    printed: str
    ours: str
    values: tuple[float, ...]
    unit: str
    route: str
    verdict: str
    contradictions: tuple[str, ...] = ()
    note: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the entry as plain types for JSON."""
        return asdict(self) | {
            "values": list(self.values),
            "contradictions": list(self.contradictions),
        }


def given(number: Printed, *contradictions: str, note: str = "") -> Entry:
    """Return the entry of a datum."""
    unit = number.unit
    return Entry(
        number.equation, number.symbol, number.text, "", (), unit, "", GIVEN, contradictions, note
    )


def compared(number: Printed, ours: float, route: str, *ids: str, note: str = "") -> Entry:
    """Return the entry of a number that exact data determine: it agrees, is cut off, or neither."""
    missed = CUT_OFF if number.cut_from(ours) else CONTRADICTS
    verdict = AGREES if number.met_by(ours) else missed
    return judged(number, ours, route, verdict, *ids, note=note)


def judged(
    number: Printed, ours: float, route: str, verdict: str, *ids: str, note: str = ""
) -> Entry:
    """Return the entry of a number that rounded numbers determine, with its verdict given."""
    digits = max(len(Decimal(number.text).as_tuple().digits) + 1, 3)
    scientific = "e" in number.text and abs(ours) < 1e-2
    text = f"{ours:.{digits - 1}e}".replace("e-0", "e-") if scientific else f"{ours:.{digits}g}"
    return Entry(
        number.equation,
        number.symbol,
        number.text,
        text,
        (float(ours),),
        number.unit,
        route,
        verdict,
        ids,
        note,
    )


def compared_set(
    numbers: Sequence[Printed], ours: Array, route: str, misfit: float, *ids: str, note: str = ""
) -> list[Entry]:
    """Return the entries of numbers computed together from rounded ones.

    Args:
        numbers: as printed.
        ours: recomputed, in the same order.
        route: what they are computed from.
        misfit: the largest miss that rounding leaves, half units (``rounding.misfit``): at most 1
            where rounding of the inputs explains every difference.
        ids: of the contradictions they take part in.
        note: for the first of them.
    """
    verdict = CONSISTENT if misfit <= 1 else CONTRADICTS
    entries = [
        judged(number, value, route, verdict, *ids)
        for number, value in zip(numbers, ours, strict=True)
    ]
    return [replace(entries[0], note=note), *entries[1:]]
