"""The Silverbox: its arrow-shaped test, its ten multisines and its Schroeder multisine."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError
from twin.recording import Recording

Array = NDArray[np.float64]

RATE_HZ = 1e7 / 2**14
NEWTON_A_VOLT, METRE_A_VOLT = 134.0, 1e-3
"""The box is electronic: this scale makes a frame of the shipped model's size of it."""
ARROW = 40_500
"""Samples of the arrow with the pause after it."""
QUIET_V, PAUSE, LEAST, MARGIN = 0.012, 30, 5000, 8
"""Between multisines the input stays below this for at least so many samples; a multisine has at
least so many; samples of the pause that are kept on both sides."""
NOTE = "volts are read as 134 N a volt and 1 mm a volt"


def recordings(members: Mapping[str, bytes]) -> list[Recording]:
    """Return the arrow, the multisines and Schroeder's, as far as their files are there."""
    out = []
    if "SNLS80mV.csv" in members:
        volts = _volts(members["SNLS80mV.csv"], "SNLS80mV.csv")
        out.append(_recording(volts, 0, ARROW, "silverbox_arrow.csv"))
        for number, (start, stop) in enumerate(_blocks(volts[:, 0]), start=1):
            out.append(_recording(volts, start, stop, f"silverbox_multisine_{number:02d}.csv"))
    if "Schroeder80mV.csv" in members:
        volts = _volts(members["Schroeder80mV.csv"], "Schroeder80mV.csv")
        out.append(_recording(volts, 0, len(volts), "silverbox_schroeder.csv"))
    return out


def _volts(data: bytes, name: str) -> Array:
    """Read input and output, (samples, 2)."""
    try:
        read = np.genfromtxt(io.BytesIO(data), delimiter=",", skip_header=1, usecols=(0, 1))
    except ValueError as error:
        raise RecordingError(f"{name}: not two columns of volts ({error})") from None
    volts = np.asarray(read, float)
    return volts[np.isfinite(volts).all(axis=1)]


def _recording(volts: Array, start: int, stop: int, name: str) -> Recording:
    u, y = (volts[start:stop] - volts.mean(axis=0)).T  # less the amplifiers' offsets
    columns = {"force_floor1": NEWTON_A_VOLT * u, "disp_floor1": METRE_A_VOLT * y}
    return Recording.build(RATE_HZ, columns, name, notes=(NOTE,))


def _blocks(u: Array) -> list[tuple[int, int]]:
    """Return where the stretches between the pauses after the arrow begin and end."""
    loud = np.flatnonzero(np.abs(u[ARROW:]) > QUIET_V) + ARROW
    if not len(loud):
        return []
    breaks = np.flatnonzero(np.diff(loud) > PAUSE)
    starts = np.concatenate([loud[:1], loud[breaks + 1]])
    stops = np.concatenate([loud[breaks], loud[-1:]])
    return [
        (max(int(a) - MARGIN, 0), min(int(b) + MARGIN, len(u)))
        for a, b in zip(starts, stops, strict=True)
        if b - a > LEAST
    ]
