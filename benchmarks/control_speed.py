"""How long a controller step takes in Python and in C, and how long a closed-loop run of 64 s.

python benchmarks/control_speed.py --json benchmarks/results/control_speed.json
"""

from __future__ import annotations

import argparse
import ctypes
import json
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from machine import described

from twin.control.closed_loop import run
from twin.control.controller import Controller
from twin.control.export import export
from twin.control.plant import Plant
from twin.control.study import Settings, step_time, worst_case
from twin.model import Twin


def c_step_time(controller: Controller, steps: int = 1_000_000) -> float | None:
    """Return the mean time of a step of the exported C file [us], or None without gcc."""
    compiler = shutil.which("gcc")
    if compiler is None:
        return None
    loop = """
    void many(long n, double *y, double f, double *u)
    { for (long i = 0; i < n; i++) { controller_step(y, f, u); y[0] = *u; } }
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        export(controller, folder)
        source = (folder / "controller.c").read_text()
        (folder / "many.c").write_text(source + loop)
        flags = ["-std=c99", "-O2", "-shared", "-fPIC", "-w"]
        subprocess.run([compiler, *flags, folder / "many.c", "-o", folder / "many.so"], check=True)
        library = ctypes.CDLL(str(folder / "many.so"))
        y, u = (ctypes.c_double * len(controller.measurements))(), ctypes.c_double()
        library.controller_reset()
        library.controller_switch(1)
        begin = time.perf_counter()
        library.many(ctypes.c_long(steps), y, ctypes.c_double(0.1), ctypes.byref(u))
        return 1e6 * (time.perf_counter() - begin) / steps


def loop_time(plant: Plant, rate_hz: float, repeats: int) -> dict[str, float]:
    """Return the shortest time of a 64 s run, elapsed and of the processor [s]."""
    controller = Settings(rate_hz=rate_hz).design(plant.linear(), plant.delay)
    excitation = worst_case(plant)
    elapsed, processor = [], []
    for _ in range(repeats):
        begin = time.perf_counter(), time.process_time()
        run(plant, controller, excitation)
        elapsed.append(time.perf_counter() - begin[0])
        processor.append(time.process_time() - begin[1])
    return {"elapsed_s": min(elapsed), "processor_s": min(processor)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    twin = Twin.load("two_storey_absorber")
    found: dict[str, Any] = {"machine": described()}
    for known_input in ("force_ground", "force_floor1"):
        plant = Plant(twin, known_input)
        controller = Settings().design(plant.linear(), plant.delay)
        times = np.array([step_time(controller) for _ in range(chosen.repeats)])
        found[known_input] = {
            "states": len(controller.A),
            "step_us": {"median": times[:, 0].min(), "p99": times[:, 1].min()},
            "c_step_us": c_step_time(controller),
            "run_64_s": {
                f"{rate:g} Hz": loop_time(plant, rate, chosen.repeats) for rate in (32.0, 1000.0)
            },
        }
    print(json.dumps(found, indent=1))
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
