"""Dry friction in the bearing and gear of a joint that a motor drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import add_friction, driven_joint
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter


def law(drift: Any, rate: Any, memory: Any, time: Any, torque: Any, regular_rate: Any) -> Any:
    """Return T tanh(rate / regular_rate) [N m]."""
    return torque * np.tanh(rate / regular_rate)


@dataclass(frozen=True)
class PendulumFriction(Law):
    """Torque = T sign(rate) in a driven joint; as mathematics T tanh(rate/regular_rate).

    Here ``drift`` is the angle [rad] and ``rate`` its rate [rad/s]. The width of the change of sign
    is fitted, as that of ``coulomb_friction`` is.

    Source: Coulomb 1785.
    """

    name: ClassVar[str] = "pendulum_friction"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "actuator"
    port_unit: ClassVar[str] = "rad"
    parameters: ClassVar = {
        "torque": Parameter("N m", "that resists turning", "log"),
        "regular_rate": Parameter("rad/s", "below which an estimate sees it fall off", "log"),
    }
    also_named: ClassVar[str] = "coulomb_friction"
    reference: ClassVar[str] = "Coulomb 1785"
    resolved_by: ClassVar[str] = "regular_rate"
    abrupt: ClassVar[bool] = True
    jumps: ClassVar[bool] = True

    torque: float = 0.0
    regular_rate: float = 1e-3

    law = staticmethod(law)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Give the joint dry friction, over what it has."""
        joint = driven_joint(spec, self.place)
        if self.torque:
            add_friction(spec, joint, float(joint.frictionloss) + self.torque)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return a hundredth of the joint's torque, with a sharp and a blurred change of sign."""
        scale = 0.01 * around.stiffness * rms(around.drift)
        return tuple(cls(place, scale, part * rms(around.rate)) for part in (0.005, 0.02, 0.08))
