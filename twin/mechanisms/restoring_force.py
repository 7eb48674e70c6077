"""A force law without a name: any smooth function of drift and rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import FAR, Line
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import peak, rms
from twin.parameter import Parameter

KNOTS = (0.04, 0.1, 0.2, 0.45, 0.7)
"""Where the law may bend, to either side, as shares of the largest drift, which a hit makes several
times as large as what follows."""

BENDS = ("innermost", "inner", "near", "middle", "far")


def law(
    drift: Any,
    rate: Any,
    memory: Any,
    time: Any,
    linear: Any,
    square: Any,
    cube: Any,
    innermost: Any,
    inner: Any,
    near: Any,
    middle: Any,
    far: Any,
    innermost_left: Any,
    inner_left: Any,
    near_left: Any,
    middle_left: Any,
    far_left: Any,
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
    force = force + innermost * np.maximum(x - KNOTS[0], 0.0) / (1 - KNOTS[0])
    force = force + inner * np.maximum(x - KNOTS[1], 0.0) / (1 - KNOTS[1])
    force = force + near * np.maximum(x - KNOTS[2], 0.0) / (1 - KNOTS[2])
    force = force + middle * np.maximum(x - KNOTS[3], 0.0) / (1 - KNOTS[3])
    force = force + far * np.maximum(x - KNOTS[4], 0.0) / (1 - KNOTS[4])
    force = force + innermost_left * np.minimum(x + KNOTS[0], 0.0) / (1 - KNOTS[0])
    force = force + inner_left * np.minimum(x + KNOTS[1], 0.0) / (1 - KNOTS[1])
    force = force + near_left * np.minimum(x + KNOTS[2], 0.0) / (1 - KNOTS[2])
    force = force + middle_left * np.minimum(x + KNOTS[3], 0.0) / (1 - KNOTS[3])
    force = force + far_left * np.minimum(x + KNOTS[4], 0.0) / (1 - KNOTS[4])
    return force + viscous * v + drag * v * np.abs(v)


@dataclass(frozen=True)
class RestoringForce(Law):
    """f(d, v): a cubic with bends at five drifts to either side, and viscous and square damping.

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
        "innermost": Parameter("N", "beyond 0.04 of the largest drift"),
        "inner": Parameter("N", "beyond 0.1"),
        "near": Parameter("N", "beyond 0.2"),
        "middle": Parameter("N", "beyond 0.45"),
        "far": Parameter("N", "beyond 0.7"),
        "innermost_left": Parameter("N", "beyond -0.04 of the largest drift"),
        "inner_left": Parameter("N", "beyond -0.1"),
        "near_left": Parameter("N", "beyond -0.2"),
        "middle_left": Parameter("N", "beyond -0.45"),
        "far_left": Parameter("N", "beyond -0.7"),
        "viscous": Parameter("N", "linear in the rate, at the RMS rate"),
        "drag": Parameter("N", "in rate times its magnitude, at the RMS rate"),
    }
    reference: ClassVar[str] = "Masri and Caughey 1979"

    linear: float = 0.0
    square: float = 0.0
    cube: float = 0.0
    innermost: float = 0.0
    inner: float = 0.0
    near: float = 0.0
    middle: float = 0.0
    far: float = 0.0
    innermost_left: float = 0.0
    inner_left: float = 0.0
    near_left: float = 0.0
    middle_left: float = 0.0
    far_left: float = 0.0
    viscous: float = 0.0
    drag: float = 0.0
    reach: float = 1e-2
    speed: float = 1e-1
    scale: float = 1.0

    law = staticmethod(law)

    def scaled(self, factor: float) -> Self:
        """Return the law with all its forces ``factor`` times as large."""
        return self._times(factor, *self.parameters)

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
        for side, suffix in ((1, ""), (-1, "_left")):
            for knot, bend_name in zip(KNOTS, BENDS, strict=True):
                name = bend_name + suffix
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
