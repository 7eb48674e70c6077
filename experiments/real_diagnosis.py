"""Recordings that nobody here made: what a linear twin leaves unexplained, and what is found in it.

    python experiments/real_diagnosis.py DATA [--only f16 robot_arm silverbox bouc_wen ...]

DATA holds the folders ``f16_gvt``, ``robot_arm``, ``silverbox``, ``bncs`` and ``emps`` (``twin
fetch`` gets the first and the third as other files); the Bouc-Wen benchmark and the controlled run
are generated. Results of each part are kept in ``experiments/results/real.json``, those of other
parts stay as they are; one table over all of them ends the output.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parent.parent))

from experiments import (
    bncs,
    bouc_wen,
    controlled_run,
    emps_diagnosed,
    real_recordings,
    silverbox,
)
from twin.diagnosis.pipeline import diagnose
from twin.formats import read_recording
from twin.model import Twin

Array = NDArray[np.float64]

RESULTS = Path(__file__).parent / "results" / "real.json"
BAND_HZ = (2.0, 15.0)
"""Of the F-16's excitation; every line in it is driven."""
ABOVE_HZ = (15.5, 60.0)
REACH, PASSES = 5, 4
"""Lines to either side of a local response function, and reweightings of its fit."""
LOOSE_MODE_HZ = (7.1, 7.6)
"""Of the mode in which wing and payload move against each other in their mounting."""
SEEN, UNSEEN = slice(1, 6), slice(6, 9)
"""Periods that are fitted (the first holds the transient) and those that are not."""


def rms(values: Array) -> float:
    """Return the RMS; samples that are left out (NaN) do not count."""
    return float(np.sqrt(np.nanmean(np.abs(values) ** 2)))


def f16(data: Path) -> dict[str, Any]:
    """Say how much of the response repeats, how much of that is linear, and what is left.

    Every period has the same force, so the mean of the periods seen predicts the unseen ones with
    all that repeats, linear or not: no model of a steady response can do better. What goes beyond
    it is noise and what changed from period to period; what a linear model errs beyond it repeats
    and is the model's: too few modes, or physics that is not linear. Lines above the excited band
    answer to no force: what repeats there is nonlinear distortion (or the shaker's).
    """
    read = read_recording(data / real_recordings.F16, real_recordings.F16_MAP, 400.0)
    count = real_recordings.F16_PERIOD
    whole = read.samples // count
    periods = read.data[: whole * count].reshape(whole, count, -1)
    u, y = periods[..., :1], periods[..., 1:]
    y = y - y.mean(axis=1, keepdims=True)
    seen, unseen = y[SEEN].mean(axis=0), y[UNSEEN]
    _, errors = real_recordings.f16(data)
    spectrum, force = np.fft.rfft(y[1:], axis=1), np.fft.rfft(u[1:], axis=1)
    f = np.fft.rfftfreq(count, 1 / read.sampling_hz)
    inside = (f >= BAND_HZ[0]) & (f <= BAND_HZ[1])
    above = (f >= ABOVE_HZ[0]) & (f <= ABOVE_HZ[1])
    mean, spread = spectrum.mean(axis=0), spectrum.std(axis=0, ddof=1)
    n = len(spectrum)
    # the mean of n periods still holds an n-th of the noise's power
    repeats = np.maximum(np.abs(mean[above]) ** 2 - spread[above] ** 2 / n, 0).sum()
    number = np.arange(n) - (n - 1) / 2
    slope = np.einsum("p,pfo->fo", number, spectrum) / np.sum(number**2)
    trend = np.einsum("p,fo->pfo", number, slope)[:, inside]
    variation = (spectrum - mean)[:, inside]
    level = np.sum(np.abs(mean[inside]) ** 2)
    drifting = float(np.sum(np.abs(trend) ** 2) / np.sum(np.abs(variation) ** 2))
    left = ragged(mean[inside], force[:, inside].mean(axis=0)[:, 0])
    loose = (f[inside] >= LOOSE_MODE_HZ[0]) & (f[inside] <= LOOSE_MODE_HZ[1])
    return {
        "linear model, unseen periods": next(iter(errors.values())),
        "mean of the seen periods, unseen periods": rms(unseen - seen) / rms(unseen),
        "period to period, excited band": float(np.sqrt(np.sum(spread[inside] ** 2) / level)),
        "share of it that is a trend in time": drifting,
        "share that a trend in noise would have": 1 / (n - 1),
        "distortion and noise, excited band": float(np.sqrt(left.sum() / level)),
        "share of its power at 7.1 to 7.6 Hz": float(left[loose].sum() / left.sum()),
        "of it, noise": float(np.sqrt(np.sum(spread[inside] ** 2) / n / level)),
        "repeats above the band": float(np.sqrt(repeats / level)),
        "noise above the band": float(np.sqrt(np.sum(spread[above] ** 2) / level)),
        "force above the band": rms(force[:, above].mean(axis=0)) / rms(force[:, inside]),
    }


