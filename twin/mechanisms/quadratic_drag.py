"""Drag of what moves in air or water."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


def law(drift: Any, rate: Any, memory: Any, time: Any, coefficient: Any) -> Any:
    """Return c v |v| [N]."""
    return coefficient * rate * np.abs(rate)


@dataclass(frozen=True)
class QuadraticDrag(Law):
    """f = c v |v|, with the velocity v in the world, which moves with a ground that is shaken.

    Source: Newton 1687; in structures, Morison et al. 1950.
    """

    name: ClassVar[str] = "quadratic_drag"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "motion"
    parameters: ClassVar = {"coefficient": Parameter("N s^2/m^2", "c in f = c v |v|", "log")}
    reference: ClassVar[str] = "Newton 1687; Morison et al. 1950"

    coefficient: float = 0.0

    law = staticmethod(law)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the port with a polynomial damping."""
        tendon = Line.of(spec, self.place).tendon(self.name)
        tendon.damping = [0.0, self.coefficient, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return drags of a thousandth to a tenth of the spring force there."""
        scale = around.stiffness * rms(around.drift) / rms(around.rate) ** 2
        return tuple(cls(place, share * scale) for share in (1e-3, 1e-2, 0.1))
