"""What a run under control gave, and the numbers that judge it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reduction:
    """1 - (with control) / (without) of each floor's displacement, eq. (60).

    Attributes:
        whole: of the peaks over the whole of both parts of the run.
        steady: of the peaks over the last half of each part.
        rms: of the root mean squares over the last half of each part.
    """

    whole: Mapping[str, float]
    steady: Mapping[str, float]
    rms: Mapping[str, float]

    def as_json(self) -> dict[str, dict[str, float]]:
        """Return plain types."""
        return {name: dict(getattr(self, name)) for name in ("whole", "steady", "rms")}


@dataclass(frozen=True)
class Outcome:
    """A run, without control before ``switch_s`` and with it from there on.

    Attributes:
        rate_hz: the controller's rate [Hz].
        physics_hz: the simulation's rate [Hz], a multiple of it.
        switch_s: when the controller was switched on [s].
        floors: from the ground up.
        displacement: of the floors, relative to the ground where it moves [m], (steps, floors) at
            the physics rate.
        angle: of the pendulum [rad], (steps,).
        known_input: channel of the excitation.
        excitation: its true values [N or m/s^2], (steps,).
        channels: what the controller reads: measurements, then the known input.
        measured: what it read, (samples, channels) at the controller's rate.
        torque: that acts from each sample on [N m], (samples,).
        estimates: what the controller estimates: displacements and angle.
        estimated: (samples, estimates).
        qpos: joint positions of the plant at each sample, for viewers, (samples, nq).
        limited: samples at which the torque was cut off at its limit.
        clipped: channel -> samples beyond its converter's range.
    """

    rate_hz: float
    physics_hz: float
    switch_s: float
    floors: tuple[str, ...]
    displacement: Array
    angle: Array
    known_input: str
    excitation: Array
    channels: tuple[str, ...]
    measured: Array
    torque: Array
    estimates: tuple[str, ...]
    estimated: Array
    qpos: Array
    limited: int = 0
    clipped: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        arrays = ("displacement", "angle", "excitation", "measured", "torque", "estimated", "qpos")
        for name in arrays:
            object.__setattr__(self, name, frozen(getattr(self, name), float))
        object.__setattr__(self, "clipped", MappingProxyType(dict(self.clipped)))

    @property
    def time(self) -> Array:
        """Time of the physics steps [s]."""
        return np.arange(len(self.angle)) / self.physics_hz

    @property
    def sample_time(self) -> Array:
        """Time of the controller's samples [s]."""
        return np.arange(len(self.torque)) / self.rate_hz

    @cached_property
    def reduction(self) -> Reduction:
        """Reductions of (60) in three readings; NaN where there was no run without control."""
        off, on = self._parts(half=False)
        late_off, late_on = self._parts(half=True)
        return Reduction(
            self._shares(_peak(off), _peak(on)),
            self._shares(_peak(late_off), _peak(late_on)),
            self._shares(_rms(late_off), _rms(late_on)),
        )

    @property
    def peak_swing_rad(self) -> float:
        """Largest angle of the pendulum under control [rad]."""
        return float(np.abs(self.angle[self._switch :]).max())

    @property
    def peak_torque_nm(self) -> float:
        """Largest torque [N m]."""
        return float(np.abs(self.torque).max())

    @property
    def notes(self) -> tuple[str, ...]:
        """What saturated, one sentence each."""
        notes = []
        if self.limited:
            notes.append(f"the torque was at its limit in {self.limited} samples")
        notes += [f"{name} was clipped in {count} samples" for name, count in self.clipped.items()]
        if self.peak_swing_rad > np.pi / 2:
            notes.append(
                f"the pendulum swung to {self.peak_swing_rad:.2f} rad, beyond the horizontal, "
                "where the design model means nothing"
            )
        return tuple(notes)

    @property
    def _switch(self) -> int:
        return round(self.switch_s * self.physics_hz)

    def _parts(self, half: bool) -> tuple[Array, Array]:
        off, on = self.displacement[: self._switch], self.displacement[self._switch :]
        return (off[len(off) // 2 :], on[len(on) // 2 :]) if half else (off, on)

    def _shares(self, off: Array, on: Array) -> Mapping[str, float]:
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = 1 - on / off
        return MappingProxyType(dict(zip(self.floors, shares.tolist(), strict=True)))


def joined(off: Outcome, on: Outcome) -> Outcome:
    """Return two runs, each from rest, as one: control is on in the second."""
    stacked: dict[str, Any] = {
        name: np.concatenate([getattr(off, name), getattr(on, name)])
        for name in (
            "displacement",
            "angle",
            "excitation",
            "measured",
            "torque",
            "estimated",
            "qpos",
        )
    }
    clipped = dict(off.clipped)
    for name, count in on.clipped.items():
        clipped[name] = clipped.get(name, 0) + count
    switch_s = len(off.torque) / off.rate_hz
    return replace(
        on, switch_s=switch_s, limited=off.limited + on.limited, clipped=clipped, **stacked
    )


def _peak(motion: Array) -> Array:
    return np.asarray(np.abs(motion).max(axis=0)) if len(motion) else np.zeros(motion.shape[1])


def _rms(motion: Array) -> Array:
    if not len(motion):
        return np.zeros(motion.shape[1])
    return np.asarray(np.sqrt(np.mean(motion**2, axis=0)))
