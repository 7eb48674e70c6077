"""Identification at the size of a real modal test, against the bound and the truth.

    python experiments/modal_test_size.py --draws 100 --out modal_test_size.jsonl --json FILE

A simply supported plate with 40 modes up to 16 kHz is shaken at two points by random forces, 30
accelerometers are read at 51.2 kHz for a second, with noise of 1 % of each channel's RMS. Prints
how many modes are found and how many are spurious, the root mean square error of frequency and
damping over the Cramer-Rao bound, how often the 95 % intervals hold the truth, and what it costs.

A listed mode belongs to the true one it is nearest to, within a half bandwidth of that one; what
belongs to none, or comes second, is spurious. The bound is that of all parameters at their true
values with the true noise and the forces of that draw. Resumable: the file of ``--out`` keeps
what is done.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy import signal

from twin.campaign import campaign
from twin.errors import TwinError
from twin.identification.identify import identify
from twin.identification.records import prepare
from twin.identification.separable import project, start_drive
from twin.identification.separable_terms import Terms
from twin.identification.wide_band import POWERS
from twin.modal import ModalModel
from twin.recording import Recording

Array = NDArray[np.float64]

RATE = 51_200.0
SAMPLES = 51_200
MODES, OUTPUTS, INPUTS = 40, 30, 2
TOP_HZ = 16_000.0
NOISE = 0.01
ASPECT = 1.37
"""Length over width of the plate, squared ratios of whole numbers are far from it: no mode is
double, as on a square plate."""
BAND = (100.0, 18_000.0)


@dataclass(frozen=True)
class Plate:
    """Modes of a simply supported plate at sensors and shakers.

    Attributes:
        omega: natural angular frequencies [rad/s], (modes,).
        zeta: damping ratios, (modes,).
        shapes: at the sensors, (outputs, modes).
        drive: at the shakers, (modes, inputs).

    Source: Leissa 1969, Vibration of Plates, section 4.1.
    """

    omega: Array
    zeta: Array
    shapes: Array
    drive: Array

    @classmethod
    def of(cls, seed: int = 0) -> Plate:
        """Draw damping, sensors and shakers of the plate."""
        rng = np.random.default_rng(seed)
        m, n = (x.ravel() for x in np.meshgrid(np.arange(1, 20), np.arange(1, 20)))
        size = m**2 + (ASPECT * n) ** 2
        first = np.argsort(size)[:MODES]
        m, n, size = m[first], n[first], size[first]
        zeta = rng.uniform(0.001, 0.004, MODES)
        points = rng.uniform(0.05, 0.95, (OUTPUTS + INPUTS, 2))
        shapes = np.sin(np.pi * np.outer(points[:, 0], m)) * np.sin(
            np.pi * np.outer(points[:, 1], n)
        )
        omega = 2 * np.pi * TOP_HZ * size / size.max()
        return cls(omega, zeta, shapes[:OUTPUTS], shapes[OUTPUTS:].T)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Continuous-time poles [rad/s], (modes,)."""
        return self.omega * (-self.zeta + 1j * np.sqrt(1 - self.zeta**2))

    def accelerations(self, u: Array) -> Array:
        """Return what the sensors read of forces that are held between samples, (samples, m)."""
        y = np.zeros((len(u), OUTPUTS))
        for i, pole in enumerate(self.poles):
            decay = np.exp(pole / RATE)
            x = signal.lfilter([0, 1], [1, -decay], (u @ self.drive[i]).astype(complex))
            # s^2 / (s^2 + ...) less its direct term: residue pole / (2j) up to a factor of one.
            y += np.outer(np.real(pole / abs(pole) * 1j * x), self.shapes[:, i])
        return y


def drawn(plate: Plate, seed: int, noise: float) -> tuple[Recording, Array]:
    """Return a recording and the standard deviation of each output's noise."""
    rng = np.random.default_rng([1, seed])
    u = rng.standard_normal((SAMPLES, INPUTS))
    y = plate.accelerations(u)
    level = NOISE * np.sqrt(np.mean(y**2, axis=0))
    y = y + noise / NOISE * level * rng.standard_normal(y.shape)
    columns = {f"force_s{i + 1} [N]": u[:, i] for i in range(INPUTS)}
    columns |= {f"acc_p{o + 1} [m/s^2]": y[:, o] for o in range(OUTPUTS)}
    return Recording.build(RATE, columns, source=f"plate, draw {seed}"), level


def bound(plate: Plate, seed: int) -> tuple[Array, Array]:
    """Return the Cramer-Rao bounds of frequencies [Hz] and damping ratios, (modes,) each."""
    recording, level = drawn(plate, seed, 0.0)
    terms = Terms(
        tuple(prepare([recording]).wide_spectra(BAND)), "held", POWERS, 2 * np.pi * BAND[1]
    )
    drive = start_drive(plate.poles, terms, np.ones((len(terms.Y), 1)))
    done = project(drive, terms, np.broadcast_to(1 / level, terms.Y.shape))
    assert done.gram is not None
    std = np.sqrt(np.diag(np.linalg.inv(done.gram))).reshape(*drive.v.shape, 2)[:, 0]
    return std[:, 0] * plate.omega / (2 * np.pi), std[:, 1] * plate.zeta


