"""A storey, a column or a joint that is damped more or less than the model says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Model, StructuralChange, Surroundings
from twin.model.dashpots import note_dashpot
from twin.parameter import Parameter


@dataclass(frozen=True)
class Damping(StructuralChange):
    """R += change p p^T along a port p; a dashpot more, or less of one.

    At an absolute motion it is a dashpot to the rest frame (air, a cable): with both kinds any
    change of modal damping of a two-storey frame can be written.

    Source: eqs. (2)-(6).
    """

    name: ClassVar[str] = "damping"
    verdict: ClassVar = "parameter"
    on: ClassVar = "drift"
    parameters: ClassVar = {"change": Parameter("N s/m", "added to the port's damping")}
    reference: ClassVar[str] = "eqs. (2)-(6) of the paper"

    change: float = 0.0

    def edit(self, model: Model) -> Model:
        """Return the model with the damping added."""
        return model.adding(R=self.change, along=model.port(self.place))

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the port with the damping; it is no port of its own."""
        tendon = Line.of(spec, self.place).tendon(self.name)
        tendon.damping = [self.change, 0.0, 0.0]
        note_dashpot(spec, tendon.name)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a few shares of what the port has, less and more."""
        return tuple(cls(place, share * around.damping) for share in (-0.5, 0.5, 2.0))
