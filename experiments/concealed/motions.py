"""How a rig moves in a test: what drives it, what acts besides, what its sensors would see."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .integrator import simulate
from .mechanisms import Mechanism, build, unmeasured
from .plans import FADE_S, FINE, FINE_HZ, Test, band_limited, waveform
from .rig import Array, Rig, System

Run = tuple[Array, Array]
"""Accelerations that ideal sensors see, (samples, floors), and states, (samples, 2 n + 1)."""


def motion(
    rig: Rig, effects: Sequence[Mechanism], test: Test, fine: bool, stride: int = 1
) -> tuple[Array, Array, Array]:
    """Return what drives a test, the floors' accelerations and the states, the effects built in.

    Args:
        rig: as built.
        effects: what is concealed.
        test: the recording.
        fine: the chain's; see ``plans.waveform``.
        stride: coarsens the integrator's grid.
    """
    drive = waveform(test, fine)[::stride]
    system = build(rig, *effects)
    acting, seen_besides = loads(system, test, drive), np.zeros((1, 1))
    if test.floor == 0:
        seen_besides = drive[:, None]
    for m in effects:
        if m.name == "unmeasured_force":
            unknown = unmeasured_waveform(m, test)[::stride]
            acting[:, : rig.storeys] += unmeasured(rig, m, unknown)
            if m.location == "ground":
                seen_besides = seen_besides + unknown[:, None]
    seen, states = simulate(system, acting, stride / FINE_HZ)
    return drive, seen + seen_besides, states


def loads(system: System, test: Test, drive: Array) -> Array:
    """Return the forces on the degrees of freedom [N], (samples, floors or more).

    A ground that is shaken acts as -m a on everything that moves with it, seen from the ground.
    """
    if test.floor == 0:
        mass = system.mass.copy()
        if system.aside >= 0:
            mass[system.aside] = 0.0
        return -np.outer(drive, mass)
    return np.outer(drive, np.eye(system.floors)[test.floor - 1])


def unmeasured_waveform(m: Mechanism, test: Test) -> Array:
    """Return the unmeasured force [N] or ground acceleration [m/s^2] of a recording."""
    rng = np.random.default_rng([test.seed, 5])
    count = (test.samples - 1) * FINE + 1
    time = np.arange(count) / FINE_HZ
    if m.form == "sine":
        phase = rng.uniform(0, 2 * np.pi)
        return np.asarray(m["rms"] * np.sqrt(2) * np.sin(2 * np.pi * m["frequency"] * time + phase))
    width = 0.2 * m["frequency"] if m.form == "narrow" else 7.25
    noise = band_limited(rng, count, FINE_HZ, m["frequency"] - width, m["frequency"] + width)
    return m["rms"] * noise * np.minimum(time / FADE_S, 1.0)
