"""Strengths of effects in a structure, and how well recordings could show them.

An effect is taken where it changes some training recording by more than ``VISIBLE`` times the
noise, where no calibration of springs, dashpots and masses takes it up, and where no neighbouring
place would do as well; the last two by the log likelihood that is lost with white noise on the
channels (half the sum of squares, in nats). It has to be physical, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..chain import Chain
from ..mechanisms import Mechanism
from ..plans import SAMPLING_HZ, log_uniform
from ..strengths import MODE_CLEARANCE, of_spring, signed
from .effects import moved
from .kinds import Kind
from .measuring import at_sensors
from .plan import Trial
from .structure import Array, Structure

VISIBLE = 3.0
LEFT_NATS = 50.0
FARTHEST = 4.0
"""No drift goes beyond so many times the healthy one."""
PARAMETERS = ("stiffness", "damping", "mass")


@dataclass(frozen=True)
class Bench:
    """A structure as built, its training tests, and how it answers with nothing concealed.

    Attributes:
        kind: its table.
        structure: as built.
        trials: the training tests.
        chain: how they are measured.
        inputs: by trial, sampled, (samples, inputs).
        healthy: by trial, what the channels give, sampled, (samples, channels).
        drift: middle and largest of the recordings' peaks by drift [m, rad].
        speed: middle of the peaks by point [m/s].
        scale: of the noise by trial, (channels,).
    """

    kind: Kind
    structure: Structure
    trials: tuple[Trial, ...]
    chain: Chain
    inputs: tuple[Array, ...]
    healthy: tuple[Array, ...]
    drift: dict[str, tuple[float, float]]
    speed: dict[str, float]
    scale: tuple[Array, ...]

    @classmethod
    def of(cls, kind: Kind, structure: Structure, trials: tuple[Trial, ...], chain: Chain) -> Bench:
        """Run the tests."""
        runs = [moved(structure, (), trial, kind.kit) for trial in trials]
        n = structure.size
        inputs = tuple(chain.sampled(np.column_stack(list(run[0].values()))) for run in runs)
        healthy = tuple(chain.sampled(np.column_stack(list(run[1].values()))) for run in runs)

        def middle(peaks: list[float]) -> float:
            moving = [peak for peak in peaks if peak > 0] or [1.0]
            return float(np.exp(np.mean(np.log(moving))))

        def peaks(row: Array, first: int) -> list[float]:
            return [float(np.abs(run[2][:, first : first + n] @ row).max()) for run in runs]

        drift = {name: (middle(peaks(row, 0)), max(peaks(row, 0)))
                 for name, row in structure.drifts.items()}  # fmt: skip
        speed = {name: middle(peaks(p.row, n)) for name, p in structure.motions.items()}
        noise = chain.noise * np.array(
            [kind.encoder if s.unit == "m" else 1.0 for s in structure.sensors.values()]
        )
        scale = tuple(noise * np.sqrt(np.mean(seen**2, axis=0)) + 1e-12 for seen in healthy)
        return cls(kind, structure, trials, chain, inputs, healthy, drift, speed, scale)

    def change(self, effects: Sequence[Mechanism]) -> tuple[Array, float]:
        """Return what effects change over the noise, (samples, channels), and how far they drift.

        The first is stacked over the trials; of a drive, whose loop hides the change, it is that
        of the force that the loop asks for.
        """
        changes, farthest = [], 0.0
        every = zip(self.trials, self.healthy, self.inputs, self.scale, strict=True)
        for trial, before, given, scale in every:
            inputs, seen, states = moved(self.structure, effects, trial, self.kind.kit)
            if self.kind.kit.loop is not None:
                force = self.chain.sampled(np.column_stack(list(inputs.values())))
                level = self.chain.noise * np.sqrt(np.mean(given**2, axis=0))
                changes.append((force - given) / level)
            else:
                after = self.chain.sampled(at_sensors(seen, effects))
                changes.append((after - before) / scale)
            n = self.structure.size
            for name, row in self.structure.drifts.items():
                reach = np.abs(states[:, :n] @ row).max() / self.drift[name][1]
                farthest = max(farthest, float(reach)) if np.isfinite(reach) else np.inf
        return np.vstack(changes), farthest

    def calibrations(self) -> Array:
        """Return what small changes of springs, dashpots and masses change, (values, columns).

        By the frequency response, on twice the length with nothing in the second half.
        """
        s = self.structure
        mine = [name for name in s.drifts if "_column" not in name]
        springs = [np.outer(s.drifts[name], s.drifts[name]) for name in mine]
        masses = [sum(np.outer(p.row, p.row) for p in b.points) for b in s.bodies.values()]
        see_a = np.array([sensor.acc for sensor in s.sensors.values()])
        see_d = np.array([sensor.disp for sensor in s.sensors.values()])
        columns: list[list[Array]] = [[] for _ in range(2 * len(springs) + len(masses))]
        for trial, given, scale in zip(self.trials, self.inputs, self.scale, strict=True):
            length = 2 * len(given)
            omega = 2 * np.pi * np.fft.rfftfreq(length, 1 / SAMPLING_HZ)
            rows = np.array([
                -s.shaken[name].coupling if trial.kind == "ground" else s.drives[name].row
                for name in trial.inputs
            ])  # fmt: skip
            iw = 1j * omega[:, None, None]
            dynamic = iw**2 * s.mass + iw * s.damping + s.stiffness
            inverse = np.linalg.inv(dynamic)
            q = np.einsum("fij,fj->fi", inverse, np.fft.rfft(given, length, axis=0) @ rows)
            see = iw**2 * see_a + see_d
            w = 1j * omega[:, None]
            forces = [
                *(q @ k for k in springs), *(w * (q @ k) for k in springs),
                *(w**2 * (q @ np.asarray(m)) for m in masses),
            ]  # fmt: skip
            for column, force in zip(columns, forces, strict=True):
                seen = np.einsum("fci,fi->fc", see, np.einsum("fij,fj->fi", inverse, force))
                back = np.fft.irfft(seen, length, axis=0)[: len(given)] / scale
                column.append(back.ravel())
        return np.column_stack([np.concatenate(column) for column in columns])


def left(change: Array, columns: Array) -> float:
    """Return half the sum of squares that is left after the best combination of columns [nats]."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    fit, *_ = np.linalg.lstsq(scaled, change, rcond=1e-10)
    return float(np.sum((change - scaled @ fit) ** 2) / 2)


