"""From the rig's motion to the recording, in the physical order: sensor, filter, sampler, noise.

A sensor's fault acts on the accelerometer's own signal: gain, polarity, clipping, high pass and
delay come before the anti-alias filter, and clipping before the noise. Swapped cables come last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, firwin, freqz, lfilter, sosfilt, sosfreqz

from twin.recording import Recording

from .mechanisms import Mechanism
from .plans import FINE, FINE_HZ, SAMPLING_HZ, Test
from .rig import Array

CUTOFF = 0.4
"""Corner of the anti-alias filter, as a share of the sampling rate."""

FIR_EDGE = 0.45
"""The same of the linear-phase filter."""

TAPS = 513


@dataclass(frozen=True)
class Chain:
    """How a rig is measured.

    Attributes:
        style: "filtered": force made at the fine rate, force and accelerations through the same
            anti-alias filter; "linear": force linear between its samples, nothing filtered.
        order: of the Butterworth filter; 0 for a linear-phase FIR filter.
        noise: standard deviation of the white noise, as a share of each channel's RMS.
    """

    style: str
    order: int
    noise: float

    @classmethod
    def draw(cls, rng: np.random.Generator, low: float = 0.003, high: float = 0.02) -> Chain:
        """Draw a style (three in four filtered), a filter and the noise."""
        style = "filtered" if rng.random() < 0.75 else "linear"
        order = int(rng.choice([0, 6, 7, 8]))
        return cls(style, order, float(np.exp(rng.uniform(np.log(low), np.log(high)))))

    @property
    def fine(self) -> bool:
        """True when the force is made on the integrator's grid."""
        return self.style == "filtered"

    def filtered(self, signals: Array, rate: float) -> Array:
        """Pass signals of a rate [Hz], (samples, channels), through the anti-alias filter."""
        if not self.fine:
            return signals
        if self.order:
            return np.asarray(sosfilt(self._sections(rate), signals, axis=0))
        return np.asarray(lfilter(self._taps(rate), 1.0, signals, axis=0))

    def sampled(self, signals: Array) -> Array:
        """Filter and decimate signals on the integrator's grid, (samples, channels)."""
        return self.filtered(signals, FINE_HZ)[::FINE]

    def response(self, frequency: Array) -> Array:
        """Return the filter's complex response at frequencies [Hz]."""
        if not self.fine:
            return np.ones(len(frequency), complex)
        if self.order:
            return np.asarray(sosfreqz(self._sections(FINE_HZ), frequency, fs=FINE_HZ)[1])
        return np.asarray(freqz(self._taps(FINE_HZ), 1, frequency, fs=FINE_HZ)[1])

    def _sections(self, rate: float) -> Array:
        return np.asarray(butter(self.order, CUTOFF * SAMPLING_HZ, fs=rate, output="sos"))

    def _taps(self, rate: float) -> Array:
        count = round((TAPS - 1) * rate / FINE_HZ) + 1
        return np.asarray(firwin(count, FIR_EDGE * SAMPLING_HZ, window=("kaiser", 6.0), fs=rate))


def at_sensor(accelerations: Array, *effects: Mechanism, rate: float = FINE_HZ) -> Array:
    """Return what the accelerometers give at a rate [Hz], their faults included."""
    given = accelerations
    for m in effects:
        if m.in_sensor and m.location.startswith("acc_floor"):
            given = _faulty(given, m, rate)
    return given


def _faulty(accelerations: Array, mechanism: Mechanism, rate: float) -> Array:
    given = accelerations.copy()
    if mechanism.name == "sensor_swap":
        one, other = (int(channel[-1]) - 1 for channel in mechanism.location.split("+"))
        given[:, [one, other]] = given[:, [other, one]]
        return given
    signal = given[:, mechanism.index]
    if mechanism.name == "sensor_gain":
        signal = mechanism["gain"] * signal
    elif mechanism.name == "sensor_polarity":
        signal = -signal
    elif mechanism.name == "sensor_clipping":
        signal = np.clip(signal, -mechanism["level"], mechanism["level"])
    elif mechanism.name == "sensor_highpass":
        signal = highpass(signal, mechanism["corner"], rate)
    elif mechanism.name == "sensor_delay":
        signal = delayed(signal, mechanism["delay"], rate)
    given[:, mechanism.index] = signal
    return given


def highpass(signal: Array, corner: float, rate: float, inverse: bool = False) -> Array:
    """First-order high pass [Hz] from rest, or its inverse."""
    b, a = butter(1, corner, btype="high", fs=rate)
    return np.asarray(lfilter(a, b, signal) if inverse else lfilter(b, a, signal))


def delayed(signal: Array, delay: float, rate: float) -> Array:
    """Return the signal later by a delay [s] (earlier if negative), its end value held."""
    time = np.arange(len(signal)) / rate
    return np.asarray(CubicSpline(time, signal)(np.clip(time - delay, 0.0, time[-1])))


def measure(
    chain: Chain, test: Test, drive: Array, accelerations: Array, effects: Sequence[Mechanism],
    recorded: Sequence[int], rng: np.random.Generator,
) -> Recording:  # fmt: skip
    """Return the recording of a test: what drives it and the recorded floors' accelerations.

    Args:
        chain: filter, sampler and noise.
        test: what is recorded.
        drive: force [N] or ground acceleration [m/s^2] on the integrator's grid.
        accelerations: of the floors, the same.
        effects: faults of sensors among them.
        recorded: floors whose accelerometers are there, from 1.
        rng: draws the noise.
    """
    name = test.input
    for m in effects:
        if m.name == "sensor_gain" and m.location == name:
            drive = m["gain"] * drive
    both = np.column_stack([drive, at_sensor(accelerations, *effects)])
    sampled = chain.sampled(both)
    deviation = chain.noise * np.sqrt(np.mean(sampled**2, axis=0))
    noisy = sampled + deviation * rng.standard_normal(sampled.shape)
    columns: dict[str, Any] = {name: noisy[:, 0]}
    columns |= {f"acc_floor{floor}": noisy[:, floor] for floor in recorded}
    return Recording.build(SAMPLING_HZ, columns, test.name)