def ragged(y: Array, u: Array) -> Array:
    """Return the power of the response that no smooth response function explains, (lines,).

    A linear response over its force is smooth from line to line; what nonlinearity adds under
    random phases is not, and repeats all the same. Around each line the response function is taken
    as a ratio of two polynomials, which follows a resonance, too (McKelvey and Guerin 2012, local
    rational model); what that leaves is distortion and noise.

    Args:
        y: spectrum of the mean period at the excited lines, (lines, outputs).
        u: that of the force, (lines,).
    """
    r = np.arange(-REACH, REACH + 1) / REACH
    left = np.zeros(len(y))
    for line in range(REACH, len(y) - REACH):
        near = slice(line - REACH, line + REACH + 1)
        for response in y[near].T:
            terms = np.column_stack([u[near], r * u[near], r**2 * u[near]])
            poles = -np.column_stack([r, r**2]) * response[:, None]
            below = np.ones(len(r), complex)
            for _ in range(PASSES):
                A = np.hstack([terms, poles]) / below[:, None]
                best = np.linalg.lstsq(A, response / below, rcond=None)[0]
                below = 1 + best[3] * r + best[4] * r**2
            error = response - terms @ best[:3] / below
            left[line] += float(np.sum(np.abs(error) ** 2)) / (len(r) - len(best))
    return left


def robot_arm(data: Path) -> dict[str, Any]:
    """Return the linear model's error on what it saw and did not see."""
    found, errors = real_recordings.robot_arm(data)
    return {
        "linear model, seen part": float(found.nrmse or np.nan),
        "linear model, unseen part": next(iter(errors.values())),
        "modes": len(found.modal.natural_freq),
    }


def silverbox_box(data: Path) -> dict[str, Any]:
    """Diagnose the Silverbox as ``silverbox.py`` does; errors on the arrow in mV."""
    path = data / "silverbox" / "SNLS80mV.csv"
    volts = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=(0, 1))
    train = silverbox.multisines(volts)[:: silverbox.EVERY]
    test = [silverbox.recording(volts, 0, silverbox.ARROW, "arrow")]
    found = diagnose(Twin.load("one_storey"), train, test, unknown=True)
    trace = next(t for t in found.traces if t.role == "test")
    ours = {
        name: 1e3 * rms(getattr(trace, name) - trace.measured) / silverbox.METRE_A_VOLT
        for name in ("calibrated", "explained")
    }
    return {
        "verdict": found.verdict,
        "findings": [
            {"mechanism": f.mechanism.name, "location": f.location, "probability": f.probability}
            for f in found.findings
        ],
        "error_mV": ours,
        "published_error_mV": dict(silverbox.PUBLISHED),
    }


def bouc_wen_system(data: Path) -> dict[str, Any]:
    """Generate and diagnose the Bouc-Wen benchmark."""
    found = diagnose(bouc_wen.linear_twin(), bouc_wen.training(1), bouc_wen.tests(None, 1))
    return bouc_wen.result(found)


def isolated_building(data: Path) -> dict[str, Any]:
    """Predict each motion of the base-isolated building from the others."""
    files = sorted((data / "bncs").glob("*.csv"))
    recordings = {path.stem: read_recording(path) for path in files}
    rows = {held: bncs.predicted(recordings, held, None) for held in recordings}
    return {
        held: {key: row[key] for key in row if isinstance(row[key], float)}
        | {"found": ", ".join(row["found"])}
        for held, row in rows.items()
    }


def slide(data: Path) -> dict[str, Any]:
    """Diagnose EMPS: its first half explained, its second one predicted."""
    found = emps_diagnosed.diagnosed(read_recording(data / "emps" / "DATA_EMPS.csv"))
    names = [name for name in found["found"] if name != "slide"]
    return {
        "found": ", ".join(names),
        "values": {name: dict(values) for name, values in found["found"].items()},
        "error_on_the_second_half": found["error_on_the_second_half"],
    }


