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
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def pull_of(grown: LinearModel, model: LinearModel, at: Array, motion: Motion,
            step_s: float) -> Array:  # fmt: skip
    """Return the force of what hangs at a port, against its motion, (samples,) [N or N m].

    Args:
        grown: the structure with it, which has one coordinate more.
        model: the structure without it.
        at: row of the port, (n,).
        motion: of the structure.
        step_s: sampling interval [s].
    """
    n, along = len(model.coordinates), at / (at @ at)
    moved = (motion.a, motion.v, motion.q)
    pairs = ((grown.M, model.M), (grown.R, model.R), (grown.K, model.K))
    load = np.asarray(-sum(x @ G[n, :n] for x, (G, _) in zip(moved, pairs, strict=True)))
    steps = _moved(load, [G[n, n] for G, _ in pairs], step_s)
    force = np.zeros(len(load))
    for x, s, (G, G0) in zip(moved, steps, pairs, strict=True):
        force += x @ ((G[:n, :n] - G0).T @ along) + s * (G[:n, n] @ along)
    return force


def _moved(load: Array, own: list[float], step_s: float) -> list[Array]:
    """Return s'', s' and s of m s'' + r s' + k s = load, from rest, by the trapezoidal rule."""
    rate = 2 / step_s
    ways = np.array([[1.0, -2.0, 1.0], [1.0, 0.0, -1.0], [1.0, 2.0, 1.0]])
    ways *= np.array([[rate**2], [rate], [1.0]])
    return [np.asarray(signal.lfilter(way, np.array(own) @ ways, load)) for way in ways]
