"""Every contradiction found in the paper, with its derivation."""

from __future__ import annotations

from functools import cache

from twin.paper import (
    equation_contradictions,
    identification_contradictions,
    structure_contradictions,
)
from twin.paper.contradiction import Contradiction, Figure

__all__ = ["Contradiction", "Figure", "contradictions"]


@cache
def contradictions() -> tuple[Contradiction, ...]:
    """Return all contradictions: numbers (N), equations (E), words against numbers (W)."""
    return (
        *identification_contradictions.found(),
        *structure_contradictions.found(),
        *equation_contradictions.found(),
    )
