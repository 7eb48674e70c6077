"""The ledger: every printed number, ours beside it, and whether the two agree."""

from __future__ import annotations

from functools import cache

from twin.paper import control_entries, frame_entries, identified_entries
from twin.paper.entry import Entry

__all__ = ["Entry", "ledger"]


@cache
def ledger(seed: int = 0) -> tuple[Entry, ...]:
    """Return all entries, in the order of the paper; ``seed`` is that of the noise in (57)."""
    return (
        *frame_entries.entries(),
        *identified_entries.entries(),
        *control_entries.entries(seed),
    )
