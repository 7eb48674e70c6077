"""Recordings for the identification's tests, from an exact linear solution."""

from __future__ import annotations

import numpy as np
from scipy import signal

from twin.recording import Recording
from twin.second_order import SecondOrderModel

FS = 32.0
FINE = 32
SECONDS = 36


def one_hit(place: str = "floor1", at: float = 2.5) -> dict[str, np.ndarray]:
    """A half-sine of 8 ms, shorter than a sample, after two seconds of lead."""
    t = np.arange(int(SECONDS * FS * FINE)) / (FS * FINE) - at
    return {f"force_{place}": np.where((t >= 0) & (t <= 0.008), 20 * np.sin(np.pi * t / 0.008), 0)}


def two_hits() -> dict[str, np.ndarray]:
    first, second = one_hit()["force_floor1"], one_hit(at=4.1)["force_floor1"]
    return {"force_floor1": first + 0.6 * second}


def random_force(place: str = "floor1", seed: int = 0) -> dict[str, np.ndarray]:
    """Noise between 0.5 and 12 Hz that is cut off by the end of the record."""
    samples = int((SECONDS + 32) * FS * FINE)
    white = np.random.default_rng(seed).standard_normal(samples)
    sos = signal.butter(4, [0.5, 12], "band", fs=FS * FINE, output="sos")
    force = signal.sosfilt(sos, white)
    force[: int(2.5 * FS * FINE)] = 0
    return {f"force_{place}": force / force.std()}


def noisy(recording: Recording, share: float, seed: int) -> Recording:
    rng = np.random.default_rng(seed)
    level = share * np.sqrt(np.mean(recording.data**2, axis=0))
    data = recording.data + level * rng.standard_normal(recording.data.shape)
    return Recording(recording.sampling_hz, recording.channels, data, recording.source)


def analysed(
    frame: SecondOrderModel, forces: dict[str, np.ndarray], rate: int, seconds: float
) -> Recording:
    """What an ideal analyser sees of continuous forces given ``rate`` times per sample."""
    inputs = tuple(forces)
    places = tuple(name.removeprefix("force_") for name in inputs)
    u = np.column_stack(list(forces.values()))
    model = frame.acceleration_response(places)
    dt = 1 / (FS * rate)
    A, B, C, D, _ = signal.cont2discrete((model.A, model.B, model.C, model.D), dt, method="foh")
    _, y, _ = signal.dlsim(signal.dlti(A, B, C, D, dt=dt), u)
    taps = signal.firwin(1 + 32 * rate, FS / 2, window=("kaiser", 10.5), fs=FS * rate)
    both = signal.oaconvolve(np.hstack([u, y]), taps[:, None], mode="same", axes=0)
    lead = 2 * int(FS) * rate
    samples = both[lead::rate][: int(seconds * FS)]
    names = (*inputs, *(f"acc_{place}" for place in frame.coordinates))
    return Recording.build(FS, dict(zip(names, samples.T, strict=True)), source="analysed")