def matched(plate: Plate, modal: ModalModel) -> tuple[dict[int, int], list[str]]:
    """Return true mode -> listed mode, and the frequencies of those that are spurious."""
    f = plate.omega / (2 * np.pi)
    pairs: dict[int, int] = {}
    for i in range(len(f)):
        j = int(np.argmin(np.abs(modal.natural_freq - f[i])))
        if abs(modal.natural_freq[j] - f[i]) < plate.zeta[i] * f[i] and j not in pairs.values():
            pairs[i] = j
    others = [f"{x:.1f}" for j, x in enumerate(modal.natural_freq) if j not in pairs.values()]
    return pairs, others


def one(plate: Plate, seed: int) -> dict[str, Any]:
    """Identify one draw.

    Returns:
        errors, stds: over the bounds, of frequencies and damping ratios, (2, modes), None for a
            mode that is missed; found, spurious: how many; seconds, cpu; error: if it failed.
    """
    recording, _ = drawn(plate, seed, NOISE)
    start, busy = time.perf_counter(), time.process_time()
    try:
        modal = identify([recording], band_hz=BAND).modal
    except TwinError as error:
        return {"error": str(error), "found": 0, "spurious": 0}
    seconds, cpu = time.perf_counter() - start, time.process_time() - busy
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    limits = bound(plate, seed)
    pairs, extra = matched(plate, modal)
    errors: list[list[float | None]] = [[None] * MODES, [None] * MODES]
    stds: list[list[float | None]] = [[None] * MODES, [None] * MODES]
    for row, (value, std, true) in enumerate((
        (modal.natural_freq, modal.natural_freq_std, plate.omega / (2 * np.pi)),
        (modal.damping_ratio, modal.damping_ratio_std, plate.zeta),
    )):  # fmt: skip
        assert std is not None
        for i, j in pairs.items():
            errors[row][i] = float((value[j] - true[i]) / limits[row][i])
            stds[row][i] = float(std[j] / limits[row][i])
    return {
        "found": len(pairs), "spurious": len(extra), "at": extra, "seconds": seconds, "cpu": cpu,
        "memory_gb": memory, "errors": errors, "stds": stds,
    }  # fmt: skip


def summary(results: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return what all draws say together."""
    rows = [r for r in results.values() if "errors" in r]
    errors = np.array([r["errors"] for r in rows], float)
    stds = np.array([r["stds"] for r in rows], float)
    ratio = np.sqrt(np.nanmean(errors**2, axis=0))
    held = np.isfinite(errors)
    cover = np.sum(np.abs(errors) <= 1.96 * stds, axis=(0, 2)) / np.sum(held, axis=(0, 2))
    return {
        "draws": len(results),
        "all_found": float(np.mean([r["found"] == MODES for r in results.values()])),
        "none_spurious": float(np.mean([r["spurious"] == 0 for r in results.values()])),
        "rmse_over_bound": np.sqrt(np.nanmean(errors**2, axis=(0, 2))).tolist(),
        "worst_over_bound": ratio.max(axis=1).tolist(),
        "above_1.2": np.sum(ratio > 1.2, axis=1).tolist(),
        "std_over_bound": np.nanmedian(stds, axis=(0, 2)).tolist(),
        "coverage": cover.tolist(),
        "seconds": float(np.median([r["seconds"] for r in rows])),
        "cpu": float(np.median([r["cpu"] for r in rows])),
        "memory_gb": float(max(r["memory_gb"] for r in rows)),
        "rmse_over_bound_of_modes": ratio.tolist(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--first", type=int, default=0, help="seed of the first draw")
    parser.add_argument("--out", type=Path, help="file that keeps the draws, to go on from")
    parser.add_argument("--json", type=Path, help="file for the summary")
    options = parser.parse_args()
    console = Console()
    tasks = {f"draw {seed}": seed for seed in range(options.first, options.first + options.draws)}
    results = campaign(
        partial(one, Plate.of()), tasks, results=options.out, identity="modal test size",
        progress=lambda done, of: console.print(f"{done} of {of} draws"),
    )  # fmt: skip
    for name, row in results.items():
        if row["found"] < MODES or row["spurious"]:
            console.print(name, row.get("error", f"{row['found']} found, spurious {row.get('at')}"))
    if all("error" in row for row in results.values()):
        return
    found = summary(results)
    table = Table("", "frequency", "damping")
    for title, key in (
        ("RMSE / bound, all modes", "rmse_over_bound"),
        ("RMSE / bound, worst mode", "worst_over_bound"),
        ("std / bound, median", "std_over_bound"),
        ("95 % intervals that hold the truth", "coverage"),
    ):
        table.add_row(title, *(f"{x:.3f}" for x in found[key]))
    console.print(table)
    console.print(
        f"{found['draws']} draws: all {MODES} modes in {found['all_found']:.0%}, none spurious in "
        f"{found['none_spurious']:.0%}, {found['seconds']:.1f} s ({found['cpu']:.1f} CPU s) a run, "
        f"{found['memory_gb']:.2f} GB at most"
    )
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
