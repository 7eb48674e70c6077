"""Identification at the size of a real modal test, against the bound and the truth.

    python experiments/modal_test_size.py --draws 3

A simply supported plate with 40 modes up to 16 kHz is shaken at two points by random forces, 30
accelerometers are read at 51.2 kHz for a second, with noise of 1 % of each channel's RMS. Prints
how many modes are found and how many are spurious, the root mean square error of frequency and
damping over the Cramer-Rao bound, how often the 95 % intervals hold the truth, and what it costs.

A listed mode belongs to the true one it is nearest to, within a half bandwidth of that one; what
belongs to none, or comes second, is spurious. The bound is that of all parameters at their true
values with the true noise.
"""

from __future__ import annotations

import argparse
import resource
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy import signal

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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--first", type=int, default=0, help="seed of the first draw")
    parser.add_argument("--out", type=Path, help="file for every draw's errors, as .npz")
    options = parser.parse_args()
    console = Console()
    plate = Plate.of()
    limits = np.array(bound(plate, options.first))
    true = np.array([plate.omega / (2 * np.pi), plate.zeta])
    errors, stds = np.full((2, options.draws, 2, MODES), np.nan)
    found, spurious, seconds, cpu = [], [], [], []
    for draw in range(options.draws):
        recording, _ = drawn(plate, options.first + draw, NOISE)
        start, busy = time.perf_counter(), time.process_time()
        try:
            modal = identify([recording], band_hz=BAND).modal
        except TwinError as error:
            console.print(f"draw {draw}: {error}")
            continue
        seconds.append(time.perf_counter() - start)
        cpu.append(time.process_time() - busy)
        pairs, extra = matched(plate, modal)
        found.append(len(pairs))
        spurious.append(len(extra))
        for i, j in pairs.items():
            values = modal.natural_freq[j], modal.damping_ratio[j]
            assert modal.natural_freq_std is not None
            assert modal.damping_ratio_std is not None
            errors[draw, :, i] = np.array(values) - true[:, i]
            stds[draw, :, i] = modal.natural_freq_std[j], modal.damping_ratio_std[j]
        console.print(
            f"draw {draw}: {len(pairs)} of {MODES}, {extra} spurious, {seconds[-1]:.1f} s"
        )
    if not found:
        return
    held = np.isfinite(errors)
    ratio = np.sqrt(np.nansum(errors**2, axis=0) / np.maximum(held.sum(axis=0), 1)) / limits
    inside = np.abs(errors) <= 1.96 * stds
    cover = np.nansum(inside, axis=(0, 2)) / np.sum(held, axis=(0, 2))
    table = Table("", "frequency", "damping")
    table.add_row("RMSE / bound, all modes", *(f"{np.sqrt(np.mean(r**2)):.2f}" for r in ratio))
    table.add_row("RMSE / bound, worst mode", *(f"{r.max():.2f}" for r in ratio))
    table.add_row("std / bound, median", *(f"{x:.2f}" for x in np.nanmedian(stds / limits, (0, 2))))
    table.add_row("95 % intervals that hold the truth", *(f"{100 * c:.1f} %" for c in cover))
    console.print(table)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    console.print(
        f"{options.draws} draws: all {MODES} modes in {np.mean(np.array(found) == MODES):.0%}, "
        f"none spurious in {np.mean(np.array(spurious) == 0):.0%}, {np.mean(seconds):.1f} s "
        f"({np.mean(cpu):.1f} CPU s) a run, {memory:.2f} GB at most"
    )
    if options.out:
        np.savez(
            options.out, errors=errors, stds=stds, bound=limits, found=found, spurious=spurious
        )


if __name__ == "__main__":
    main()
