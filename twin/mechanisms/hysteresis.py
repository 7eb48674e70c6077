"""Slip that remembers: bolted joints and braces that yield."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import mujoco
import numpy as np

from twin.mechanisms.edits import Line, step_finely
from twin.mechanisms.mechanism import Law, Surroundings
from twin.mechanisms.scales import TINY, rms
from twin.mechanisms.sliders import as_sliders
from twin.parameter import Parameter

PART = 0.05
"""Share of a storey's stiffness that is most likely to slip, give or take a factor of seven."""

SUBSTEPS = 2
"""Steps of the memory from one drift to the next."""


def law(
    drift: Any,
    rate: Any,
    memory: Any,
    time: Any,
    stiffness: Any,
    yield_force: Any,
    sharpness: Any,
    replaced: Any,
    shape: Any,
    storey: Any,
) -> Any:
    """Return z - replaced d [N]."""
    return memory - replaced * drift


def flow(
    memory: Any,
    part: Any,
    before: Any,
    after: Any,
    stiffness: Any,
    yield_force: Any,
    sharpness: Any,
    replaced: Any,
    shape: Any,
    storey: Any,
) -> Any:
    """Return z after the drift went from ``before`` to ``after``, by midpoint steps.

    No step goes over the plateau; what is there stays, but a neighbour of it on either side may
    move, or its derivatives would be those of another law.
    """
    step = (after - before) / SUBSTEPS
    limit = yield_force * np.maximum(0.5 + shape, 1e-9) ** (-1.0 / sharpness)
    limit = np.maximum(limit, np.abs(memory))
    z = memory
    for _ in range(SUBSTEPS):
        loading = shape + 0.5 * np.sign(step * z)
        slope = 1.0 - np.abs(z / yield_force) ** sharpness * loading
        middle = z + 0.5 * step * stiffness * slope
        middle = np.minimum(np.maximum(middle, -limit), limit)
        loading = shape + 0.5 * np.sign(step * middle)
        slope = 1.0 - np.abs(middle / yield_force) ** sharpness * loading
        z = z + step * stiffness * slope
        z = np.minimum(np.maximum(z, -limit), limit)
    return z


@dataclass(frozen=True)
class Hysteresis(Law):
    """f = z - replaced d, z' = stiffness v (1 - |z/yield_force|^sharpness (shape + sign(v z)/2)).

    The memory is z [N]. It loads along a curve that is the rounder the less the sharpness; with
    the usual shape of 1/2 it unloads along a straight line, and a great sharpness makes it an ideal
    elasto-plastic slider. Its plateau is yield_force (1/2 + shape)^(-1/sharpness); a shape of -1/2
    or less has none and stiffens. With ``replaced`` = ``stiffness`` the storey's own stiffness
    slips.

    Attributes:
        storey_stiffness: of the storey [N/m], for what is plausible; not fitted.

    Source: Bouc 1967, Wen 1976 (there shape = delta / (2 gamma)); a slider, Jenkins 1962.
    """

    name: ClassVar[str] = "hysteresis"
    verdict: ClassVar = "missing_physics"
    on: ClassVar = "drift"
    parameters: ClassVar = {
        "stiffness": Parameter("N/m", "before it slips", "log"),
        "yield_force": Parameter("N", "at which it slips", "log"),
        "sharpness": Parameter("1", "of the bend from one to the other", "log"),
        "replaced": Parameter("N/m", "of the storey's own stiffness that slips"),
        "shape": Parameter("1", "of the loop: 1/2 unloads straight, less rounder, -1/2 stiffens"),
    }
    reference: ClassVar[str] = "Bouc 1967; Wen 1976; Jenkins 1962"
    mjcf: ClassVar[str] = (
        "the loop is that of elasto-plastic sliders in parallel, fitted to the curve of first "
        "loading; its shape is approximated, the better the sharper the bend"
    )
    memory: ClassVar[int] = 1
    valleys: ClassVar[int] = 2  # the drift at which it slips
    abrupt: ClassVar[bool] = True
    shares: ClassVar = {"replaced": ("stiffness", 1.0, 0.5)}  # most likely the storey's own part

    stiffness: float = 0.0
    yield_force: float = 1.0
    sharpness: float = 2.0
    replaced: float = 0.0
    shape: float = 0.5
    storey_stiffness: float = 1e3

    def scaled(self, factor: float) -> Self:
        """Return a joint that carries ``factor`` times as much at the same drifts."""
        return self._times(factor, "stiffness", "yield_force", "replaced")

    law = staticmethod(law)

    flow = staticmethod(flow)

    def priors(self) -> dict[str, tuple[float, float]]:
        """A part of the storey slips, most likely its own, from a thousandth of it to all of it.

        A joint much stiffer than the storey is friction. What it replaces is held to the stiffness
        that a fit starts from; its rounds follow.
        """
        part = float(np.log(PART * self.storey_stiffness))
        own = max(self.stiffness, TINY)
        return {
            "stiffness": (part, 2.0),
            "sharpness": (float(np.log(3.0)), 1.0),
            "replaced": (own, 0.5 * own),
            "shape": (0.5, 0.5),
        }

    def apply(self, spec: mujoco.MjSpec) -> None:
        """Add elasto-plastic tendons along the drift, and one that takes stiffness away."""
        straight = 0.0
        line = Line.of(spec, self.place)
        if self.stiffness and self.shape <= -0.5:
            straight = self.stiffness  # without a plateau nothing slips as far as MJCF can hold
        elif self.stiffness:
            plateau = self.yield_force * (0.5 + self.shape) ** (-1 / self.sharpness)
            sliders = as_sliders(self.stiffness, plateau, self.sharpness)
            for number, (stiffness, yield_force) in enumerate(sliders, start=1):
                slider = line.tendon(f"{self.name}_{number}")
                slider.stiffness = [stiffness, 0.0, 0.0]
                slider.springyield = yield_force / stiffness  # as a drift
            step_finely(spec)
        less = line.tendon(self.name)
        less.stiffness = [straight - self.replaced, 0.0, 0.0]

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return joints that slip at small to large drifts, smoothly or all at once."""
        k = 0.3 * around.stiffness
        return tuple(
            cls(place, k, k * part * rms(around.drift), n, k, shape, around.stiffness)
            for part in (0.1, 0.25, 0.5, 0.8, 1.4)
            for n, shape in ((2.0, 0.5), (1.0, -0.5), (20.0, 0.5))
        )
