"""The Bouc-Wen benchmark (Noel and Schoukens 2016) generated from its equations and diagnosed.

    python experiments/bouc_wen.py [--out DIR] [--official DIR] [--json FILE]

The published system, m y'' + c y' + k y + z = u with z' = alpha y' - beta (gamma |y'| z + delta y'
|z|), gives noisy training multisines and noiseless tests; a linear one-storey twin is diagnosed
with them, and the error on each test is printed beside the published ones. ``--official`` is a
folder that ``twin fetch bouc_wen`` wrote: its two test recordings then take the place of ours.

In the vocabulary's form, z' = k v (1 - |z/zy| (sign(v z) / 2 + shape)): k = alpha, zy = alpha / (2
beta gamma) = 31.25 N, shape = delta / (2 gamma) = -0.6875. A shape of 1/2 is a loop that yields;
this one stiffens, both loading and (more) unloading, so it never does.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from twin.diagnosis.pipeline import diagnose
from twin.diagnosis.result import Diagnosis
from twin.formats import read_recording, write_recording
from twin.frame import FrameDesign
from twin.frame.design import Storey
from twin.model import Twin
from twin.recording import Recording
from twin.signals.resampling import resample

Array = NDArray[np.float64]

RATE_HZ, FINE = 750.0, 20
"""Of the recordings, and steps of the integration in one sample (15 kHz, as published)."""
PERIOD = 8192
BAND_HZ, FORCE_N = (5.0, 150.0), 50.0
SWEEP_HZ, SWEEP_HZ_A_MINUTE, SWEEP_N = (20.0, 50.0), 10.0, 40.0
NOISE_M = 8e-6
MASS, DAMPING, STIFFNESS = 2.0, 10.0, 5e4
ALPHA, BETA, GAMMA, DELTA = 5e4, 1e3, 0.8, -1.1
"""The exponent nu is 1."""
FADE_S = 0.2
PUBLISHED = (
    ("best linear Koopman model", 1.60e-4),
    ("state-space neural network (Suykens)", 2.65e-5),
    ("input-affine Koopman model", 1.43e-5),
    ("polynomial nonlinear state space", 1.34e-5),
    ("state-space neural network, improved initialisation", 8.91e-6),
    ("generalised-residual state-space neural network", 7.53e-6),
)
"""Simulation RMS on the published multisine [m], compared in table 1 of Iacob, Szecsi, Beintema,
Schoukens and Toth 2025, Learning Koopman models from data under general noise conditions."""


@njit(cache=True)
def _slope(y: float, v: float, z: float, u: float) -> tuple[float, float]:
    hysteresis = ALPHA * v - BETA * (GAMMA * abs(v) * z + DELTA * v * abs(z))
    return (u - DAMPING * v - STIFFNESS * y - z) / MASS, hysteresis


@njit(cache=True)
def _integrated(force: Array, step_s: float) -> Array:
    """Return displacements from rest; force at half steps, (2 steps + 1,) -> (steps + 1,)."""
    steps = (len(force) - 1) // 2
    out = np.zeros(steps + 1)
    y = v = z = 0.0
    h = step_s
    for n in range(steps):
        a, b, c = force[2 * n], force[2 * n + 1], force[2 * n + 2]
        a1, z1 = _slope(y, v, z, a)
        a2, z2 = _slope(y + h / 2 * v, v + h / 2 * a1, z + h / 2 * z1, b)
        v2 = v + h / 2 * a1
        v3 = v + h / 2 * a2
        a3, z3 = _slope(y + h / 2 * v2, v3, z + h / 2 * z2, b)
        v4 = v + h * a3
        a4, z4 = _slope(y + h * v3, v4, z + h * z3, c)
        y += h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        z += h / 6 * (z1 + 2 * z2 + 2 * z3 + z4)
        out[n + 1] = y
    return out


def respond(force: Array, noise_m: float, seed: int, name: str) -> Recording:
    """Return a recording of the system, at rest until the force begins.

    Args:
        force: at ``2 FINE`` times the recordings' rate [N], (2 FINE samples,).
        noise_m: standard deviation of the displacement's noise [m].
        seed: of that noise.
        name: of the recording.
    """
    even = np.concatenate([force, np.zeros(1 - len(force) % 2)])
    y = resample(_integrated(even, 1 / (RATE_HZ * FINE)), RATE_HZ * FINE, RATE_HZ)
    u = force[:: 2 * FINE]
    y = y[: len(u)] + noise_m * np.random.default_rng(seed).standard_normal(len(u))
    return Recording.build(RATE_HZ, {"force_floor1": u, "disp_floor1": y}, name)


def multisine(rms_n: float, seed: int, periods: int) -> Array:
    """Return periods of a random-phase multisine [N] that fades in and out within ``FADE_S``."""
    count = 2 * FINE * PERIOD
    lines = np.fft.rfftfreq(count, 1 / (2 * FINE * RATE_HZ))
    used = (lines >= BAND_HZ[0]) & (lines <= BAND_HZ[1])
    spectrum = np.zeros(len(lines), complex)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, int(used.sum()))
    spectrum[used] = np.exp(1j * phases)
    one = np.fft.irfft(spectrum, count)
    whole = np.tile(one * (rms_n / np.sqrt(np.mean(one**2))), periods)
    fade = round(FADE_S * 2 * FINE * RATE_HZ)
    # a force that jumps is not band-limited: between the samples it would be anything
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(fade) / fade)
    whole[:fade] *= rise
    whole[-fade:] *= rise[::-1]
    return whole


def sweep() -> Array:
    """Return the linear sine sweep [N]."""
    rate = SWEEP_HZ_A_MINUTE / 60
    seconds = (SWEEP_HZ[1] - SWEEP_HZ[0]) / rate
    t = np.arange(round(seconds * RATE_HZ) * 2 * FINE) / (2 * FINE * RATE_HZ)
    return SWEEP_N * np.sin(2 * np.pi * (SWEEP_HZ[0] * t + rate / 2 * t**2))


def training(seed: int) -> list[Recording]:
    """Return noisy multisines at the published level, at half and at a tenth of it."""
    levels = (FORCE_N, FORCE_N / 2, FORCE_N / 10)
    return [
        respond(multisine(rms, seed + i, 1), NOISE_M, seed + i, f"multisine_{rms:.0f}N_{i}.csv")
        for i, rms in enumerate(levels)
    ]


def tests(official: Path | None, seed: int) -> list[Recording]:
    """Return the noiseless tests: ours, or the published ones from a folder.

    The multisine is wanted in its steady state: it runs twice, and its second period counts.
    """
    if official is None:
        return [
            respond(multisine(FORCE_N, seed + 100, 2), 0.0, 0, "test_multisine.csv"),
            respond(sweep(), 0.0, 0, "test_sweep.csv"),
        ]
    steady = read_recording(official / "bouc_wen_test_multisine.csv")
    twice = {name: np.tile(steady.column(name), 2) for name in steady.names}
    return [
        Recording.build(steady.sampling_hz, twice, "test_multisine.csv"),
        read_recording(official / "bouc_wen_test_sweep.csv"),
    ]


def linear_twin() -> Twin:
    """Return a one-storey frame with the benchmark's underlying linear system."""
    stiffness = STIFFNESS + ALPHA
    storey = Storey(floor_mass=MASS)
    storey = replace(storey, young_modulus=storey.young_modulus * stiffness / storey.stiffness)
    ratio = DAMPING / (2 * np.sqrt(stiffness * MASS))
    return Twin.of(
        FrameDesign((storey,), kind="lumped", damping_ratio=(float(ratio),), gravity=0.0)
    )


