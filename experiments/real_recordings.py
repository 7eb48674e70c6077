"""Identification of two real structures: an F-16's ground vibration test and a robot arm.

    python experiments/real_recordings.py ../shared/data

Prints modes with standard deviations and the error on periods (F-16) or the part of the record
(robot arm) that the fit has not seen.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from twin.formats import read_recording
from twin.identification.identify import identify
from twin.identification.result import Identification
from twin.identification.unseen import unseen_nrmse
from twin.recording import Recording
from twin.signals.periods import last_periods, mean_period

F16 = Path("f16_gvt/F16Data_FullMSine_Level1.csv")
F16_PERIOD = 8192
F16_MAP = {"Force": "force_floor1 [N]"} | {
    f"Acceleration{i}": f"acc_floor{i} [m/s^2]" for i in (1, 2, 3)
}
ARM = Path("robot_arm/robot_arm.csv")
ARM_MAP = {"u": "force_floor1 [N]", "y": "acc_floor1 [m/s^2]"}


def f16(folder: Path) -> tuple[Identification, dict[str, float]]:
    """Fit periods 2 to 6, look at periods 7 to 9."""
    recording = read_recording(folder / F16, F16_MAP, 400.0)
    found = identify([mean_period(recording, F16_PERIOD, unseen=3)])
    kept: Recording = last_periods(recording, F16_PERIOD, 3)
    return found, {"periods 7 to 9": unseen_nrmse(found, kept)}


def robot_arm(folder: Path) -> tuple[Identification, dict[str, float]]:
    """Fit the first 700 of 1024 samples, look at the rest; frequencies are per sample."""
    recording = read_recording(folder / ARM, ARM_MAP, 1.0)
    found = identify([recording.trim(0, 700)])
    return found, {"samples 700 to 1023": unseen_nrmse(found, recording.trim(700, 1024))}


def show(console: Console, title: str, found: Identification, unseen: dict[str, float]) -> None:
    table = Table("mode", "frequency [Hz]", "std", "damping ratio", "std", title=title)
    modal = found.modal
    for i in range(len(modal.natural_freq)):
        table.add_row(
            str(i + 1),
            f"{modal.natural_freq[i]:.4f}",
            f"{modal.natural_freq_std[i]:.4f}",
            f"{modal.damping_ratio[i]:.5f}",
            f"{modal.damping_ratio_std[i]:.5f}",
        )
    console.print(table)
    console.print(f"route: {found.route}")
    console.print(f"NRMSE on what was fitted: {found.nrmse:.4f}")
    for name, error in unseen.items():
        console.print(f"NRMSE on {name}, not seen by the fit: {error:.4f}\n")


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "../shared/data")
    console = Console()
    if not (folder / F16).exists():
        console.print(f"{folder}: no recordings here; give their folder as the argument")
        return
    for title, job in (("F-16, ground vibration test", f16), ("robot arm", robot_arm)):
        start = time.perf_counter()
        found, unseen = job(folder)
        show(console, f"{title} ({time.perf_counter() - start:.1f} s)", found, unseen)


if __name__ == "__main__":
    main()