def controlled(data: Path) -> dict[str, Any]:
    """Diagnose the absorber in closed loop, one fault of its motor at a time."""
    rows = controlled_run.cases(list(controlled_run.CONCEALED))
    return {
        row["concealed"]: {"found": row["named"] or "nothing", **row["unseen_error"]}
        for row in rows
    }


PARTS: dict[str, Callable[[Path], dict[str, Any]]] = {
    "f16": f16,
    "robot_arm": robot_arm,
    "silverbox": silverbox_box,
    "bouc_wen": bouc_wen_system,
    "bncs": isolated_building,
    "emps": slide,
    "controlled": controlled,
}
GENERATED = ("bouc_wen", "controlled")
"""Parts that need no recording of DATA."""


def show(console: Console, kept: dict[str, Any]) -> None:
    """Print one table a part."""
    for name, part in kept.items():
        table = Table("", "", title=name, show_header=False)
        for key, value in part.items():
            if isinstance(value, float):
                table.add_row(key, f"{value:.4g}")
            elif isinstance(value, dict):
                for inner, number in value.items():
                    shown = f"{number:.3g}" if isinstance(number, float) else json.dumps(number)
                    table.add_row(f"{key}: {inner}", shown)
            elif isinstance(value, list):
                table.add_row(key, ", ".join(f"{f['mechanism']} {f['location']}" for f in value))
            else:
                table.add_row(key, str(value))
        console.print(table)
    console.print(overview(kept))


def overview(kept: dict[str, Any]) -> Table:
    """Return one table: what was found, errors of a linear and of the explained twin, unseen."""
    table = Table("recording", "found", "linear", "explained", title="All of them")

    def row(name: str, found: str, linear: float | None, explained: float | None) -> None:
        errors = ("-" if e is None else f"{e:.3g}" for e in (linear, explained))
        table.add_row(name, found, *errors)

    for name, part in kept.items():
        found = ", ".join(f"{f['mechanism']} {f['location']}" for f in part.get("findings", ()))
        if name == "f16":
            row("F-16, level 1", "modes", part["linear model, unseen periods"], None)
        elif name == "robot_arm":
            row("robot arm", "modes", part["linear model, unseen part"], None)
        elif name == "silverbox":
            error = part["error_mV"]
            row("Silverbox, arrow [mV]", found, error["calibrated"], error["explained"])
        elif name == "bncs":
            for held in (k for k, v in part.items() if isinstance(v, dict)):
                own = part[held]
                linear, explained = own["calibrated linear twin"], own["explained twin"]
                row(f"BNCS, {held}", own["found"], linear, explained)
        elif name == "emps":
            error = part["error_on_the_second_half"]
            row("EMPS, second half", part["found"], None, error["found"]["free_run"])
            row("EMPS, published model", "", None, error["published"]["free_run"])
        elif name == "controlled":
            for fault in (k for k, v in part.items() if isinstance(v, dict)):
                own = part[fault]
                row(f"controlled, {fault}", own["found"], own["calibrated"], own["explained"])
        elif name == "bouc_wen":
            for file, own in part["rms_error_m"].items():
                row(f"Bouc-Wen, {file} [m]", found, own["calibrated"], own["explained"])
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the parts that are wanted and have their data."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--only", nargs="+", choices=tuple(PARTS), default=tuple(PARTS))
    parser.add_argument("--json", type=Path, default=RESULTS)
    chosen = parser.parse_args(arguments)
    kept: dict[str, Any] = {}
    if chosen.json.is_file():
        kept = json.loads(chosen.json.read_text())
    for name in chosen.only:
        folder = {"f16": "f16_gvt"}.get(name, name)
        if name not in GENERATED and not (chosen.data / folder).is_dir():
            print(f"{name}: no folder {chosen.data / folder}, left out")
            continue
        begin = time.perf_counter()
        kept[name] = PARTS[name](chosen.data) | {"seconds": 0.0}
        kept[name]["seconds"] = round(time.perf_counter() - begin, 1)
        chosen.json.write_text(json.dumps(kept, indent=1) + "\n")
    show(Console(), kept)


if __name__ == "__main__":
    main()
