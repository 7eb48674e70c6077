"""What a whole sample does to a state, and to the ports of the laws at each of its parts.

Over a sample x+ = A x + B0 u + B1 u+ + E f + W n is repeated, part after part. Of the states in
between laws see the motion at their ports alone, so that these are stepped, and the whole state
from sample to sample: with n states, l laws and p unknowns a part costs some 2 l n p, not n^2 p.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from twin.estimation.system import Sampled

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lifted:
    """A sample's steps at once, or their derivatives with respect to unknowns in a last axis.

    Attributes:
        over: x at the next sample by (x, n, u, u+, f of each part), (n, n + w + 2 r + steps l).
        reach: displacements, then rates, at the laws' ports where each part ends, by
            (x, n, u, u+), (steps, 2 l, n + w + 2 r).
        push: the same by the forces of that many parts before, (steps, 2 l, l).
    """

    over: Array
    reach: Array
    push: Array


def lifted(plant: Sampled) -> Lifted:
    """Return the steps of a sample at once.

    Inputs are linear from sample to sample; those that are held move nothing by their next value.
    """
    (n, laws), w, r = plant.E.shape, plant.W.shape[1], plant.B0.shape[1]
    rows = np.vstack([plant.system.drift, plant.system.rate])
    before, after = slice(n + w, n + w + r), slice(n + w + r, n + w + 2 * r)
    rising = np.any(plant.B1 != 0.0, axis=0)
    over = np.hstack([np.eye(n), np.zeros((n, w + 2 * r))])
    reach, push, forces = [], [], [plant.E]
    with np.errstate(all="ignore"):  # what runs away within a sample is not finite
        for part in range(plant.steps):
            begun, ended = part / plant.steps * rising, (part + 1) / plant.steps * rising
            over = plant.A @ over
            over[:, n : n + w] += plant.W
            over[:, before] += plant.B0 * (1 - begun) + plant.B1 * (1 - ended)
            over[:, after] += plant.B0 * begun + plant.B1 * ended
            reach.append(rows @ over)
            push.append(rows @ forces[-1])
            forces.append(plant.A @ forces[-1])
    return Lifted(
        np.hstack([over, *forces[-2::-1]]),
        np.array(reach).reshape(plant.steps, 2 * laws, n + w + 2 * r),
        np.array(push).reshape(plant.steps, 2 * laws, laws),
    )
