"""A channel that hums: mains frequency and its overtones, through a loop or a bad screen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from scipy.linalg import block_diag

from twin.mechanisms.instrument import Instrument
from twin.mechanisms.mechanism import Array, ChannelFault, Surroundings
from twin.mechanisms.scales import rms
from twin.parameter import Parameter
from twin.signals.mains import MAINS_HZ, hum

TONES, OVERTONES = 3, 0.3
"""The fundamental and its first overtones, and how strong these are beside it, roughly."""

WANDER = 0.005
"""Half-width of the line [Hz], roughly: mains drift by a hundredth of a hertz in half a minute."""

STRAY = 0.01
"""Share beyond which a line is no tone of the mains but one that the sampling folds back."""

KNOWN_HZ = 0.05
"""Standard deviation of the mains frequency about its nominal value (ENTSO-E, normal operation)."""


@dataclass(frozen=True)
class SensorHum(ChannelFault):
    """Recorded = true + sum_k a_k sin(2 pi k f t + phase_k), phases free and slowly wandering.

    To an estimator each tone is an oscillator of unknown start, so amplitude and phase are
    estimated from it; ``amplitude`` says how large it is likely to be.

    Attributes:
        phase: of the fundamental where it is simulated [rad]; not fitted.

    Source: IEEE 1100, on powering and grounding; oscillators as states, Harvey 1989.
    """

    name: ClassVar[str] = "sensor_hum"
    verdict: ClassVar = "measurement"
    on: ClassVar = "channel"
    parameters: ClassVar = {
        "amplitude": Parameter("the channel's", "RMS of the fundamental", "log"),
        "frequency": Parameter("Hz", "of the mains", "log"),
        "wander": Parameter("Hz", "half-width of the line", "log"),
        "overtones": Parameter("1", "of an overtone over the fundamental", "log"),
    }
    reference: ClassVar[str] = "IEEE 1100; Harvey 1989"
    mjcf: ClassVar[str] = "a channel's fault is not part of the model"

    amplitude: float = 0.0
    frequency: float = 50.0
    phase: float = 0.0
    wander: float = WANDER
    overtones: float = OVERTONES

    def priors(self) -> dict[str, tuple[float, float]]:
        """The mains frequency is known; the rest as first guesses are."""
        nominal = min(MAINS_HZ, key=lambda mains: abs(mains - self.frequency))
        return {"frequency": (float(np.log(nominal)), KNOWN_HZ / nominal)}

    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels with a fundamental and no overtones."""
        if not self.amplitude:
            return self._change(columns, np.copy)

        def humming(x: Array) -> Array:
            turn = 2 * np.pi * self.frequency * np.arange(len(x)) / rate_hz
            return x + np.sqrt(2) * self.amplitude * np.sin(turn + self.phase)

        return self._change(columns, humming)

    def instrument(self, rms: float) -> Instrument:
        """Return an oscillator for each tone, whose state is what is added."""
        blocks, rate = [], 2 * np.pi * self.wander
        for number in range(1, TONES + 1):
            w = 2 * np.pi * number * self.frequency
            blocks.append(np.array([[-rate, w], [-w, -rate]]))
        strengths = [1.0, *[self.overtones] * (TONES - 1)]
        sizes = self.amplitude * np.repeat(strengths, 2)
        k = len(sizes)
        return Instrument(
            D=np.eye(1),
            A=block_diag(*blocks),
            B=np.zeros((k, 1)),
            C=np.tile([1.0, 0.0], k // 2)[None],
            G=np.diag(np.sqrt(2 * rate) * sizes),
            start=np.diag(sizes**2),
        )

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the hum that stands out in a reading, None where none does."""
        line = hum(reading, rate_hz)
        if line is None:
            return None
        tones = [(mains, order) for mains in MAINS_HZ for order in range(1, TONES + 1)]
        mains, order = min(tones, key=lambda tone: abs(line.frequency - tone[0] * tone[1]))
        folded = abs(line.frequency - mains * order) > STRAY * mains * order
        return cls(place, line.size / np.sqrt(2), mains if folded else line.frequency / order)

    @classmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return the line that stands out, else a hundredth of the reading at either mains."""
        found = cls.found(place, around.reading, around.sampling_hz)
        if found is not None:
            return (found,)
        return tuple(cls(place, 0.01 * rms(around.reading), mains) for mains in MAINS_HZ)
