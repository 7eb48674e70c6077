"""What something light does beside the motion of a fit: it hangs on the structure, or is under it.

It adds a coordinate s to the model, to first order driven by the motion q that there is without it,

    m s'' + r s' + k s = b^T u - (m_q^T q'' + r_q^T q' + k_q^T q),

where the inertia that the structure has of its own is not in m, for q moves with s. Back on the
structure it is a force, and outputs read it. So its beginning, which a state would have to be given
beside the structure's, is at rest, and all samples of a recording tell of it at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.motion import Motion
from twin.mechanisms.mechanism import StructuralChange
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pull:
    """A force along one direction, and what outputs read beside what it moves.

    Attributes:
        row: its direction, (n,).
        force: against it [N or N m], (samples,).
        readings: of the outputs, (samples, m).
    """

    row: Array
    force: Array
    readings: Array


def pull_of(
    light: StructuralChange, model: LinearModel, motion: Motion, u: Array, step_s: float
) -> Pull:
    """Return what a change of the structure that adds one coordinate does along a motion.

    Args:
        light: the change.
        model: the structure without it.
        motion: of the structure.
        u: inputs, (samples, r).
        step_s: sampling interval [s].
    """
    grown, n = light.edit(model), len(model.coordinates)
    moved = (motion.acceleration(step_s), motion.v, motion.q)
    pairs = ((grown.M, model.M), (grown.R, model.R), (grown.K, model.K))
    load = u @ grown.B[n] - sum(x @ G[n, :n] for x, (G, _) in zip(moved, pairs, strict=True))
    own = [G[n, n] for G, _ in pairs]
    own[0] -= grown.M[n, :n] @ np.linalg.solve(grown.M[:n, :n], grown.M[:n, n])
    steps = [_filtered(load, power, own, step_s) for power in (2, 1, 0)]
    force = np.zeros((len(load), n))
    for x, s, (G, G0) in zip(moved, steps, pairs, strict=True):
        force += x @ (G[:n, :n] - G0).T + np.outer(s, G[:n, n])
    read = (grown.Ca, grown.Cv, grown.Cd)
    readings = sum(np.outer(s, C[:, n]) for s, C in zip(steps, read, strict=True))
    row = force[int(np.argmax(np.sum(force**2, axis=1)))]
    row = row / max(float(np.linalg.norm(row)), 1e-300)
    return Pull(row, force @ row, np.asarray(readings))


def _filtered(load: Array, power: int, own: list[float], step_s: float) -> Array:
    """Return s, or its derivative of that power, of m s'' + r s' + k s = load, from rest."""
    top = [1.0] + [0.0] * power
    b, a, _ = signal.cont2discrete((top, own), step_s, "bilinear")
    return np.asarray(signal.lfilter(np.ravel(b), a, load))