def errors(found: Diagnosis) -> dict[str, dict[str, float]]:
    """Return RMS errors of the free runs on the tests [m], by test and twin."""
    out = {}
    for trace in (t for t in found.traces if t.role == "test"):
        kept = slice(PERIOD, None) if "multisine" in trace.name else slice(None)
        out[trace.name] = {
            name: float(np.sqrt(np.nanmean((getattr(trace, name) - trace.measured)[kept] ** 2)))
            for name in ("calibrated", "explained")
        }
    return out


def result(found: Diagnosis) -> dict[str, Any]:
    """Return what is kept of a diagnosis."""
    return {
        "verdict": found.verdict,
        "findings": [
            {
                "mechanism": f.mechanism.name,
                "location": f.location,
                "values": dict(f.mechanism.values),
                "probability": f.probability,
            }
            for f in found.findings
        ],
        "rms_error_m": errors(found),
        "published_rms_error_m": {name: value for name, value in PUBLISHED},
        "seconds": found.seconds,
    }


def show(kept: dict[str, Any]) -> None:
    """Print findings and the table."""
    print(f"verdict: {kept['verdict']}")
    for finding in kept["findings"]:
        values = ", ".join(f"{k} {v:.4g}" for k, v in finding["values"].items())
        print(f"  {finding['mechanism']} at {finding['location']}: {values}")
    for test, ours in kept["rms_error_m"].items():
        rows = [(value, f"this twin, {name}") for name, value in ours.items()]
        if "multisine" in test:
            rows += [(value, name) for name, value in kept["published_rms_error_m"].items()]
        print(f"RMS error on {test} [m]")
        for value, name in sorted(rows, reverse=True):
            print(f"  {value:.3g}  {name}")
    print(f"{kept['seconds']:.0f} s")


def main(arguments: Sequence[str] | None = None) -> None:
    """Generate, diagnose, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, help="folder for the recordings and the twin")
    parser.add_argument("--official", type=Path, help="folder that `twin fetch bouc_wen` wrote")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args(arguments)
    train, test = training(chosen.seed), tests(chosen.official, chosen.seed)
    twin = linear_twin()
    if chosen.out:
        for recording in [*train, *test]:
            write_recording(recording, chosen.out / recording.source)
        twin.export(chosen.out / "bouc_wen_linear.xml")
    kept = result(diagnose(twin, train, test))
    show(kept)
    if chosen.json:
        chosen.json.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
