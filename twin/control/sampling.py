"""The converters in front of the controller: noise, range and quantisation, sample by sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from twin.channel import Channel
from twin.errors import ControlError
from twin.instruments import ENCODER, Instrument
from twin.laboratory.experiment import stream

Array = NDArray[np.float64]

INSTRUMENTS: Mapping[str, Instrument] = MappingProxyType(
    {
        "acc": Instrument(full_scale=20.0, noise_std=0.01),
        "force": Instrument(full_scale=10.0, noise_std=1e-3),
        "angle": ENCODER,
    }
)
"""By channel or kind: 1 % of what the worst case gives without control; a 16-bit encoder."""


class Converters:
    """The channels' instruments, ready to read one instant after the other."""

    def __init__(
        self,
        channels: Sequence[str],
        instruments: Mapping[str, Instrument],
        samples: int,
        seed: int,
    ) -> None:
        chosen = [_instrument(name, instruments) for name in channels]
        self._noise = np.column_stack(
            [
                instrument.noise_std * stream(seed, 0, name).standard_normal(samples)
                for name, instrument in zip(channels, chosen, strict=True)
            ]
        )
        scale = [np.inf if i.full_scale is None else i.full_scale for i in chosen]
        self._range = np.array(scale)
        self._step = np.array(
            [
                0.0 if i.full_scale is None or i.bits is None else i.full_scale / 2 ** (i.bits - 1)
                for i in chosen
            ]
        )
        self._stepped = np.flatnonzero(self._step)
        self.clipped = np.zeros(len(channels), int)

    def read(self, k: int, values: Array) -> Array:
        """Return what the converters give at sample k for the true values, (channels,)."""
        noisy = values + self._noise[k]
        over = np.abs(noisy) > self._range
        if over.any():
            self.clipped += over
            np.clip(noisy, -self._range, self._range, out=noisy)
        step = self._step[self._stepped]
        noisy[self._stepped] = np.round(noisy[self._stepped] / step) * step
        return np.asarray(noisy)


def _instrument(channel: str, instruments: Mapping[str, Instrument]) -> Instrument:
    kind = Channel(channel).kind
    found = instruments.get(channel, instruments.get(kind, INSTRUMENTS[kind]))
    if found.noise_fraction or found.bandwidth_hz or found.highpass_hz:
        raise ControlError(
            f"the instrument of '{channel}' in a control loop has a noise_std and a range only: no "
            "noise_fraction, bandwidth_hz or highpass_hz"
        )
    return found
