"""The measured Silverbox diagnosed with a one-storey frame whose numbers are not known.

    python experiments/silverbox.py ../shared/data/silverbox/SNLS80mV.csv

Trains on multisines, tests on the growing-amplitude arrow, and prints the arrow's error beside the
published ones. One volt of output is taken as 1 mm; the input's scale makes the moving mass that of
the frame, so that a mechanical model of that size can stand for it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from twin.diagnosis.pipeline import diagnose
from twin.model import Twin
from twin.recording import Recording

RATE_HZ = 1e7 / 2**14
NEWTON_A_VOLT, METRE_A_VOLT = 134.0, 1e-3
ARROW = 40_500
QUIET_V, GAP, LEAST = 0.012, 30, 5000
EVERY = 3
PUBLISHED = (
    ("best linear model", 13.7),
    ("local linear state space (Verdult 2004)", 1.3),
    ("physical block-oriented model (Hjalmarsson and Schoukens 2004)", 0.96),
    ("LS-SVM NARX (Espinoza 2004)", 0.32),
    ("neural network, cubic regressors (Ljung 2004)", 0.30),
    ("polynomial nonlinear state space (Paduart 2008)", 0.26),
)


def recording(volts: np.ndarray, start: int, stop: int, name: str) -> Recording:
    """Return samples as force and displacement, offsets of the amplifiers taken off."""
    u, y = (volts[start:stop] - volts.mean(axis=0)).T
    columns = {"force_floor1": NEWTON_A_VOLT * u, "disp_floor1": METRE_A_VOLT * y}
    return Recording.build(RATE_HZ, columns, name)


def multisines(volts: np.ndarray) -> list[Recording]:
    """Return the blocks between the pauses after the arrow."""
    loud = np.flatnonzero(np.abs(volts[ARROW:, 0]) > QUIET_V) + ARROW
    gaps = np.flatnonzero(np.diff(loud) > GAP)
    starts, stops = loud[gaps[:-1] + 1], loud[gaps[1:]]
    pairs = [(a, b) for a, b in zip(starts, stops, strict=True) if b - a > LEAST]
    return [recording(volts, a - 8, b + 8, f"multisine {i}") for i, (a, b) in enumerate(pairs)]


def main(path: Path) -> None:
    """Diagnose and print the table."""
    volts = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=(0, 1))
    train = multisines(volts)[::EVERY]
    test = [recording(volts, 0, ARROW, "arrow")]
    found = diagnose(Twin.load("one_storey"), train, test, unknown=True)
    print(f"verdict: {found.verdict}")
    for finding in found.findings:
        print(f"  {finding.mechanism.name} at {finding.location}: {finding.mechanism.values}")
    trace = next(t for t in found.traces if t.role == "test")
    rows = [(name, value) for name, value in PUBLISHED]
    for name in ("calibrated", "explained"):
        error = np.sqrt(np.nanmean((getattr(trace, name) - trace.measured) ** 2))
        rows.append((f"this twin, {name}", 1e3 * float(error) / METRE_A_VOLT))
    print("error on the arrow [mV]")
    for name, value in sorted(rows, key=lambda row: -row[1]):
        print(f"  {value:7.3f}  {name}")
    print(f"{found.seconds:.0f} s")


if __name__ == "__main__":
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_file():
        print("needs SNLS80mV.csv of the Silverbox benchmark (Wigren and Schoukens 2013)")
        sys.exit(2)
    main(Path(sys.argv[1]))
