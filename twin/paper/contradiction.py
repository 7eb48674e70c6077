"""What a contradiction is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Figure:
    """A number that a derivation rests on, computed from the printed ones."""

    name: str
    value: float
    unit: str = ""


@dataclass(frozen=True)
class Contradiction:
    """Statements of the paper that cannot all be right.

    Attributes:
        id: N for numbers against numbers, E for equations, W for words against numbers.
        title: the contradiction in one line.
        equations: where the statements stand.
        derivation: why they exclude each other.
        figures: the numbers of the derivation.
    """

    id: str
    title: str
    equations: tuple[str, ...]
    derivation: str
    figures: tuple[Figure, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "derivation", " ".join(self.derivation.split()))

    def figure(self, name: str) -> float:
        """Return one figure's value. Raises KeyError, listing the names there are."""
        for figure in self.figures:
            if figure.name == name:
                return figure.value
        raise KeyError(f"no figure '{name}' in {self.id}; it has {[f.name for f in self.figures]}")

    def to_dict(self) -> dict[str, Any]:
        """Return the contradiction as plain types for JSON."""
        return {
            "id": self.id,
            "title": self.title,
            "equations": list(self.equations),
            "derivation": self.derivation,
            "figures": {f.name: {"value": f.value, "unit": f.unit} for f in self.figures},
        }
