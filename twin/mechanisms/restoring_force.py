"""A non-parametric restoring force: any smooth function of drift and rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import FAR, Line
from twin.mechanisms.mechanism import Law, Mechanism, Surroundings
from twin.mechanisms.scales import peak, rms
from twin.parameter import Parameter

KNOTS = (0.012, 0.03, 0.08, 0.2, 0.45, 0.7)
"""Where the law may bend, to either side, as shares of the largest drift. They stand by factors of
about two and a half, for a hit makes the largest drift several times as large as what follows, and
what bends near the middle bends within a small share of it."""

BENDS = tuple(range(1, len(KNOTS) + 1))

BENT = tuple(f"{side}_{bend}" for side in ("right", "left") for bend in BENDS)
"""The terms that no power of drift or rate is, and so no other law."""


def law(
    drift: Any,
    rate: Any,
    memory: Any,
    time: Any,
    linear: Any,
    square: Any,
    cube: Any,
    right_1: Any,
    right_2: Any,
    right_3: Any,
    right_4: Any,
    right_5: Any,
    right_6: Any,
    left_1: Any,
    left_2: Any,
    left_3: Any,
    left_4: Any,
    left_5: Any,
    left_6: Any,
    viscous: Any,
    drag: Any,
    reach: Any,
    speed: Any,
    scale: Any,
) -> Any:
    """Return the sum of all terms, each equal to its parameter at the end of its range [N]."""
    x = drift / reach
    v = rate / speed
    force = linear * x + square * x * x + cube * x * x * x
    force = force + right_1 * np.maximum(x - KNOTS[0], 0.0) / (1 - KNOTS[0])
    force = force + right_2 * np.maximum(x - KNOTS[1], 0.0) / (1 - KNOTS[1])
    force = force + right_3 * np.maximum(x - KNOTS[2], 0.0) / (1 - KNOTS[2])
    force = force + right_4 * np.maximum(x - KNOTS[3], 0.0) / (1 - KNOTS[3])
    force = force + right_5 * np.maximum(x - KNOTS[4], 0.0) / (1 - KNOTS[4])
    force = force + right_6 * np.maximum(x - KNOTS[5], 0.0) / (1 - KNOTS[5])
    force = force + left_1 * np.minimum(x + KNOTS[0], 0.0) / (1 - KNOTS[0])
    force = force + left_2 * np.minimum(x + KNOTS[1], 0.0) / (1 - KNOTS[1])
    force = force + left_3 * np.minimum(x + KNOTS[2], 0.0) / (1 - KNOTS[2])
    force = force + left_4 * np.minimum(x + KNOTS[3], 0.0) / (1 - KNOTS[3])
    force = force + left_5 * np.minimum(x + KNOTS[4], 0.0) / (1 - KNOTS[4])
    force = force + left_6 * np.minimum(x + KNOTS[5], 0.0) / (1 - KNOTS[5])
    return force + viscous * v + drag * v * np.abs(v)


@dataclass(frozen=True)
class RestoringForce(Law):
    """f(d, v): a cubic with bends at six drifts to either side, and viscous and square damping.

    It is what remains when no named law fits: modelled, not explained. Every term is native to
    MJCF: polynomial springs, one-sided springs, polynomial dashpots.

    Attributes:
        reach: largest drift [m]; not fitted.
        speed: RMS rate [m/s]; not fitted.
        scale: force of the storey at the largest drift [N], for what is plausible; not fitted.

    Source: restoring force surface, Masri and Caughey 1979.
    """

    name: ClassVar[str] = "restoring_force"
    verdict: ClassVar = "unexplained"
    on: ClassVar = "drift"
    generic: ClassVar[bool] = True
    parameters: ClassVar = {
        "linear": Parameter("N", "linear in the drift, at the largest drift"),
        "square": Parameter("N", "its square"),
        "cube": Parameter("N", "its cube"),
        "right_1": Parameter("N", f"beyond {KNOTS[0]:g} of the largest drift"),
        "right_2": Parameter("N", f"beyond {KNOTS[1]:g} of the largest drift"),
        "right_3": Parameter("N", f"beyond {KNOTS[2]:g} of the largest drift"),
        "right_4": Parameter("N", f"beyond {KNOTS[3]:g} of the largest drift"),
        "right_5": Parameter("N", f"beyond {KNOTS[4]:g} of the largest drift"),
        "right_6": Parameter("N", f"beyond {KNOTS[5]:g} of the largest drift"),
        "left_1": Parameter("N", f"beyond -{KNOTS[0]:g} of the largest drift"),
        "left_2": Parameter("N", f"beyond -{KNOTS[1]:g} of the largest drift"),
        "left_3": Parameter("N", f"beyond -{KNOTS[2]:g} of the largest drift"),
        "left_4": Parameter("N", f"beyond -{KNOTS[3]:g} of the largest drift"),
        "left_5": Parameter("N", f"beyond -{KNOTS[4]:g} of the largest drift"),
        "left_6": Parameter("N", f"beyond -{KNOTS[5]:g} of the largest drift"),
        "viscous": Parameter("N", "linear in the rate, at the RMS rate"),
        "drag": Parameter("N", "in rate times its magnitude, at the RMS rate"),
    }
    reference: ClassVar[str] = "Masri and Caughey 1979"

    linear: float = 0.0
    square: float = 0.0
    cube: float = 0.0
    right_1: float = 0.0
    right_2: float = 0.0
    right_3: float = 0.0
    right_4: float = 0.0
    right_5: float = 0.0
    right_6: float = 0.0
    left_1: float = 0.0
    left_2: float = 0.0
    left_3: float = 0.0
    left_4: float = 0.0
    left_5: float = 0.0
    left_6: float = 0.0
    viscous: float = 0.0
    drag: float = 0.0
    reach: float = 1e-2
    speed: float = 1e-1
    scale: float = 1.0

    law = staticmethod(law)

    def scaled(self, factor: float) -> Self:
        """Return the law with all its forces ``factor`` times as large."""
        return self._times(factor, *self.parameters)

    def includes(self, other: Mechanism) -> bool:
        """Return whether another one is a force of the same displacement: that is what this is."""
        return isinstance(other, Law) and other.elastic and other.place == self.place

    def priors(self) -> dict[str, tuple[float, float]]:
        """No term is likely to exceed half of what the storey itself carries."""
        return dict.fromkeys(self.parameters, (0.0, 0.5 * self.scale))

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add one tendon for the polynomial and one for each bend."""
        line = Line.of(spec, self.place)
        smooth = line.tendon(self.name)
        r, s = self.reach, self.speed
        smooth.stiffness = [self.linear / r, self.square / r**2, self.cube / r**3]
        smooth.damping = [self.viscous / s, self.drag / s**2, 0.0]
        for side, which in ((1, "right"), (-1, "left")):
            for knot, number in zip(KNOTS, BENDS, strict=True):
                name = f"{which}_{number}"
                force = self.values[name]
                if not force:
                    continue
                bend = line.tendon(f"{self.name}_{name}")
                bend.stiffness = [force / ((1 - knot) * r), 0.0, 0.0]
                low, high = (-FAR, knot * r) if side > 0 else (-knot * r, FAR)
                line.dead_range(bend, low, high)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the law that is nothing yet, scaled to the motion."""
        far = peak(around.drift)
        return (cls(place, reach=far, speed=rms(around.rate), scale=around.stiffness * far),)
