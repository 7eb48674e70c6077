"""What enters a linear filter linearly: the innovations of known forces and of initial states."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from twin.diagnosis.filtering import Gain, recursion
from twin.diagnosis.plant import Sampled

Array = NDArray[np.float64]


def effects_of_forces(plant: Sampled, gains: Gain, law: int, forces: Array) -> Array:
    """Return the innovations that known histories of a law's force add.

    Args:
        plant: with the law.
        gains: of the filter.
        law: which of the plant's laws exerts the force.
        forces: (histories, samples).

    Returns:
        (histories, samples, m), by convolution with the response to one sample's force; the last
        force stays on after the end.
    """
    samples = forces.shape[1]
    C, seen = plant.plant.C, plant.plant.F[:, law]
    K = gains.whole(plant.A)
    F = plant.A - K @ C
    # x(k+1) = F x(k) + now f(k) + later f(k+1): a unit force at sample 0, as if it came at once
    now, later = plant.E0[:, law] - K @ seen, plant.E1[:, law]
    first = F @ later + now
    x = recursion(F, np.zeros((samples, len(F))), first)
    response = np.empty((samples, len(C)))
    response[0] = -(seen + C @ later)
    response[1:] = -(x[: samples - 1] @ C.T)
    length = fft.next_fast_len(2 * samples, real=True)
    product = fft.rfft(forces, length)[:, :, None] * fft.rfft(response, length, axis=0)
    out = fft.irfft(product, length, axis=1)[:, :samples]
    # the state before the first sample does not know that sample's force
    rest = recursion(F, np.zeros((samples, len(F))), later) @ C.T
    return np.asarray(out + forces[:, :1, None] * rest)


def effect_of_start(plant: Sampled, gains: Gain, samples: int) -> Array:
    """Return the innovations of unit initial states, (n, samples, m)."""
    C = plant.plant.C
    F = plant.A - gains.whole(plant.A) @ C
    n, m = len(F), len(C)
    poles, V = np.linalg.eig(F)
    if not np.linalg.cond(V) < 1e10:
        still = np.zeros((samples, n))
        return -np.array([recursion(F, still, unit) @ C.T for unit in np.eye(n)])
    keep = np.flatnonzero(poles.imag >= 0)
    weight = np.where(poles.imag[keep] > 0, 2.0, 1.0)
    parts = np.einsum("op,pn->pno", C @ V[:, keep] * weight, np.linalg.inv(V)[keep])
    parts = parts.reshape(len(keep), n * m)
    powers = _powers(poles[keep], samples)
    out = powers.real @ parts.real - powers.imag @ parts.imag
    return -np.moveaxis(out.reshape(samples, n, m), 1, 0)


def _powers(poles: Array, samples: int) -> Array:
    """Return the powers 0 to samples - 1 of poles, (samples, poles), by doubling."""
    out = np.ones((samples, len(poles)), complex)
    done, factor = 1, poles.astype(complex)
    while done < samples:
        more = min(done, samples - done)
        out[done : done + more] = out[:more] * factor
        factor = factor**2
        done += more
    return out
