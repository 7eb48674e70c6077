"""Springs of the user's model that yield, one law for all that are along one line.

An exported twin holds a hysteresis as elasto-plastic sliders in parallel. As laws of their own each
would drive the predictor and be driven by all others, for as many unknowns as there are numbers in
the text; they share one motion, and so are one law of many memories, exact as MuJoCo's springs are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from twin.estimation.laws import MOST_NUMBERS
from twin.mechanisms.held import line_of
from twin.mechanisms.hysteresis import Hysteresis
from twin.mechanisms.mechanism import Law, Mechanism, Surroundings
from twin.model.linear import LinearModel
from twin.model.nonlinear import IDEAL

MOST = (MOST_NUMBERS - 3) // 2
"""Sliders of a law: as many as it may have numbers for."""


def law(drift: Any, rate: Any, memory: Any, time: Any, stiffness: Any, yield_force: Any,
        replaced: Any, k0: Any, k1: Any, k2: Any, k3: Any, k4: Any, k5: Any, k6: Any, k7: Any,
        k8: Any, k9: Any, y0: Any, y1: Any, y2: Any, y3: Any, y4: Any, y5: Any, y6: Any, y7: Any,
        y8: Any, y9: Any) -> Any:  # fmt: skip
    """Return sum_i z_i - replaced d [N]."""
    return memory - replaced * drift


def flow(memory: Any, part: Any, before: Any, after: Any, stiffness: Any, yield_force: Any,
         replaced: Any, k0: Any, k1: Any, k2: Any, k3: Any, k4: Any, k5: Any, k6: Any, k7: Any,
         k8: Any, k9: Any, y0: Any, y1: Any, y2: Any, y3: Any, y4: Any, y5: Any, y6: Any, y7: Any,
         y8: Any, y9: Any) -> Any:  # fmt: skip
    """Return the force of one slider after the drift went from ``before`` to ``after``."""
    i = int(part)
    limit = yield_force * (y0, y1, y2, y3, y4, y5, y6, y7, y8, y9)[i]
    slope = stiffness * (k0, k1, k2, k3, k4, k5, k6, k7, k8, k9)[i]
    return np.minimum(np.maximum(memory + slope * (after - before), -limit), limit)


@dataclass(frozen=True)
class Sliders(Law):
    """f = sum_i z_i - replaced d, z_i' = k_i v to |z_i| = y_i (Jenkins 1962; Iwan 1966).

    Attributes:
        stiffness: of all, sum_i k_i [N/m].
        yield_force: of all, sum_i y_i [N].
        replaced: of the linear stiffness that slips [N/m].
        softer: share of the stiffness of each.
        sooner: share of the yield force of each.
    """

    name: ClassVar[str] = Hysteresis.name
    verdict: ClassVar = Hysteresis.verdict
    on: ClassVar = Hysteresis.on
    parameters: ClassVar = {
        key: Hysteresis.parameters[key] for key in ("stiffness", "yield_force", "replaced")
    }
    reference: ClassVar[str] = "Jenkins 1962; Iwan 1966"
    memory: ClassVar[int] = MOST
    abrupt: ClassVar[bool] = True
    shares: ClassVar = Hysteresis.shares

    stiffness: float = 0.0
    yield_force: float = 1.0
    replaced: float = 0.0
    softer: tuple[float, ...] = ()
    sooner: tuple[float, ...] = ()

    law = staticmethod(law)
    flow = staticmethod(flow)

    @property
    def numbers(self) -> tuple[Any, ...]:
        """Those of ``flow``; of sliders that there are not nothing."""
        rest = (0.0,) * (MOST - len(self.softer))
        return (self.stiffness, self.yield_force, self.replaced,
                *self.softer, *rest, *self.sooner, *rest)  # fmt: skip

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return none: what is looked for is the loop that they follow."""
        return ()


def together(known: Sequence[Mechanism], model: LinearModel) -> tuple[Mechanism, ...]:
    """Return what a model holds, with one law for ideal sliders along one line.

    Args:
        known: mechanisms that the model holds.
        model: whose ports say which lines are one.
    """
    out, lines = list[Mechanism](), dict[bytes, list[Hysteresis]]()
    for mechanism in known:
        if isinstance(mechanism, Hysteresis) and mechanism.sharpness == IDEAL:
            lines.setdefault(line_of(model, mechanism.place), []).append(mechanism)
        else:
            out.append(mechanism)
    for line in lines.values():
        for first in range(0, len(line), MOST):
            out.append(_one(line[first : first + MOST], model))
    return tuple(out)


def _one(each: Sequence[Hysteresis], model: LinearModel) -> Sliders:
    """Return sliders along one line as a law at the port of the first."""
    size = np.array([np.max(np.abs(model.port(slider.place))) for slider in each])
    size /= size[0]  # drift at its own port over that at the first one's
    k = size**2 * [slider.stiffness for slider in each]
    y = size * [slider.yield_force for slider in each]
    replaced = float(size**2 @ [slider.replaced for slider in each])
    softer, sooner = (tuple(map(float, part / np.sum(part))) for part in (k, y))
    return Sliders(each[0].place, float(np.sum(k)), float(np.sum(y)), replaced, softer, sooner)
