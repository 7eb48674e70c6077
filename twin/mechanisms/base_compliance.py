"""A base that is not fast: the table gives way under the frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import mujoco
import numpy as np

from twin.errors import ModelError
from twin.mechanisms.edits import BASE_JOINT, body_of, follow, set_mass
from twin.mechanisms.mechanism import StructuralChange, Surroundings
from twin.parameter import Parameter
from twin.second_order import SecondOrderModel


@dataclass(frozen=True)
class BaseCompliance(StructuralChange):
    """A spring and a dashpot from the ground to the world; an infinite stiffness is a fast base.

    The clamped model has no coordinate for the ground. Its forces do not change when all moves
    together, which gives the ground's rows: K_gx = -1^T K, K_gg = 1^T K 1 + stiffness. Mass between
    the ground and the first floor counts as the floor's.

    Attributes:
        expected_mass: of the ground in the model [kg], or NaN; not fitted.

    Source: sway of a foundation, Wolf 1985.
    """

    name: ClassVar[str] = "base_compliance"
    verdict: ClassVar = "missing_physics"
    where: ClassVar = "ground"
    parameters: ClassVar = {
        "stiffness": Parameter("N/m", "of the base's support", "log"),
        "damping": Parameter("N s/m", "of the base's support", "log"),
        "mass": Parameter("kg", "that moves with the ground, all of it", "log"),
    }
    reference: ClassVar[str] = "Wolf 1985, Dynamic Soil-Structure Interaction"
    stage: ClassVar[int] = 0
    valleys: ClassVar[int] = 8
    steps: ClassVar[int] = 12  # a softer base is very nearly a softer storey

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

    def edit(self, model: SecondOrderModel) -> SecondOrderModel:
        """Return the matrices with the coordinate "ground", before the pendulum's.

        Raises:
            ModelError: the ground moves already, or the place is another.
        """
        if self.place != "ground":
            raise ModelError(f"no place '{self.place}' for {self.name}; there is ground")
        if "ground" in model.coordinates:
            raise ModelError(f"{self.name}: the ground moves already, on a support of its own")
        n = len(model.coordinates)
        at = model.coordinates.index("pendulum") if "pendulum" in model.coordinates else n
        together = np.array([float(c != "pendulum") for c in model.coordinates])
        relative = np.insert(np.eye(n), at, -together, axis=1)
        own = np.zeros(n + 1)
        own[at] = 1.0
        M = np.insert(np.insert(model.M, at, 0.0, axis=0), at, 0.0, axis=1)
        return SecondOrderModel(
            M + self.mass * np.outer(own, own),
            relative.T @ model.R @ relative + self.damping * np.outer(own, own),
            relative.T @ model.K @ relative + self.stiffness * np.outer(own, own),
            (*model.coordinates[:at], "ground", *model.coordinates[at:]),
        )

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Put the body ``ground`` on a slide, on top of the clamp or the drive that holds it."""
        if self.place != "ground":
            raise ModelError(f"no place '{self.place}' for {self.name}; there is ground")
        ground = body_of(spec, "ground")
        if np.isinf(self.stiffness):
            return
        held = spec.joint("ground")
        if held is not None and not held.armature:
            if spec.equality("clamp") is None:
                raise ModelError(f"{self.name}: the ground moves already, on a support of its own")
            held.armature = 1.0  # two slides in one body: without it the mass matrix is singular
        set_mass(spec, ground, total=self.mass)
        joint = ground.add_joint(name=BASE_JOINT, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
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