def draw(rng: np.random.Generator, name: str, place: str, bench: Bench) -> Mechanism:
    """Draw the strength of a mechanism at a place."""
    values, form = _values(rng, name, place, bench)
    return Mechanism(name, place, tuple((k, float(v)) for k, v in values.items()), form)


def _values(
    rng: np.random.Generator, name: str, place: str, bench: Bench
) -> tuple[dict[str, float], str]:
    s = bench.structure
    omega = s.modes()[0]
    if name == "sensor_gain":
        low = rng.random() < 0.5
        return {"gain": rng.uniform(0.85, 0.95) if low else rng.uniform(1.05, 1.2)}, ""
    if name == "sensor_delay":
        return {"delay": log_uniform(rng, 0.002, 0.02)}, ""
    if name == "sensor_polarity":
        return {}, ""
    if name == "mass":
        low, high = (0.1, 0.6) if "_load" in place else (0.03, 0.2)
        return {"change": s.bodies[place].kg * signed(rng, low, high)}, ""
    if name == "base_compliance":
        k = _base_scale(s) * log_uniform(rng, 3.0, 40.0)
        ratio = log_uniform(rng, 0.005, 0.05)
        return {"stiffness": k, "damping": 2 * ratio * np.sqrt(k * s.ground_mass)}, ""
    if name == "unmeasured_force":
        top = bench.kind.kit.band_hz[1] or 5.0
        form = str(rng.choice(["sine", "narrow"], p=[0.7, 0.3]))
        level = bench.kind.kit.rms_n[1] or 30.0
        rms = level * log_uniform(rng, 0.02, 0.5)
        return {"rms": rms, "frequency": log_uniform(rng, 0.7, 0.8 * top)}, form
    if name == "quadratic_drag":
        row = s.row(place)
        kg = 1.0 / float(row @ np.linalg.inv(s.mass) @ row)
        viscous = _ratio(s) * max(omega[0], 1.0) * kg * log_uniform(rng, 0.5, 8.0)
        return {"coefficient": viscous * 3 * np.pi / 8 / bench.speed[place]}, ""
    if name == "appendage":
        row = s.row(place)
        kg = 1.0 / float(row @ np.linalg.inv(s.mass) @ row)
        frequency = log_uniform(rng, 1.5, 0.8 * bench.kind.kit.band_hz[1])
        while np.any(np.abs(2 * np.pi * frequency / omega - 1) < MODE_CLEARANCE):
            frequency = log_uniform(rng, 1.5, 0.8 * bench.kind.kit.band_hz[1])
        share, ratio = log_uniform(rng, 0.02, 0.15), log_uniform(rng, 0.005, 0.05)
        return {"mass": kg * share, "frequency": frequency, "damping_ratio": ratio}, ""
    middle, largest = bench.drift[place]
    k = s.scales[place]
    viscous = float(s.damping[0, 0]) if omega[0] == 0 else _ratio(s) * k / omega[0]
    return of_spring(rng, name, k, middle, largest, viscous)


