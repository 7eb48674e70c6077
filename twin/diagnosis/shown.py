"""What of recordings and model can be laid side by side: the band that is shown, and what moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.band import USED_BAND, one_rate
from twin.diagnosis.channels import has
from twin.errors import RecordingError, available
from twin.model.linear import LinearModel
from twin.model.moving import STILL
from twin.model.self_check import NOTED
from twin.recording import Recording
from twin.signals.noise_floor import noise_floor

Array = NDArray[np.float64]


def in_shown_band(
    recordings: Sequence[Recording], model: LinearModel, notes: list[str]
) -> list[Recording]:
    """Return recordings without what their analyser's filter aliases onto a mode, and say so.

    An analyser of sampling rate r shows the band up to r / 2.56. Its filter falls off from there
    to r - r / 2.56, and folds what is left at a frequency f to r - f, with the gain of the
    structure at f: near a mode that is not the gain at r - f. Where a mode is there and what
    moves it above the shown band is seen, recordings are brought to twice the shown band.

    Args:
        recordings: of one rate.
        model: in modal coordinates, its inputs and outputs those of the recordings.
        notes: what was done is added.
    """
    rate = recordings[0].sampling_hz
    shown = rate / USED_BAND
    hz = np.sqrt(np.maximum(np.diag(model.K) / np.diag(model.M), 0.0)) / (2 * np.pi)
    doubtful = np.flatnonzero((hz > shown) & (hz < rate - shown))
    parts = [_largest_part(recording, model, doubtful, shown) for recording in recordings]
    seen = [j for i, j in enumerate(doubtful) if max(part[i] for part in parts) > NOTED]
    if not seen:
        return list(recordings)
    modes = available([f"{hz[j]:.4g} Hz" for j in seen])
    notes.append(
        f"the mode at {modes} is stirred where an analyser's filter falls off, from {shown:.4g} to "
        f"{rate - shown:.4g} Hz at a rate of {rate:g} Hz, and what is aliased there is not what "
        f"the mode does; record at {USED_BAND * max(hz[seen]):.4g} Hz or more to have it"
    )
    return one_rate(recordings, 2 * shown, notes)


def _largest_part(
    recording: Recording, model: LinearModel, modes: NDArray[np.intp], shown_hz: float
) -> Array:
    """Return what inputs above the shown band do through each mode, over an output's noise."""
    u = inputs_of(recording, model)
    spectrum = np.fft.rfft(u, axis=0)
    w = 2 * np.pi * np.fft.rfftfreq(len(u), 1 / recording.sampling_hz)
    spectrum[w < 2 * np.pi * shown_hz] = 0.0
    # an input that is less than its own noise there stirs nothing
    power = np.mean(np.abs(spectrum[w >= 2 * np.pi * shown_hz]) ** 2, axis=0) / len(u)
    spectrum[:, power < 2 * np.array([noise_floor(column) for column in u.T]) ** 2] = 0.0
    noise = np.array([noise_floor(recording.column(name)) for name in model.outputs])
    out = np.zeros(len(modes))
    for i, j in enumerate(modes):
        mass, stiffness, damping = model.M[j, j], model.K[j, j], model.R[j, j]
        q = (spectrum @ model.B[j]) / (stiffness - mass * w**2 + 1j * w * damping)
        row = model.Cd[:, j] + np.outer(1j * w, model.Cv[:, j]) - np.outer(w**2, model.Ca[:, j])
        level = np.sqrt(np.mean(np.fft.irfft(q[:, None] * row, len(u), axis=0) ** 2, axis=0))
        out[i] = np.max(level / np.maximum(noise, 1e-300))
    return out


def refuse_what_moves_nothing(recordings: Sequence[Recording], model: LinearModel) -> None:
    """Refuse recordings whose inputs, or whose outputs, are where the model cannot move.

    Raises:
        RecordingError: the message names the channel, and those of the model that move.
    """
    largest = max((np.linalg.norm(port.row) for port in model.ports.values()), default=0.0)
    into = np.linalg.norm(np.vstack([model.B, model.Cu]), axis=0) > STILL * largest
    out = np.linalg.norm(np.hstack([model.Cd, model.Cv, model.Ca]), axis=1) > STILL * largest
    moving = available(list(model.ports))
    for recording in recordings:
        driven = np.any(inputs_of(recording, model), axis=0)
        still = [n for n, d, m in zip(model.inputs, driven, into, strict=True) if d and not m]
        if still and not np.any(driven & into):
            raise RecordingError(
                f"{recording.source}: nothing in the model is moved by {available(still)}; "
                f"what moves there is {moving}"
            )
    if not np.any(out):
        raise RecordingError(
            f"{recordings[0].source}: nothing in the model moves {available(model.outputs)}; "
            f"what moves there is {moving}"
        )


def inputs_of(recording: Recording, model: LinearModel) -> Array:
    """Return the inputs in the model's order, zero where not recorded, (samples, r)."""
    return np.column_stack(
        [
            recording.column(name) if has(recording, name) else np.zeros(recording.samples)
            for name in model.inputs
        ]
    )
