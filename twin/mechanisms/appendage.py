"""Something that hangs on a structure and swings by itself: a cable tray, a pipe, a loose panel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.edits import Line
from twin.mechanisms.mechanism import Model, StructuralChange, Surroundings
from twin.mechanisms.rest import free_name
from twin.parameter import Parameter

Array = NDArray[np.float64]

LITTLE = 1e-4
"""Share of its inertia that a body has in motions that are of no account."""

NARROW = 0.02
"""Damping ratio of light ones that are looked for at all frequencies: of steel with a cable."""


@dataclass(frozen=True)
class Appendage(StructuralChange):
    """A mass on a spring and a dashpot; adds the coordinate "appendage_PLACE", absolute [m].

    It swings along its port; across it, it does not load the structure. At a port that turns it is
    a flywheel, its mass a moment of inertia.

    Source: the tuned mass of Den Hartog 1934, chapter 3, tuned by nobody.
    """

    name: ClassVar[str] = "appendage"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "motion"
    parameters: ClassVar = {
        "mass": Parameter("kg", "mass that swings", "log"),
        "frequency": Parameter("Hz", "its own, its support held fast", "log"),
        "damping_ratio": Parameter("1", "its own, its support held fast", "log"),
    }
    valleys: ClassVar[int] = 7  # one at every frequency
    reference: ClassVar[str] = "Den Hartog 1934, Mechanical Vibrations"
    stage: ClassVar[int] = 2

    mass: float = 0.0
    frequency: float = 1.0
    damping_ratio: float = 0.01

    @property
    def stiffness(self) -> float:
        """Of the spring [N/m]."""
        return (2 * np.pi * self.frequency) ** 2 * self.mass

    @property
    def damping(self) -> float:
        """Of the dashpot [N s/m]."""
        return 4 * np.pi * self.frequency * self.damping_ratio * self.mass

    def edit(self, model: Model) -> Model:
        """Return the model with one more coordinate, the last."""
        label = f"{self.name}_{self.place}"
        return model.hanging(label, self.place, self.mass, self.damping, self.stiffness)

    def light(self, frequencies: Sequence[float]) -> tuple[Self, ...]:
        """Return it with narrow resonances at frequencies [Hz]."""
        return tuple(replace(self, frequency=f, damping_ratio=NARROW) for f in frequencies)

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add a body that moves in the world, held to the port by a tendon.

        It slides along the port; where nothing does as a whole, as in a drift, it turns.
        """
        line = Line.of(spec, self.place)
        if not self.mass:
            return
        label = free_name(f"{self.name}_{self.place}", {body.name for body in spec.bodies})
        slides = bool(np.any(line.motion.along))
        weight = self.mass if slides else LITTLE * self.mass
        size = [LITTLE * self.mass if slides else self.mass] * 3
        body = spec.worldbody.add_body(name=label, mass=weight, inertia=size, gravcomp=1.0)
        body.explicitinertial = True
        body.ipos = [0, 0, 0]
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
        axis = line.motion.along if slides else [1, 0, 0]
        body.add_joint(name=label, type=kind, axis=axis)
        spring = line.tendon(self.name)
        spring.wrap_joint(label, -1.0)
        spring.stiffness = [self.stiffness, 0.0, 0.0]
        spring.damping = [self.damping, 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return light ones: what stands out first, then at and between the frame's modes."""
        own = np.sort(np.asarray(around.natural_frequencies, float))
        between = np.sqrt(own[1:] * own[:-1])
        tuned = np.concatenate([around.peaks, own[:4], between[:3]]) if len(own) else np.ones(1)
        return tuple(
            cls(place, share * around.mass, float(frequency), 0.03)
            for frequency in tuned
            for share in (0.01, 0.05)
        )
