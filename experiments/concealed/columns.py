"""What each mechanism adds to the outputs along a motion: the columns of a rival's regression."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit
from scipy.fft import irfft, rfft

from . import laws
from .chain import at_sensor
from .likelihood import RATE, Likelihood
from .mechanisms import Mechanism, law_of
from .motions import Run
from .rig import Array, Rig

STEP = 0.03
"""Relative change of a parameter for its derivative."""


def columns(likelihood: Likelihood, m: Mechanism, runs: Sequence[Run]) -> Array:
    """Return what a mechanism adds to all outputs along a motion, whitened."""
    r = likelihood.rehearsal
    outputs = []
    for i, (seen, states) in enumerate(runs):
        if m.in_sensor and m.location.startswith("acc_"):
            outputs.append(at_sensor(seen, m, rate=RATE) - seen)
        elif m.in_sensor:
            driven = r.tests[i].input == m.location
            outputs.append((1 - m["gain"]) * r.healthy[i][0] * driven)
        elif m.name == "base_compliance":
            shaken = r.rig.stiffnesses[0] / m["stiffness"] * seen[:, :1]
            outputs.append(likelihood.response(i, -shaken * r.rig.masses) + shaken)
        else:
            outputs.append(likelihood.response(i, force(r.rig, m, seen, states)))
    return likelihood.whitened(outputs)


def change(likelihood: Likelihood, effects: Sequence[Mechanism], runs: Sequence[Run]) -> Array:
    """Return the difference from a healthy rig under the recorded input, whitened."""
    r = likelihood.rehearsal
    gains = {m.location: m["gain"] for m in effects if m.name == "sensor_gain"}
    outputs = [
        at_sensor(seen, *effects, rate=RATE) - gains.get(test.input, 1.0) * healthy
        for test, (seen, _), (healthy, _) in zip(r.tests, runs, r.healthy, strict=True)
    ]
    return likelihood.whitened(outputs)


def tangent(likelihood: Likelihood, m: Mechanism, runs: Sequence[Run]) -> list[Array]:
    """Return a mechanism's column and its derivatives by its parameters."""
    found = [columns(likelihood, m, runs)]
    for name, value in m.parameters if len(m.parameters) > 1 else ():
        other = tuple((k, v * (1 + STEP) if k == name else v) for k, v in m.parameters)
        changed = columns(likelihood, replace(m, parameters=other), runs)
        found.append((changed - found[0]) / (STEP * abs(value) or 1.0))
    return found


def frame(likelihood: Likelihood, runs: Sequence[Run]) -> list[Array]:
    """Return the columns of all masses, and of the storeys' stiffnesses and dampings."""
    rig = likelihood.rehearsal.rig
    found = []
    for i in range(1, rig.storeys + 1):
        changed = [("mass", f"floor{i}"), ("stiffness", f"storey{i}"), ("damping", f"storey{i}")]
        for name, place in changed:
            found.append(columns(likelihood, Mechanism(name, place, (("change", 1.0),)), runs))
    return found


def force(rig: Rig, m: Mechanism, seen: Array, states: Array) -> Array:
    """Return the forces on the floors along a motion [N], (samples, floors)."""
    n = rig.storeys
    floor = np.eye(n)[m.index]
    if m.name == "mass":
        return -m["change"] * np.outer(seen[:, m.index], floor)
    if m.name == "appendage":
        return np.outer(_of_appendage(m, seen[:, m.index]), floor)
    drift = np.ascontiguousarray(states[:, :n] @ rig.drifts[m.index])
    rate = np.ascontiguousarray(states[:, n : 2 * n] @ rig.drifts[m.index])
    if m.name in ("stiffness", "damping"):
        pull = m["change"] * (drift if m.name == "stiffness" else rate)
        return -np.outer(pull, rig.drifts[m.index])
    code, parameters = law_of(rig, m)
    p = np.zeros(laws.WIDTH)
    p[: len(parameters)] = parameters
    if code == laws.DRAG:
        velocity = np.ascontiguousarray(states[:, n + m.index])
        return -np.outer(_along(code, p, drift, velocity, 1 / RATE), floor)
    return -np.outer(_along(code, p, drift, rate, 1 / RATE), rig.drifts[m.index])


@njit(cache=True)
def _along(code, p, drift, rate, step):  # type: ignore[no-untyped-def]
    """Return a law's force along a motion; what slips is carried on."""
    out = np.empty(len(drift))
    z = 0.0
    for k in range(len(drift)):
        if code == laws.COULOMB:
            out[k] = p[0] * np.sign(rate[k])
            continue
        if k > 0 and code == laws.JENKINS:
            z = laws.slider(p, drift[k], drift[k - 1], z)
        elif k > 0 and code == laws.BOUC_WEN:
            moved = drift[k] - drift[k - 1]
            z = min(max(z + laws.slip_rate(code, p, moved, z), -p[1]), p[1])
        out[k] = laws.force(code, p, drift[k], rate[k], z, k * step)
    return out


def _of_appendage(m: Mechanism, acceleration: Array) -> Array:
    """Return the force of a small oscillator on its floor [N]."""
    length = 2 * len(acceleration)
    s = 2j * np.pi * np.fft.rfftfreq(length, 1 / RATE)
    omega, ratio = 2 * np.pi * m["frequency"], m["damping_ratio"]
    pulled = 2 * ratio * omega * s + omega**2
    spectrum = -m["mass"] * pulled / (s**2 + pulled) * rfft(acceleration, length)
    return np.asarray(irfft(spectrum, length)[: len(acceleration)])
