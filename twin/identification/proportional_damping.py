"""Proportional damping R = alpha M + beta K from identified modes, eqs. (42)-(46)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from twin.errors import IdentificationError


def proportional_damping(
    natural_freq_hz: ArrayLike, damping_ratio: ArrayLike
) -> tuple[float, float]:
    """Return the coefficients alpha [1/s] and beta [s] that fit the damping ratios best.

    A mode of R = alpha M + beta K has zeta_j = (alpha / omega_j + beta omega_j) / 2; the two
    coefficients solve these equations in the least-squares sense (exactly, for two modes).

    Args:
        natural_freq_hz: natural frequencies [Hz], (modes,).
        damping_ratio: damping ratios, (modes,).

    Raises:
        IdentificationError: values that are not finite, a frequency that is not positive, arrays
            of different length, or fewer than two different frequencies.

    Source: eqs. (42)-(45).
    """
    freq = np.atleast_1d(np.asarray(natural_freq_hz, float))
    zeta = np.atleast_1d(np.asarray(damping_ratio, float))
    if freq.ndim != 1 or freq.shape != zeta.shape:
        raise IdentificationError(
            f"proportional damping needs one damping ratio for each natural frequency, "
            f"got {zeta.size} for {freq.size}"
        )
    if not (np.all(np.isfinite(freq)) and np.all(np.isfinite(zeta)) and np.all(freq > 0)):
        raise IdentificationError(
            "proportional damping needs finite damping ratios and positive natural frequencies"
        )
    if len(np.unique(freq)) < 2:
        raise IdentificationError(
            f"proportional damping needs modes at two different natural frequencies, "
            f"got {len(np.unique(freq))}"
        )
    omega = 2 * np.pi * freq
    # Measured in the mean frequency both columns of (44) are of order one; the fit is the same.
    mean = float(np.exp(np.mean(np.log(omega))))
    C = 0.5 * np.column_stack([mean / omega, omega / mean])
    (alpha, beta), *_ = np.linalg.lstsq(C, zeta, rcond=None)
    return float(alpha * mean), float(beta / mean)
