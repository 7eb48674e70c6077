"""What an analyser aliases of inputs near half the sampling rate, and outputs do not follow.

An analyser of sampling rate r lets through, less and less, what lies between r / 2.56 and
r - r / 2.56, and folds what it leaves at a frequency f above r / 2 to r - f: with the gain G of
the structure at f, not that at r - f. How much of what is recorded there was folded nobody knows.
At most all of it was: outputs are then off by |G(r - f) - G(f)*| times the input. A hammer's blow,
whose spectrum is wide, is such an input for as long as it lasts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import hilbert

from twin.diagnosis.band import USED_BAND
from twin.model.linear import LinearModel
from twin.model.transfer import transfer

Array = NDArray[np.float64]

SMOOTH = 128
"""Samples by which a recording goes on smoothly to either side, so that its ends are no corners:
what a corner has at more than 1 / 2.56 of the sampling rate is over in a tenth of them."""


def aliased(model: LinearModel, u: Array, step_s: float, noise: Array) -> Array:
    """Return variances by which outputs may be off for what was folded, (samples, m).

    Zero where it may as well be noise of the inputs, which is no folded force: of n samples of
    noise one in n has more than log n times the mean power, and one in n^2 twice as much.

    Args:
        model: in modal coordinates.
        u: band-limited inputs, (samples, r).
        step_s: sampling interval [s].
        noise: standard deviation of the inputs' noise, (r,).
    """
    samples = len(u)
    before = min(SMOOTH, samples - 1)
    smooth = np.pad(u, ((before, before), (0, 0)), "reflect", reflect_type="odd")
    length = 2 * len(smooth)
    ends = np.concatenate([smooth, np.linspace(smooth[-1], smooth[0], length - len(smooth))])
    spectrum = np.fft.rfft(ends, axis=0)
    f = np.asarray(np.fft.rfftfreq(length, step_s), float)
    high = f > 1 / step_s / USED_BAND
    s = np.asarray(2j * np.pi * f[high], complex)
    wrong = transfer(model, s) - np.conj(transfer(model, 2j * np.pi / step_s - s))
    out = np.zeros((len(f), len(model.outputs)), complex)
    out[high] = np.einsum("fmr,fr->fm", wrong, spectrum[high])
    error = np.fft.irfft(out, length, axis=0)
    power = np.abs(hilbert(error, axis=0)[before : before + samples]) ** 2 / 2
    of_noise = np.sum(np.abs(wrong) ** 2, axis=0) @ noise**2 / len(f)
    return np.where(power > 2 * np.log(samples) * of_noise, power, 0.0)
