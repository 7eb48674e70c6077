"""Slip that begins at any displacement: rubber, wire rope, bolted joints, soil."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import Line, step_finely
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import TINY, peak
from twin.parameter import Parameter

SLIDERS, RATIO, FARTHEST = 6, 3.0, 2.0
"""Sliders, ratio of one's drift at yield to the next one's, and the largest one over the reach: the
curve of first loading is met within 4 % from a hundredth of the reach to twice the reach."""

PART = 0.05
"""Share of a storey's stiffness that is most likely to slip, give or take a factor of seven."""


def law(drift: Any, rate: Any, memory: Any, time: Any, elastic: Any, *sliders: Any) -> Any:
    """Return the sum of the sliders' forces and of what never slips [N]."""
    return memory + elastic * drift


def flow(memory: Any, part: Any, before: Any, after: Any, elastic: Any, *sliders: Any) -> Any:
    """Return the force of one slider after the drift went from ``before`` to ``after``."""
    stiffness, limit = sliders[int(part)], sliders[int(part) + SLIDERS]
    force = memory + stiffness * (after - before)
    return np.minimum(np.maximum(force, -limit), limit)


@dataclass(frozen=True)
class Microslip(Law):
    """f = sum_i z_i + elastic d: elasto-plastic sliders in parallel, z_i' = k_i v to |z_i| = y_i.

    Together they follow, at first loading, d / reach = (f / (stiffness reach))^(1 + softening): the
    stiffness falls, and the loss of a cycle grows, with a power of the amplitude, and from one
    reversal to the next the curve is the same, twice as large (Masing's rule). There is no yield
    force. With ``replaced`` = ``stiffness`` the storey's own stiffness slips.

    Attributes:
        reach: drift [m] at which the stiffness is stated; not fitted.
        storey_stiffness: of the storey [N/m], for what is plausible; not fitted.

    Source: Masing 1926; Ramberg and Osgood 1943; Iwan 1966; Segalman 2005.
    """

    name: ClassVar[str] = "microslip"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {
        "stiffness": Parameter("N/m", "force over drift, at the reach", "log"),
        "softening": Parameter("1", "power of the force that the drift grows with, less 1", "log"),
        "replaced": Parameter("N/m", "of the storey's own stiffness that slips"),
    }
    reference: ClassVar[str] = "Masing 1926; Ramberg and Osgood 1943; Iwan 1966; Segalman 2005"
    mjcf: ClassVar[str] = (
        "MuJoCo lets a spring yield once a step: slips that are no longer than what moves in one "
        "are those of a dashpot"
    )
    memory: ClassVar[int] = SLIDERS
    valleys: ClassVar[int] = 2  # how much of it is a spring
    shares: ClassVar = {"replaced": ("stiffness", 1.0, 0.5)}  # most likely the storey's own part

    stiffness: float = 0.0
    softening: float = 0.5
    replaced: float = 0.0
    reach: float = 1.0
    storey_stiffness: float = 1e3

    law = staticmethod(law)
    flow = staticmethod(flow)

    def scaled(self, factor: float) -> Self:
        """Return what carries ``factor`` times as much at the same drifts."""
        return self._times(factor, "stiffness", "replaced")

    @property
    def numbers(self) -> tuple[Any, ...]:
        """What never slips [N/m], less what it replaces; stiffnesses and yield forces."""
        elastic, sliders = self.sliders()
        stiffnesses, yields = zip(*sliders, strict=True)
        return (elastic - self.replaced, *stiffnesses, *yields)

    def sliders(self) -> tuple[Any, list[tuple[Any, Any]]]:
        """Return the stiffness that never slips [N/m], and those and yield forces of the sliders.

        The curve of first loading becomes a polygon; each corner of it is a slider that yields
        there (Iwan 1966). Beyond the last corner it goes straight on.
        """
        drifts = FARTHEST * RATIO ** np.arange(1.0, -SLIDERS, -1.0)[::-1]  # over the reach
        forces = [self.stiffness * d ** (1 / (1 + self.softening)) for d in drifts]
        steps = np.diff(drifts, prepend=0.0)
        slopes = [forces[0] / steps[0]]
        slopes += [(b - a) / s for a, b, s in zip(forces, forces[1:], steps[1:], strict=False)]
        yielding = zip(slopes, slopes[1:], drifts, strict=False)
        return slopes[-1], [(a - b, (a - b) * d * self.reach) for a, b, d in yielding]

    def priors(self) -> dict[str, tuple[float, float]]:
        """A part of the storey slips, most likely its own, from a thousandth of it to all of it.

        The drift grows with the 1.5th power of the force, or with the 1.2th to the 2.4th.
        """
        part = float(np.log(PART * self.storey_stiffness))
        own = max(self.stiffness, TINY)
        return {
            "stiffness": (part, 2.0),
            "softening": (float(np.log(0.5)), 1.0),
            "replaced": (own, 0.5 * own),
        }

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add elasto-plastic tendons along the drift, and one that changes the stiffness."""
        line = Line.of(spec, self.place)
        elastic, sliders = self.sliders()
        if self.stiffness:
            for number, (stiffness, yield_force) in enumerate(sliders, start=1):
                slider = line.tendon(f"{self.name}_{number}")
                slider.stiffness = [stiffness, 0.0, 0.0]
                slider.springyield = yield_force / stiffness  # as a drift
            step_finely(spec)
        line.tendon(self.name).stiffness = [elastic - self.replaced, 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return what slips little and much."""
        k = 0.3 * around.stiffness
        return tuple(
            cls(place, k, softening, k, peak(around.drift), around.stiffness)
            for softening in (0.2, 0.5, 1.0)
        )
