"""What the peers are given of a case and give back: numpy only, for an environment of their own."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray
Records = list[tuple[Array, Array]]
WINDOW_S = 2.0


@dataclass(frozen=True)
class Case:
    """Recordings of a case.

    Attributes:
        sampling_hz: samples per second.
        inputs, outputs: names of the columns.
        train, test: inputs (samples, r) and outputs (samples, m) of each recording.
    """

    sampling_hz: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    train: Records
    test: Records


def save(case: Case, path: Path) -> None:
    arrays = {"sampling_hz": case.sampling_hz, "inputs": case.inputs, "outputs": case.outputs}
    for role in ("train", "test"):
        for number, (u, y) in enumerate(getattr(case, role)):
            arrays |= {f"{role}_{number}_u": u, f"{role}_{number}_y": y}
    np.savez(path, **arrays)


def load(path: Path) -> Case:
    with np.load(path) as data:

        def records(role: str) -> Records:
            count = sum(name.startswith(role) for name in data.files) // 2
            return [(data[f"{role}_{i}_u"], data[f"{role}_{i}_y"]) for i in range(count)]

        names = (tuple(str(n) for n in data[key]) for key in ("inputs", "outputs"))
        return Case(float(data["sampling_hz"]), *names, records("train"), records("test"))


def nrmse(records: Records, predicted: list[Array]) -> float | None:
    """RMS of the residual over RMS of the output, pooled; None where a run diverged."""
    error = sum(float(np.sum((y - p) ** 2)) for (_, y), p in zip(records, predicted, strict=True))
    power = sum(float(np.sum(y**2)) for _, y in records)
    found = float(np.sqrt(error / power))
    return found if np.isfinite(found) and found < 1e3 else None


def answer(job: Callable[[Case], dict[str, Any]]) -> None:
    """Run a peer on the case that the command line names; print its answer as JSON."""
    case = load(Path(sys.argv[1]))
    begin = time.process_time()
    found = job(case)
    print(json.dumps(found | {"seconds": round(time.process_time() - begin, 2)}))
