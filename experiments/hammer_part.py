"""Modes of a lightly damped metal part from two hammer hits, judged on a third.

    python experiments/hammer_part.py ../shared/data/hammer_part

Each hit is left out once. Prints the listed modes nearest to the fourteen that sdypy-EMA finds,
the error on the hit that was left out (700 to 6200 Hz), and the time. A listed mode is spurious
where the hit that was left out, identified alone, has none within the mode's half bandwidth or
the interval of either frequency; the part has more modes than the fourteen.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from twin.formats import read_recording
from twin.identification.discrete import predict
from twin.identification.identify import identify
from twin.identification.records import prepare
from twin.identification.result import band_error
from twin.modal import ModalModel

RATE = 25_600.0
NAMES = {"force": "force [N]", "acceleration": "acc [m/s^2]"}
BAND = (700.0, 6200.0)
PEER_HZ = (
    810.5, 900.0, 1518.1, 2066.5, 2640.2, 3007.3, 3035.8, 3668.7, 4127.6, 4163.7, 4391.5, 4470.0,
    5030.0, 5969.0,
)  # fmt: skip


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "../shared/data/hammer_part")
    console = Console()
    files = sorted(folder.glob("hit*.csv"))
    if len(files) < 3:
        console.print(f"{folder}: no three hits here; give their folder as the argument")
        return
    hits = [read_recording(file, NAMES, RATE) for file in files]
    alone = [identify([hit]).modal for hit in hits]
    for left_out in range(len(hits)):
        train = [hit for i, hit in enumerate(hits) if i != left_out]
        wall, cpu = time.perf_counter(), time.process_time()
        found = identify(train)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        records = prepare([hits[left_out]], found.inputs, found.outputs)
        u, y = records.pairs[0]
        limits = (2 * np.pi * BAND[0], 2 * np.pi * BAND[1])
        error = band_error([y], [predict(found.fit, u, y, records.dt)], records.dt, limits)
        table = Table("peers [Hz]", "here [Hz]", "off [%]", "damping [%]", "std [%]")
        for peer in PEER_HZ:
            i = int(np.argmin(np.abs(found.modal.natural_freq - peer)))
            f = found.modal.natural_freq[i]
            damping, std = found.modal.damping_ratio[i], found.modal.damping_ratio_std[i]
            table.add_row(
                f"{peer:.1f}", f"{f:.2f}", f"{100 * (f / peer - 1):+.3f}", f"{100 * damping:.4f}",
                f"{100 * std:.4f}",
            )  # fmt: skip
        console.print(table)
        missing = unconfirmed(found.modal, alone[left_out])
        worst = max(abs(found.modal.natural_freq - peer).min() / peer for peer in PEER_HZ)
        named = ", ".join(f"{f:.1f}" for f in missing) or "none"
        console.print(
            f"{hits[left_out].source} left out: error {100 * error:.2f} % of RMS, frequencies "
            f"within {100 * worst:.3f} % of the peers'; {len(found.modal.natural_freq)} modes, of "
            f"which that hit alone does not confirm {named}; {wall:.1f} s, {cpu:.1f} CPU s\n"
        )


def unconfirmed(modal: ModalModel, other: ModalModel) -> list[float]:
    """Return the frequencies of modes that an identification of other data lacks [Hz]."""
    missing = []
    for f, zeta, std in zip(
        modal.natural_freq, modal.damping_ratio, modal.natural_freq_std, strict=True
    ):
        off = np.abs(other.natural_freq - f)
        interval = 1.96 * np.hypot(std, other.natural_freq_std[np.argmin(off)])
        if off.min() > max(zeta * f, interval):
            missing.append(float(f))
    return missing


if __name__ == "__main__":
    main()
