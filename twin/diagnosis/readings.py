"""How much outputs read of what moves a structure, as the structure responds to it.

A force above all resonances is a large one that accelerations of the structure hardly show, and one
at a resonance a small one that they do: two are compared by what is read of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.linalg import expm
from scipy.signal.windows import hann

from twin.diagnosis.discrepancy import Discrepancy
from twin.diagnosis.plant import axis_of
from twin.diagnosis.plant_states import stationary
from twin.mechanisms.mechanism import Disturbance
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def read_of(forces: Sequence[Array], model: LinearModel, step_s: float) -> Array:
    """Return the RMS that outputs read of modal forces, (m,); what stays is no reading.

    Args:
        forces: of every recording, (samples, n).
        model: the structure that they act on.
        step_s: sampling interval [s].
    """
    total, samples = np.zeros(len(model.outputs)), 0
    for force in forces:
        seen = _response(model, len(force), step_s) @ rfft(force, axis=0)[1:, :, None]
        total += _weights(len(force)) @ np.abs(seen[:, :, 0]) ** 2
        samples += len(force)
    return np.asarray(np.sqrt(total / samples))


def read_of_disturbance(
    disturbance: Disturbance | Discrepancy, lengths: Sequence[int], model: LinearModel,
    step_s: float,
) -> Array:  # fmt: skip
    """Return the RMS that outputs are expected to read of a disturbance, (m,).

    Args:
        disturbance: what nobody measured, or what laws leave at a port.
        lengths: samples of every recording.
        model: the structure that it acts on.
        step_s: sampling interval [s].
    """
    total = np.zeros(len(model.outputs))
    for samples in lengths:
        G = _response(model, samples, step_s)
        if disturbance.place in model.places("base"):
            base = model.base[axis_of(model, disturbance.place)]
            seen = base.acc - G @ base.row
        else:
            seen = G @ model.port(disturbance.place)
        power = _weights(samples) * _periodogram(disturbance, samples, step_s)
        total += power @ np.abs(seen) ** 2
    return np.asarray(np.sqrt(total / sum(lengths)))


def _response(model: LinearModel, samples: int, step_s: float) -> NDArray[np.complex128]:
    """Return the frequency response of outputs to modal forces, (samples // 2, m, n)."""
    s = 2j * np.pi * np.arange(1, samples // 2 + 1)[:, None, None] / (samples * step_s)
    stiffness = model.K + s * model.R + s**2 * model.M
    return (model.Cd + s * model.Cv + s**2 * model.Ca) @ np.linalg.inv(stiffness)


def _weights(samples: int) -> Array:
    """Return what squares of a spectrum count for in a sum over samples (Parseval)."""
    weights = np.full(samples // 2, 2.0 / samples)
    weights[-1:] /= 2.0 if samples % 2 == 0 else 1.0
    return weights


def _periodogram(disturbance: Disturbance | Discrepancy, samples: int, step_s: float) -> Array:
    """Return the expected square of the spectrum of a stationary disturbance, (samples // 2,).

    The record is seen through Hann's window, or a line between two frequencies would leak into
    resonances far away. Source: Priestley 1981, 6.1 and 7.5.
    """
    block, drive, shape = disturbance.shaping()
    kept, state = expm(block * step_s), (stationary(block, drive) @ shape)[None]
    while len(state) < samples:  # A^k of twice as many lags by those there are
        state, kept = np.vstack([state, state @ kept.T]), kept @ kept
    window = rfft(hann(samples, sym=False), next_fast_len(2 * samples, real=True))
    seen = irfft(np.abs(window) ** 2, next_fast_len(2 * samples, real=True))[:samples]
    covariance = (state[:samples] @ shape) * seen / seen[0]
    return np.asarray(samples * np.real(2.0 * rfft(covariance)[1:] - covariance[0]))
