"""Exact steps of a linear structure whose inputs are linear between samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def free_run(
    model: LinearModel, inputs: Array, rate_hz: float, start: Array | None = None
) -> Array:
    """Return the outputs of a linear model driven by its inputs alone, (samples, outputs).

    Args:
        model: its equations of motion.
        inputs: in the order of ``model.inputs``, linear between samples, (samples, r).
        rate_hz: samples per second.
        start: state [q, q'] at the first sample, (2 n,); at rest where None.
    """
    u = np.asarray(inputs, float)
    if u.ndim != 2 or u.shape[1] != len(model.inputs):
        raise ValueError(f"inputs of shape {u.shape} for {len(model.inputs)} inputs")
    system = model.state_space()
    n, r = len(system.A), u.shape[1]
    # the state together with the input and its slope: one matrix exponential, Van Loan 1978
    whole = np.zeros((n + 2 * r, n + 2 * r))
    whole[:n, :n], whole[:n, n : n + r] = system.A, system.B
    whole[n : n + r, n + r :] = np.eye(r)
    step = expm(whole / rate_hz)
    slope = np.diff(u, axis=0, append=u[-1:]) * rate_hz
    push = u @ step[:n, n : n + r].T + slope @ step[:n, n + r :].T
    states = np.empty((len(u), n))
    state = np.zeros(n) if start is None else np.asarray(start, float)
    A = step[:n, :n]
    for k in range(len(u)):
        states[k] = state
        state = A @ state + push[k]
    return np.asarray(states @ system.C.T + u @ system.D.T + model.rest)
