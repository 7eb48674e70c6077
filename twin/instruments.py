"""Instruments: what lies between the true motion and the number in the recording."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.arrays import frozen
from twin.errors import ExperimentError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reading:
    """What an instrument gave.

    Attributes:
        samples: samples with noise, range and quantisation, (samples,).
        noise_std: standard deviation of the noise that was added, in the channel's unit.
        full_scale: end of the range, or None for an instrument without converter.
        clipped: how many samples were beyond the range.
    """

    samples: Array
    noise_std: float
    full_scale: float | None
    clipped: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "samples", frozen(self.samples, float))


@dataclass(frozen=True)
class Instrument:
    """A sensor with its amplifier and converter; every default is the ideal one but the 24 bits.

    The order is the physical one: the sensor's own dynamics act on the motion (``sense``), the
    analyser's anti-alias filter and sampler follow, then noise, range and quantisation
    (``digitise``). Noise is white and referred to the sampled values.

    Attributes:
        bandwidth_hz: -3 dB corner of a one-pole low-pass [Hz], or None for no limit.
        highpass_hz: -3 dB corner of a one-pole high-pass, as a piezo sensor has [Hz], or None.
        full_scale: end of the range, symmetric about zero, in the channel's unit; None takes the
            next 1, 2 or 5 times a power of ten, as an analyser's auto-range does.
        bits: of the converter over the range -full_scale to full_scale; None for no converter
            (then only a given full scale clips).
        noise_fraction: standard deviation of the noise over the RMS of the noise-free record.
        noise_std: a further noise, in the channel's unit; the two variances add.

    Raises:
        ExperimentError: a value that no instrument can have.
    """

    bandwidth_hz: float | None = None
    highpass_hz: float | None = None
    full_scale: float | None = None
    bits: int | None = 24
    noise_fraction: float = 0.0
    noise_std: float = 0.0

    def __post_init__(self) -> None:
        for name in ("bandwidth_hz", "highpass_hz", "full_scale"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise ExperimentError(f"{name} of an instrument must be positive, not {value}")
        for name in ("noise_fraction", "noise_std"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise ExperimentError(f"{name} of an instrument must not be negative, not {value}")
        if self.bits is not None and not 2 <= self.bits <= 32:
            raise ExperimentError(f"bits of an instrument must be 2 to 32, not {self.bits}")

    def sense(self, history: Array, rate_hz: float) -> Array:
        """Return the sensor's output for a motion at the physics rate, starting at rest."""
        out = np.asarray(history, float)
        if self.bandwidth_hz is not None:
            out = _one_pole(out, self.bandwidth_hz / rate_hz)
        if self.highpass_hz is not None:
            out = out - _one_pole(out, self.highpass_hz / rate_hz)
        return out

    def digitise(self, samples: Array, rng: np.random.Generator) -> Reading:
        """Return the samples with noise, range and quantisation."""
        samples = np.asarray(samples, float)
        rms = float(np.sqrt(np.mean(samples**2)))
        std = math.hypot(self.noise_fraction * rms, self.noise_std)
        noisy = samples + std * rng.standard_normal(len(samples))
        scale = self.full_scale
        if scale is None and self.bits is not None:
            scale = auto_range(float(np.abs(noisy).max(initial=0.0)))
        if scale is None:
            return Reading(noisy, std, None, 0)
        clipped = int(np.count_nonzero(np.abs(noisy) > scale))
        if self.bits is None:
            return Reading(np.clip(noisy, -scale, scale), std, scale, clipped)
        half = 2 ** (self.bits - 1)
        code = np.clip(np.round(noisy / scale * half), -half, half - 1) + 0.0  # no -0
        return Reading(code * (scale / half), std, scale, clipped)


def auto_range(peak: float) -> float:
    """Return the smallest 1, 2 or 5 times a power of ten that holds ``peak``; 1 for zero."""
    if peak < 1e-300:  # nothing there, or too little to be divided by
        return 1.0
    decade = 10.0 ** math.floor(math.log10(peak))
    return next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= peak)


def _one_pole(history: Array, corner: float) -> Array:
    """Low-pass with the corner as a share of the rate, exact for straight lines in between."""
    a = 2 * math.pi * corner
    decay = math.exp(-a)
    mean = -math.expm1(-a) / a
    return np.asarray(signal.lfilter([1 - mean, mean - decay], [1, -decay], history))


ACCELEROMETER = Instrument()
"""A piezo accelerometer, ideal in its band."""

LOAD_CELL = Instrument()
"""The load cell of a hammer or of a shaker's stinger."""

DISPLACEMENT_SENSOR = Instrument()
"""A laser or an inductive displacement sensor."""

ENCODER = Instrument(full_scale=math.pi, bits=16)
"""An encoder on the pendulum's motor, 65 536 counts a revolution."""

INSTRUMENT_OF = {
    "force": LOAD_CELL,
    "torque": LOAD_CELL,
    "acc": ACCELEROMETER,
    "disp": DISPLACEMENT_SENSOR,
    "angle": ENCODER,
}
"""The instrument of each kind of channel, unless an experiment names another; others are ideal."""
