"""What something light that hangs on a structure does beside the motion of a fit.

It adds a coordinate s to the model, to first order driven by the motion q that there is without it,

    m s'' + r s' + k s = -(m_q^T q'' + r_q^T q' + k_q^T q),

and back on the structure it is a force. So its beginning, which a state would have to be given
beside the structure's, is at rest, and all samples of a recording tell of it at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.motion import Motion
from twin.mechanisms.mechanism import StructuralChange
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def pull_of(light: StructuralChange, model: LinearModel, motion: Motion, step_s: float) -> Array:
    """Return the force of what hangs at a port, against its motion, (samples,) [N or N m].

    Args:
        light: the change of the structure, which adds one coordinate.
        model: the structure without it.
        motion: of the structure.
        step_s: sampling interval [s].
    """
    grown, n = light.edit(model), len(model.coordinates)
    moved = (motion.a, motion.v, motion.q)
    pairs = ((grown.M, model.M), (grown.R, model.R), (grown.K, model.K))
    load = np.asarray(-sum(x @ G[n, :n] for x, (G, _) in zip(moved, pairs, strict=True)))
    own = [G[n, n] for G, _ in pairs]
    steps = [_filtered(load, power, own, step_s) for power in (2, 1, 0)]
    force = np.zeros((len(load), n))
    for x, s, (G, G0) in zip(moved, steps, pairs, strict=True):
        force += x @ (G[:n, :n] - G0).T + np.outer(s, G[:n, n])
    row = model.port(light.place)
    return np.asarray(force @ row / (row @ row))


def _filtered(load: Array, power: int, own: list[float], step_s: float) -> Array:
    """Return s, or its derivative of that power, of m s'' + r s' + k s = load, from rest."""
    top = [1.0] + [0.0] * power
    b, a, _ = signal.cont2discrete((top, own), step_s, "bilinear")
    return np.asarray(signal.lfilter(np.ravel(b), a, load))
