"""Slip that begins at any displacement: rubber, wire rope, bolted joints, soil."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import Line, slip_finely
from twin.mechanisms.hysteresis import PART
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import TINY, peak
from twin.parameter import Parameter

SLIDERS, RATIO, FARTHEST = 12, 1.7, 2.0
"""Sliders, ratio of one's drift at yield to the next one's, and the largest one over the reach: the
curve of first loading is met within 1 % from a hundredth of the reach to twice the reach."""

LOG_RATIO = float(np.log(RATIO))
"""The powers of the ratio are taken by it: with general powers a flow takes twice as long."""

SAME = 1e-6
"""Relative error within which sliders are those of a law: a model's text has more digits."""


def law(
    drift: Any, rate: Any, memory: Any, time: Any, elastic: Any, first: Any, second: Any,
    shortest: Any, power: Any,
) -> Any:  # fmt: skip
    """Return the sum of the sliders' forces and of what never slips [N]."""
    return memory + elastic * drift


def flow(
    memory: Any, part: Any, before: Any, after: Any, elastic: Any, first: Any, second: Any,
    shortest: Any, power: Any,
) -> Any:  # fmt: skip
    """Return the force of one slider after the drift went from ``before`` to ``after``.

    Args:
        memory: its force.
        part: which one it is, from 0 on.
        before: the drift before.
        after: the drift then.
        elastic: stiffness of what never slips.
        first: stiffness of the slider that yields first.
        second: of the next one; each later one's is RATIO^(power - 1) of that before it.
        shortest: drift at which the first one yields.
        power: of the drift that the force of first loading goes with.
    """
    stiffness = first if part < 1 else second * np.exp(LOG_RATIO * (part - 1) * (power - 1))
    limit = stiffness * shortest * np.exp(LOG_RATIO * part)
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
        """Those of ``flow``.

        The curve of first loading becomes a polygon; each corner of it is a slider that yields
        there (Iwan 1966), with the stiffness that the polygon loses. Beyond the last corner it goes
        straight on.
        """
        power, shortest = 1 / (1 + self.softening), FARTHEST / RATIO ** (SLIDERS - 1)
        slope = self.stiffness * shortest ** (power - 1)
        after = slope * (RATIO**power - 1) / (RATIO - 1)
        softer = RATIO ** (power - 1)  # from one side of the polygon to the next
        elastic = after * softer ** (SLIDERS - 1) - self.replaced
        return elastic, slope - after, after * (1 - softer), shortest * self.reach, power

    def sliders(self) -> list[tuple[float, float]]:
        """Return stiffness [N/m] and drift at yield [m] of each slider."""
        _, first, second, shortest, power = self.numbers
        each = range(SLIDERS)
        later = [second * RATIO ** ((i - 1) * (power - 1)) for i in each]
        return [(later[i] if i else first, shortest * RATIO**i) for i in each]

    @classmethod
    def of_sliders(cls, place: str, sliders: Sequence[tuple[float, float]]) -> Self | None:
        """Return what has these sliders and takes the place of their springs, None where none has.

        Args:
            place: their port.
            sliders: stiffness [N/m] and drift at yield [m] of each, in any order.
        """
        if len(sliders) != SLIDERS or min(min(one) for one in sliders) <= 0:
            return None
        (first, _), (second, _), (third, _), *_, (_, longest) = sorted(sliders, key=lambda s: s[1])
        power = 1 + float(np.log(third / second)) / float(np.log(RATIO))
        if not 0 < power < 1:
            return None
        found = cls(place, 1.0, 1 / power - 1, 0.0, longest / FARTHEST)
        found = found.scaled(first / found.sliders()[0][0])
        if not np.allclose(sorted(found.sliders()), sorted(sliders), rtol=SAME, atol=0.0):
            return None
        own = sum(k for k, _ in sliders) + float(found.numbers[0])
        return replace(found, replaced=own, storey_stiffness=own)

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
        if self.stiffness:
            for number, (stiffness, yields) in enumerate(self.sliders(), start=1):
                slider = line.tendon(f"{self.name}_{number}")
                slider.stiffness = [stiffness, 0.0, 0.0]
                slider.springyield = yields
            slip_finely(spec, line, sum(k for k, _ in self.sliders()))
        line.tendon(self.name).stiffness = [self.numbers[0], 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return what slips little and much."""
        k = 0.3 * around.stiffness
        return tuple(
            cls(place, k, softening, k, peak(around.drift), around.stiffness)
            for softening in (0.2, 0.5, 1.0)
        )
