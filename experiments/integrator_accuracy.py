"""Simulated free decay against the model's eigenvalues: error of frequency and damping.

    python experiments/integrator_accuracy.py

Every shipped model, ground clamped and released, as shipped and at other physics steps. The decay
is analysed by vector Prony, which is exact for a sum of damped modes: what is left is the error of
the simulation. The claim is 0.02 % at the shipped step.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from twin.frame import PLANE
from twin.modal import poles_to_modal
from twin.model import Twin

Array = NDArray[np.float64]

LIMIT = 0.02
RATE = 125.0
STEPS = (0.0005, 0.001, 0.002, 0.004, 0.008)


def decay_modes(decay: Array, rate_hz: float) -> tuple[Array, Array]:
    """Return frequencies [Hz] and damping ratios of a free decay without noise.

    With as many outputs as modes, y(k + 2 lag) is a linear function of y(k + lag) and y(k); the
    eigenvalues of that recursion are the poles. The lag of 30 ms keeps the samples apart; it is
    below half a period of every mode up to 16 Hz.

    Args:
        decay: accelerations or angles, (samples, outputs).
        rate_hz: samples per second.
    """
    decay = decay / np.abs(decay).max(axis=0)
    lag = max(1, int(0.03 * rate_hz))
    n = decay.shape[1]
    past = np.hstack([decay[: -2 * lag], decay[lag:-lag]])
    recursion = np.zeros((2 * n, 2 * n))
    recursion[:n, n:] = np.eye(n)
    recursion[n:] = np.linalg.lstsq(past, decay[2 * lag :], rcond=None)[0].T
    poles = np.linalg.eigvals(recursion).astype(complex)
    poles = np.log(poles[poles.imag > 0]) * rate_hz / lag
    return poles_to_modal(poles[np.argsort(np.abs(poles))])


def free_decay(twin: Twin, rate_hz: float = RATE, seconds: float = 20.0) -> Array:
    """Return accelerations, and the pendulum's angle, after a light tap on floor 1.

    The tap of 2e-5 N s is so light that the geometry of the flexible beams stays linear.
    """
    samples = int(seconds * rate_hz)
    tap = np.zeros(samples)
    tap[1] = 2e-5 * rate_hz
    columns = twin.simulate({"force_floor1": tap}, rate_hz, samples).columns
    names = [f"acc_{place}" for place in twin.floors]
    names += ["acc_ground"] * (not twin.clamped)
    names += [name for name in columns if name.startswith("angle")]
    return np.column_stack([columns[name] for name in names])[3:]


def errors(twin: Twin, rate_hz: float = RATE) -> tuple[Array, Array]:
    """Return the errors of frequency and damping ratio of all modes [%], signed."""
    freq, damping = decay_modes(free_decay(twin, rate_hz), rate_hz)
    true = twin.modes()
    return 100 * (freq / true.natural_freq - 1), 100 * (damping / true.damping_ratio - 1)


def with_step(twin: Twin, step: float) -> Twin:
    """Return the twin with another physics step [s]."""
    mjcf, found = re.subn(r'timestep="[^"]*"', f'timestep="{step!r}"', twin.mjcf)
    assert found == 1
    return Twin(mjcf, twin.source, twin.clamped)


def _row(table: Table, label: tuple[str, ...], twin: Twin) -> float:
    freq, damping = errors(twin)
    worst = float(np.max(np.abs([freq, damping])))
    joined = [" ".join(f"{value:+.5f}" for value in values) for values in (freq, damping)]
    table.add_row(*label, *joined, "yes" if worst <= LIMIT else "no")
    return worst


def main() -> None:
    console = Console(width=130, highlight=False)
    heads = ("frequency error [%]", "damping error [%]", f"within {LIMIT} %")
    table = Table("model", "ground", *heads, title="models as shipped")
    worst = 0.0
    for name in PLANE:
        twin = Twin.load(name)
        worst = max(worst, _row(table, (name, "clamped"), twin))
        worst = max(worst, _row(table, (name, "released"), twin.released()))
    console.print(table)
    console.print(f"largest error: {worst:.5f} %\n")
    table = Table("model", "physics rate [Hz]", *heads, title="other steps, ground clamped")
    for name in PLANE:
        for step in STEPS:
            _row(table, (name, f"{1 / step:g}"), with_step(Twin.load(name), step))
    console.print(table)
    if worst > LIMIT:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
