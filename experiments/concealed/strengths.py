"""Strengths: from just above the noise to strong, set against the motion of the healthy rig."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .mechanisms import Mechanism
from .plans import log_uniform
from .rig import Array, Rig

MODE_CLEARANCE = 0.06
"""An appendage's frequency keeps this distance from every mode of the frame."""


@dataclass(frozen=True)
class Motion:
    """How far the healthy rig moves in the training recordings at the plan's middle level.

    Attributes:
        drift: peaks of the storeys' drifts [m].
        largest: the same, the largest of all recordings [m].
        velocity: peaks of the floors' velocities [m/s].
        acceleration: peaks of the floors' accelerations [m/s^2].
    """

    drift: Array
    largest: Array
    velocity: Array
    acceleration: Array

    @classmethod
    def of(cls, rig: Rig, runs: list[tuple[Array, Array]]) -> Motion:
        """Take the geometric mean over recordings (accelerations and states of each)."""
        n = rig.storeys
        peaks = {
            "drift": [np.abs(states[:, :n] @ rig.drifts.T).max(0) for _, states in runs],
            "velocity": [np.abs(states[:, n : 2 * n]).max(0) for _, states in runs],
            "acceleration": [np.abs(seen).max(0) for seen, _ in runs],
        }
        middle = {name: np.exp(np.mean(np.log(values), axis=0)) for name, values in peaks.items()}
        return cls(largest=np.max(peaks["drift"], axis=0), **middle)


def draw(rng: np.random.Generator, name: str, location: str, rig: Rig, motion: Motion) -> Mechanism:
    """Draw the strength of a mechanism at a place."""
    mechanism = Mechanism(name, location)
    values, form = _values(rng, mechanism, rig, motion)
    return Mechanism(name, location, tuple((k, float(v)) for k, v in values.items()), form)


def signed(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a size from [low, high], evenly in the logarithm, and a sign."""
    return float(rng.choice([-1.0, 1.0])) * log_uniform(rng, low, high)


def _values(
    rng: np.random.Generator, m: Mechanism, rig: Rig, motion: Motion
) -> tuple[dict[str, float], str]:
    if m.in_sensor:
        return _of_sensor(rng, m, motion), ""
    if m.location.startswith("storey"):
        return _of_storey(rng, m, rig, motion)
    omega = rig.modes[0]
    if m.name == "base_compliance":
        stiffness = rig.stiffnesses[0] * log_uniform(rng, 10.0, 100.0)
        ratio = log_uniform(rng, 0.005, 0.05)
        return {
            "stiffness": stiffness,
            "damping": 2 * ratio * np.sqrt(stiffness * rig.ground_mass),
        }, ""
    if m.name == "unmeasured_force":
        form = str(rng.choice(["sine", "narrow", "broad"], p=[0.6, 0.25, 0.15]))
        frequency = 7.75 if form == "broad" else log_uniform(rng, 0.7, 14.0)
        return {"rms": 1.0, "frequency": frequency}, form  # scaled by its effect later
    mass = rig.masses[m.index]
    if m.name == "mass":
        return {"change": mass * signed(rng, 0.03, 0.2)}, ""
    if m.name == "quadratic_drag":
        viscous = 2 * rig.damping_ratios[0] * omega[0] * mass * log_uniform(rng, 0.3, 4.0)
        return {"coefficient": viscous * 3 * np.pi / 8 / motion.velocity[m.index]}, ""
    frequency = log_uniform(rng, 1.2, 12.0)
    while np.any(np.abs(2 * np.pi * frequency / omega - 1) < MODE_CLEARANCE):
        frequency = log_uniform(rng, 1.2, 12.0)
    return {
        "mass": mass * log_uniform(rng, 0.01, 0.08),
        "frequency": frequency,
        "damping_ratio": log_uniform(rng, 0.005, 0.05),
    }, ""


def _of_storey(
    rng: np.random.Generator, m: Mechanism, rig: Rig, motion: Motion
) -> tuple[dict[str, float], str]:
    k, i = rig.stiffnesses[m.index], m.index
    viscous = 2 * rig.damping_ratios[0] * k / rig.modes[0][0]
    return of_spring(rng, m.name, k, motion.drift[i], motion.largest[i], viscous)


def of_spring(
    rng: np.random.Generator, name: str, k: float, d: float, largest: float, viscous: float
) -> tuple[dict[str, float], str]:
    """Draw an effect beside a spring: its parameters and its form.

    Args:
        rng: draws.
        name: of the mechanism.
        k: linear stiffness of the spring [N/m, N m/rad].
        d: middle of the recordings' largest drifts [m, rad].
        largest: of them all [m, rad].
        viscous: damping that would give the spring the first mode's [N s/m, N m s/rad].
    """
    if name == "stiffness":
        return {"change": k * signed(rng, 0.04, 0.25)}, ""
    if name == "damping":
        return {"change": viscous * log_uniform(rng, 0.3, 4.0)}, ""
    if name == "coulomb_friction":
        return {"force": k * d * log_uniform(rng, 0.006, 0.1)}, ""
    if name == "cubic_stiffness":
        if rng.random() < 0.2:  # softening: the storey keeps 70 % of its stiffness
            return {
                "stiffness": -min(k / d**2 * log_uniform(rng, 0.01, 0.1), 0.1 * k / largest**2)
            }, ""
        return {"stiffness": k / d**2 * log_uniform(rng, 0.01, 0.5)}, ""
    if name == "quadratic_stiffness":
        share = log_uniform(rng, 0.01, 0.25) / d
        return {"stiffness": k * float(rng.choice([-1, 1])) * min(share, 0.3 / largest)}, ""
    if name == "bumper":
        gap = d * float(rng.choice([-1, 1])) * rng.uniform(0.3, 0.9)
        return {"gap": gap, "stiffness": k * log_uniform(rng, 2.0, 20.0)}, ""
    if name == "clearance":
        return {"gap": d * log_uniform(rng, 0.1, 0.7), "stiffness": k * rng.uniform(0.2, 0.6)}, ""
    if name == "hysteresis":
        part = k * rng.uniform(0.15, 0.5)
        form = str(rng.choice(["bouc_wen_1", "bouc_wen_2", "jenkins"]))
        return {"stiffness": part, "yield_force": part * d * log_uniform(rng, 0.2, 0.8)}, form
    return {"rate": signed(rng, 0.01, 0.1) / 30.0}, ""


def _of_sensor(rng: np.random.Generator, m: Mechanism, motion: Motion) -> dict[str, float]:
    if m.name == "sensor_gain":
        return {"gain": rng.uniform(0.9, 0.97) if rng.random() < 0.5 else rng.uniform(1.03, 1.15)}
    if m.name == "sensor_delay":
        return {"delay": log_uniform(rng, 0.002, 0.02)}
    if m.name == "sensor_clipping":
        return {"level": motion.acceleration[m.index] * rng.uniform(0.4, 0.85)}
    if m.name == "sensor_highpass":
        return {"corner": log_uniform(rng, 0.2, 1.5)}
    return {}
