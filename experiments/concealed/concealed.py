"""What a table's rule has drawn."""

from __future__ import annotations

from dataclasses import dataclass

from .mechanisms import Mechanism


@dataclass(frozen=True)
class Concealed:
    """Effects with their strengths.

    Attributes:
        effects: what is concealed.
        effect: the largest change of a training recording's outputs, as a share of their RMS.
        evidence: by name, what the rule weighed [nats, or shares].
    """

    effects: tuple[Mechanism, ...] = ()
    effect: float = 0.0
    evidence: tuple[tuple[str, float], ...] = ()