def _ratio(s: Structure) -> float:
    """Return twice the first mode's damping ratio."""
    omega, shapes = s.modes()
    first = shapes[:, 0]
    return float(first @ s.damping @ first / omega[0]) if omega[0] > 0 else 0.1


def _base_scale(s: Structure) -> float:
    """Return the stiffness that lets the whole structure sway as slowly as its first mode [N/m]."""
    return float(s.modes()[0][0] ** 2 * max(shaking.mass for shaking in s.shaken.values()))


def neighbours(name: str, place: str, s: Structure) -> list[str]:
    """Return the places that an effect could be taken for."""
    if name == "mass":
        return [other for other in s.bodies if other != place][:6]
    if place not in s.drifts:
        return []
    if place.startswith("hinge"):
        number = int(place.removeprefix("hinge"))
        return [f"hinge{i}" for i in (number - 1, number + 1) if f"hinge{i}" in s.drifts]
    storey, axis = place.split("_")[0], place.split("_")[-1]
    return [p for p in s.drifts
            if p != place and p.startswith(storey) and p.endswith(f"_{axis}")]  # fmt: skip


def weigh(bench: Bench, m: Mechanism, change: Array, calibrations: Array) -> dict[str, float]:
    """Return what calibrating and what each neighbouring place would leave of an effect [nats]."""
    flat = change.ravel()
    found = {"nats": float(np.sum(flat**2) / 2)}
    if m.name not in PARAMETERS and not m.in_sensor and len(calibrations):
        found["left_by_calibration"] = left(flat, calibrations)
    if m.name in (*PARAMETERS, *_LAWS):
        for place in neighbours(m.name, m.location, bench.structure):
            other = Mechanism(m.name, place, m.parameters, m.form)
            if m.name == "mass":
                ratio = bench.structure.bodies[place].kg / bench.structure.bodies[m.location].kg
                other = Mechanism(m.name, place, (("change", m["change"] * min(ratio, 1.0)),))
            there, _ = bench.change([other])
            if np.all(np.isfinite(there)):
                found[f"left_at_{place}"] = left(flat, there.ravel()[:, None])
    return found


_LAWS = (
    "coulomb_friction", "cubic_stiffness", "quadratic_stiffness", "bumper", "clearance",
    "hysteresis", "stiffness_drift",
)  # fmt: skip


def shows(bench: Bench, change: Array) -> float:
    """Return the largest change of a training recording over its noise (RMS over channels)."""
    size, start = 0.0, 0
    for before in bench.healthy:
        part = change[start : start + len(before)]
        size, start = max(size, float(np.sqrt(np.mean(part**2)))), start + len(before)
    return size
