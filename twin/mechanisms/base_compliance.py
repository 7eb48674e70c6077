"""A base that is not fast: the table gives way under the frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.base import axis_of, base_body, free_base
from twin.mechanisms.edits import follow
from twin.mechanisms.mechanism import Model, StructuralChange, Surroundings
from twin.parameter import Parameter


@dataclass(frozen=True)
class BaseCompliance(StructuralChange):
    """A spring and a dashpot from the base to the world, along one axis: "ground", "ground.y".

    The model gets one more coordinate, the base's displacement. The structure's forces do not
    change when all moves together; its inertia does. An infinite stiffness is a fast base.

    Attributes:
        expected_mass: of the ground in the model [kg], or NaN; not fitted.

    Source: sway of a foundation, Wolf 1985.
    """

    name: ClassVar[str] = "base_compliance"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "base"
    parameters: ClassVar = {
        "stiffness": Parameter("N/m", "of the base's support", "log"),
        "damping": Parameter("N s/m", "of the base's support", "log"),
        "mass": Parameter("kg", "that moves with the ground, all of it", "log"),
    }
    reference: ClassVar[str] = "Wolf 1985, Dynamic Soil-Structure Interaction"
    stage: ClassVar[int] = 0
    shifts_resonance: ClassVar[bool] = True
    valleys: ClassVar[int] = 8

    stiffness: float = np.inf
    damping: float = 0.0
    mass: float = 1.0
    expected_mass: float = np.nan

    def priors(self) -> dict[str, tuple[float, float]]:
        """The ground's mass is known from the model, give or take what is bolted to it."""
        if not np.isfinite(self.expected_mass):
            return {}
        return {"mass": (float(np.log(self.expected_mass)), 0.2)}

    def scaled(self, factor: float) -> Self:
        """Return a base ``factor`` times as compliant."""
        return self._times(1 / factor, "stiffness")

    def edit(self, model: Model) -> Model:
        """Return the model with the base's coordinate, named as the place.

        Raises:
            ModelError: the base moves already, or the place is another.
        """
        axis = model.base_axis(self.place)
        return model.on_base(self.place, axis, self.damping, self.stiffness, self.mass)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Put the body that carries everything on a slide, on top of what holds it."""
        axis = axis_of(spec, self.place)
        base_body(spec)
        if np.isinf(self.stiffness):
            return
        joint = free_base(spec, self.mass, axis, self.name)
        joint.stiffness = [self.stiffness, 0.0, 0.0]
        joint.damping = [self.damping, 0.0, 0.0]
        follow(spec, self.mass, self.damping, self.stiffness)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return bases that resonate where something stands out, and from soft to stiff ones."""
        heard = [around.mass * (2 * np.pi * f) ** 2 - around.stiffness for f in around.peaks]
        shares = (1.0, 5.0, 15.0, 25.0, 40.0, 65.0, 110.0, 200.0)
        supports = [(k, 0.01) for k in heard if k > 0]
        supports += [(share * around.stiffness, ratio) for share in shares for ratio in (0.02, 0.1)]
        return tuple(
            cls(place, k, 2 * ratio * (k * around.mass) ** 0.5, around.mass, around.mass)
            for k, ratio in supports
        )
