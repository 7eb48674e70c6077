"""Dry friction in a storey: a joint that slips, a cable that rubs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import Line, add_friction
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


def law(
    drift: Any, rate: Any, memory: Any, time: Any, sliding_force: Any, regular_rate: Any
) -> Any:
    """Return F tanh(v / regular_rate) [N]."""
    return sliding_force * np.tanh(rate / regular_rate)


@dataclass(frozen=True)
class CoulombFriction(Law):
    """f = F sign(v); as mathematics F tanh(v / regular_rate).

    The width of the change of sign is fitted: an estimate cannot resolve the rate below its own
    noise, and smooths the law by as much. The MuJoCo model has the ideal law, which also sticks.

    Attributes:
        sliding_force: F, the parameter ``force`` [N].
        regular_rate: rate below which the force falls off [m/s].

    Source: Coulomb 1785; on a frame, Marino and Cicirello 2023.
    """

    name: ClassVar[str] = "coulomb_friction"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {
        "force": Parameter("N", "F in f = F sign(v)", "log"),
        "regular_rate": Parameter("m/s", "below which an estimate sees it fall off", "log"),
    }
    fields_of: ClassVar = {"force": "sliding_force"}
    reference: ClassVar[str] = "Coulomb 1785; Marino and Cicirello 2023"
    resolved_by: ClassVar[str] = "regular_rate"
    abrupt: ClassVar[bool] = True
    jumps: ClassVar[bool] = True

    sliding_force: float = 0.0
    regular_rate: float = 1e-4

    law = staticmethod(law)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a tendon along the port with dry friction: it sticks as the ideal law does."""
        tendon = Line.of(spec, self.place).tendon(self.name)
        add_friction(spec, tendon, self.sliding_force)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a hundredth of the storey's force, with a sharp and a blurred change of sign."""
        scale = 0.01 * around.stiffness * rms(around.drift)
        return tuple(cls(place, scale, part * rms(around.rate)) for part in (0.005, 0.02, 0.08))
