"""Portal, cantilever and turned frame: shaken virtually, identified, and compared with the model.

Every draw adds fresh noise to the same noise-free recordings; the modes that ``twin identify``
finds have to lie within three of their stated standard deviations of the model's own.

    python -m experiments.structures_identified --draws 50 --out identified --workers 2

Resumable: the folder keeps what is done. Prints a table.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from twin import shaker_test
from twin.campaign import campaign
from twin.errors import TwinError
from twin.identification.identify import identify
from twin.linearise import linearise
from twin.model import Twin
from twin.recording import Recording

NOISE = 0.01
DEVIATIONS = 3.0
NEAR = 0.03
"""A mode belongs to the model's where their frequencies differ by less than this share."""


@dataclass(frozen=True)
class Plan:
    """How a structure is shaken: actuators, band [Hz], level [N], rate [Hz], length [s]."""

    drives: tuple[str, ...]
    band_hz: tuple[float, float]
    level: float
    sampling_hz: float
    duration_s: float


PLANS = {
    "portal_3d": Plan(("force_floor1_x", "force_floor2_y"), (0.5, 20.0), 0.05, 64.0, 64.0),
    "rotated_sensors": Plan(("force_a", "force_b"), (0.5, 20.0), 1.0, 64.0, 64.0),
    "cantilever": Plan(("force_mid", "force_tip"), (0.5, 40.0), 0.005, 128.0, 32.0),
}


@dataclass(frozen=True)
class Draw:
    """One identification."""

    model: str
    number: int


@lru_cache(maxsize=4)
def recorded(model: str) -> Recording:
    """Return the noise-free recording of a structure."""
    plan = PLANS[model]
    return shaker_test(
        model, plan.drives, level_n=plan.level, band_hz=plan.band_hz,
        rate_hz=plan.sampling_hz, duration_s=plan.duration_s, noise=0.0, seed=1,
    )  # fmt: skip


@lru_cache(maxsize=4)
def true_modes(model: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the model's own natural frequencies [Hz] in the band, and damping ratios."""
    matrices = linearise(Twin.load(model).compile()).generalised
    modes = matrices.modes()
    low, high = PLANS[model].band_hz
    inside = (modes.natural_freq > low) & (modes.natural_freq < high)
    return modes.natural_freq[inside], modes.damping_ratio[inside]


def drawn(task: Draw) -> dict[str, Any]:
    """Identify one draw; return by mode the errors over their standard deviations.

    Returns:
        frequency, damping: errors in standard deviations, None for a mode that was not found.
        spurious: modes in the band that the model has not. error: where identifying failed.
    """
    clean = recorded(task.model)
    rng = np.random.default_rng([7, task.number])
    scale = NOISE * np.sqrt(np.mean(clean.data**2, axis=0))
    noisy = replace(clean, data=clean.data + scale * rng.standard_normal(clean.data.shape))
    try:
        found = identify([noisy]).modal
    except TwinError as error:
        return {"error": str(error)}
    frequencies, ratios = true_modes(task.model)
    row: dict[str, Any] = {"frequency": [], "damping": []}
    taken = set()
    for f, z in zip(frequencies, ratios, strict=True):
        near = int(np.argmin(np.abs(found.natural_freq - f)))
        if abs(found.natural_freq[near] / f - 1) > NEAR or near in taken:
            row["frequency"].append(None)
            row["damping"].append(None)
            continue
        taken.add(near)
        for key, value, std, true in (
            ("frequency", found.natural_freq, found.natural_freq_std, f),
            ("damping", found.damping_ratio, found.damping_ratio_std, z),
        ):
            row[key].append(float((value[near] - true) / std[near]) if std is not None else None)
    low, high = PLANS[task.model].band_hz
    inside = (found.natural_freq > low) & (found.natural_freq < high)
    row["spurious"] = int(np.sum(inside)) - len(taken)
    return row


def table(results: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the shares within three standard deviations, as Markdown."""
    lines = ["| structure | mode [Hz] | draws | found | frequency within 3 std | damping |"]
    lines.append("|" + "---|" * 6)
    for model in PLANS:
        rows = [r for name, r in results.items() if name.startswith(f"{model} ")]
        if not rows:
            continue
        for i, f in enumerate(true_modes(model)[0]):
            cells = []
            for key in ("frequency", "damping"):
                errors = [r[key][i] for r in rows if key in r and r[key][i] is not None]
                within = sum(abs(e) < DEVIATIONS for e in errors)
                cells.append(f"{within} of {len(rows)}")
            there = sum("frequency" in r and r["frequency"][i] is not None for r in rows)
            lines.append(
                f"| {model} | {f:.3f} | {len(rows)} | {there} | " + " | ".join(cells) + " |"
            )
        spurious = sum(r.get("spurious", 0) for r in rows)
        failed = sum("error" in r for r in rows)
        lines.append(f"| {model} | spurious {spurious}, failed {failed} | | | | |")
    return "\n".join(lines)


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=50)
    parser.add_argument("--model", action="append", choices=[*PLANS])
    parser.add_argument("--out", type=Path, default=Path("identified"))
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    tasks = {
        f"{model} {number}": Draw(model, number)
        for number in range(1, given.draws + 1)
        for model in given.model or PLANS
    }
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with ProcessPoolExecutor(given.workers, get_context("spawn")) as executor:
        results = campaign(drawn, tasks, executor, given.out / "draws.jsonl", "identified")
    text = table(results)
    (given.out / "identified.md").write_text(text + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
