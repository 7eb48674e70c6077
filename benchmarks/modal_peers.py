"""Many modes from frequency responses: ours beside sdypy-EMA's least-squares complex frequency.

    pip install sdypy-EMA
    python benchmarks/modal_peers.py [--hammer FOLDER]

The plate of ``experiments/modal_test_size.py``, and hits of a metal part where their folder is
given. The peer gets H1 of the same records and, as a person would pick in its diagram, the
frequencies near which poles are to be chosen: its modes are asked for, none can be spurious. Ours
gets the records and no hint. Without sdypy-EMA the script says so and ends.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parents[1] / "experiments"))

from hammer_part import NAMES, PEER_HZ, RATE
from modal_test_size import BAND, NOISE, Plate, bound, drawn

from twin.formats import read_recording
from twin.identification.identify import identify
from twin.identification.records import prepare
from twin.modal import ModalModel
from twin.recording import Recording
from twin.signals.frf import measured_response

Array = NDArray[np.float64]

ORDER = 100
"""Highest order of the peer's polynomials."""


def peer(
    recordings: list[Recording], band: tuple[float, float], hints: Array
) -> tuple[Array, Array]:
    """Return natural frequencies [Hz] and damping ratios that sdypy-EMA finds near ``hints``."""
    from sdypy import EMA

    records = prepare(recordings)
    found = measured_response(records.pairs, recordings[0].sampling_hz)
    keep = found.frequency_hz > 0
    model = EMA.Model(
        found.H[keep, :, 0].T, found.frequency_hz[keep], lower=band[0], upper=band[1],
        pol_order_high=ORDER, frf_form="accelerance",
    )  # fmt: skip
    model.get_poles(show_progress=False)
    model.select_closest_poles(list(hints))
    return np.asarray(model.nat_freq, float), np.asarray(model.nat_xi, float)


def nearest(f: Array, modal: ModalModel) -> tuple[Array, Array]:
    """Return our frequency and damping nearest to each of some frequencies."""
    at = [int(np.argmin(np.abs(modal.natural_freq - x))) for x in f]
    return modal.natural_freq[at], modal.damping_ratio[at]


def plate(console: Console) -> None:
    made = Plate.of()
    true = made.omega / (2 * np.pi)
    recording, _ = drawn(made, 0, NOISE)
    limits = bound(made, 0)
    table = Table("plate, 40 modes", "found", "frequency", "damping", "s")

    def row(name: str, values: tuple[Array, Array], seconds: float) -> None:
        error = np.abs(values[0] - true)
        found = error < made.zeta * true
        of = [np.median(np.abs(v - t)[found] / b[found])
              for v, t, b in zip(values, (true, made.zeta), limits, strict=True)]  # fmt: skip
        table.add_row(name, str(found.sum()), f"{of[0]:.2f}", f"{of[1]:.2f}", f"{seconds:.1f}")

    start = time.perf_counter()
    modal = identify([recording], band_hz=BAND).modal
    row("ours", nearest(true, modal), time.perf_counter() - start)
    start = time.perf_counter()
    row("sdypy-EMA, given where", peer([recording], BAND, true), time.perf_counter() - start)
    console.print(table, "frequency and damping: median error over the Cramer-Rao bound")


def hammer(console: Console, folder: Path) -> None:
    hits = [read_recording(f, NAMES, RATE) for f in sorted(folder.glob("hit*.csv"))[:2]]
    hints = np.array(PEER_HZ)
    start = time.perf_counter()
    modal = identify(hits).modal
    ours, mid = nearest(hints, modal), time.perf_counter()
    theirs = peer(hits, (700.0, 6200.0), hints)
    end = time.perf_counter()
    table = Table("sdypy-EMA [Hz]", "ours [Hz]", "off [%]", "damping [%]", "ours [%]", "ratio")
    for f, g, z, y in zip(theirs[0], ours[0], theirs[1], ours[1], strict=True):
        table.add_row(
            f"{f:.2f}", f"{g:.2f}", f"{100 * (g / f - 1):+.3f}", f"{100 * z:.4f}",
            f"{100 * y:.4f}", f"{y / z:.2f}",
        )  # fmt: skip
    console.print(table, f"ours {mid - start:.1f} s, sdypy-EMA {end - mid:.1f} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hammer", type=Path, help="folder with hit1.csv, hit2.csv, ...")
    options = parser.parse_args()
    console = Console()
    try:
        from sdypy import EMA  # noqa: F401
    except ImportError:
        console.print("skipped: sdypy-EMA is not installed (pip install sdypy-EMA)")
        return
    if options.hammer:
        hammer(console, options.hammer)
    plate(console)


if __name__ == "__main__":
    main()
