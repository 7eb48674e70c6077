"""What the absorber does: the paper's linear model, the nonlinear frame, perturbed frames, quakes.

    python experiments/absorber_control.py                    # everything but the perturbed plants
    python experiments/absorber_control.py --plants 200       # with them
    python experiments/absorber_control.py --quakes DIR       # with the ground motions in DIR

Reductions are those of (60) in the window that is named: "steady" is the last half of each half.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from twin.campaign import campaign
from twin.control.absorber import DesignModel
from twin.control.bare import pendulum_of
from twin.control.closed_loop import run
from twin.control.controller import Controller
from twin.control.excitation import PRINTED_FREQUENCIES
from twin.control.loop import spectral_radius, stability_margin
from twin.control.lqg import lqg
from twin.control.perturbation import Perturbation
from twin.control.plant import Plant, frame_frequencies
from twin.control.sampled import step
from twin.control.study import (
    Settings,
    hammer_tests,
    identified_model,
    identify_frame,
    shaken,
    worst_case,
)
from twin.control.weights import Covariances, Weights
from twin.laboratory import read_ground_motion
from twin.model import Twin

PRINTED = (0.7693, 0.6578)
QUAKES = ("el_centro_1940", "kobe_1995", "morgan_hill_1984")


def paper_linear(console: Console) -> list[dict[str, Any]]:
    """Reductions of the paper's own matrices, the plant being the model, force on floor 1."""
    # here, so that the ledger's room is needed by this part alone
    from twin.paper.recompute import absorber_model

    model = DesignModel(absorber_model(), "force_floor1")
    rows = []
    for frequencies in (PRINTED_FREQUENCIES, frame_frequencies(model.structure)):
        for torque_weight in (1e-3, 1e-2):
            weights = Weights(1.0, 0.0, 0.0, 0.0, torque_weight)
            controller = lqg(
                model, 32.0, weights, Covariances(), 1.0, "constant", torque_limit=1e9, ramp_s=0.0
            )
            rows.append(
                {
                    "frequencies_hz": list(frequencies),
                    "torque_weight": torque_weight,
                    **_linear_run(model, controller, frequencies),
                }
            )
    table = Table(title="(50), (51), (53), (56), (57): linear, 32 Hz, one sample of delay")
    for name in ("f_1, f_2 [Hz]", "torque weight", "whole", "steady", "swing [rad]", "torque"):
        table.add_column(name)
    for row in rows:
        table.add_row(
            "{:.3f}, {:.3f}".format(*row["frequencies_hz"]),
            f"{row['torque_weight']:g}",
            *(", ".join(f"{x:.1%}" for x in row[window]) for window in ("whole", "steady")),
            f"{row['swing_rad']:.2f}",
            f"{row['torque_nm']:.3f} N m",
        )
    table.add_row("1.900, 6.800", "not printed", "76.9%, 65.8% (60), window not printed")
    console.print(table)
    return rows


def _linear_run(
    model: DesignModel, controller: Controller, frequencies: tuple[float, ...]
) -> dict[str, Any]:
    """Simulate (59) on the model itself, 32 s off and 32 s on, F_e held between samples."""
    system = model.continuous()
    full = step(system.A, system.B, controller.dt)
    time = np.arange(2048) * controller.dt
    force = sum(0.1 * np.sin(2 * np.pi * f * time) for f in frequencies)
    steps, z, torque, given = controller.start(), np.zeros(system.order), 0.0, 0.0
    x, u = np.empty((2048, 3)), np.empty(2048)
    for k in range(2048):
        if k == 1024:
            steps.switch(True)
        y = system.C @ z + system.D @ [force[k], torque]
        torque, given = given, steps.step(y, force[k])
        x[k], u[k] = z[:3], torque
        z = full.A @ z + full.held @ [force[k], torque]
    peaks = [np.abs(x[a : a + n, :2]).max(axis=0) for a, n in ((0, 1024), (1024, 1024))]
    late = [np.abs(x[a : a + 512, :2]).max(axis=0) for a in (512, 1536)]
    return {
        "whole": (1 - peaks[1] / peaks[0]).tolist(),
        "steady": (1 - late[1] / late[0]).tolist(),
        "swing_rad": float(np.abs(x[1024:, 2]).max()),
        "torque_nm": float(np.abs(u).max()),
    }


@dataclass(frozen=True)
class Perturbed:
    """One perturbed plant with a controller that was designed without knowing it."""

    plant: Plant
    controller: Controller

    @property
    def stable(self) -> bool:
        """Whether the loop of the linearised plant is stable."""
        return spectral_radius(self.controller, self.plant.linear(), self.plant.delay) < 1


def one_plant(case: Perturbed) -> dict[str, Any]:
    """Run one perturbed plant in its own worst case."""
    outcome = run(case.plant, case.controller, worst_case(case.plant))
    return {
        "stable": case.stable and outcome.peak_swing_rad < np.pi / 2,
        "reduction": min(outcome.reduction.steady.values()),
        "swing_rad": outcome.peak_swing_rad,
        "torque_nm": outcome.peak_torque_nm,
        "limited": outcome.limited,
    }


def perturbed(
    console: Console, plant: Plant, controller: Controller, count: int, workers: int
) -> dict[str, Any]:
    """Run plants off by up to 5 % in every storey and floor, all late by one more sample."""
    rng = np.random.default_rng(0)
    cases = {
        f"{number:04d}": Perturbed(
            plant.perturbed(Perturbation.drawn(len(plant.twin.floors), 0.05, rng), 1), controller
        )
        for number in range(count)
    }
    with (
        Progress(console=console, transient=True) as bar,
        ProcessPoolExecutor(workers, get_context("spawn")) as executor,
    ):
        task = bar.add_task("perturbed plants", total=count)
        results = campaign(
            one_plant, cases, executor, progress=lambda n, of: bar.update(task, completed=n)
        )
    shares = np.array([r["reduction"] for r in results.values()])
    found = {
        "excitation": plant.known_input,
        "plants": count,
        "stable": sum(r["stable"] for r in results.values()),
        "at_least_75_percent": float(np.mean(shares >= 0.75)),
        "reduction_5th_percentile": float(np.percentile(shares, 5)),
        "reduction_least": float(shares.min()),
        "swing_most_rad": max(r["swing_rad"] for r in results.values()),
        "torque_most_nm": max(r["torque_nm"] for r in results.values()),
    }
    console.print(f"perturbed plants, one more sample of delay: {found}")
    return found


def nonlinear(console: Console, twin: Twin, settings: Settings) -> list[dict[str, Any]]:
    """Run the worst case in MuJoCo, controllers from a hammer test and from the truth."""
    rows = []
    table = Table(title="MuJoCo, worst case; identified model (true model)")
    for name in ("excited by", "window", "floor1", "floor2", "swing", "torque", "margin"):
        table.add_column(name)
    for known_input in ("force_ground", "force_floor1", "acc_ground"):
        plant = Plant(twin, known_input)
        believed = identified_model(
            identify_frame(hammer_tests(plant)), pendulum_of(twin), known_input
        )
        pair = []
        for model in (believed, plant.linear()):
            controller = settings.design(model, plant.delay)
            outcome = run(plant, controller, worst_case(plant))
            margin = stability_margin(controller, plant.linear(), plant.delay)
            pair.append((outcome, margin))
        (outcome, margin), (true, true_margin) = pair
        ours, theirs = outcome.reduction.as_json(), true.reduction.as_json()
        for window in ours:
            table.add_row(
                known_input,
                window,
                *(f"{ours[window][f]:.1%} ({theirs[window][f]:.1%})" for f in outcome.floors),
                f"{outcome.peak_swing_rad:.3f} ({true.peak_swing_rad:.3f})",
                f"{outcome.peak_torque_nm:.3f} ({true.peak_torque_nm:.3f})",
                f"{margin:.2f} ({true_margin:.2f})",
            )
        rows.append(
            {
                "excitation": known_input,
                "identified": ours,
                "true": theirs,
                "swing_rad": outcome.peak_swing_rad,
                "torque_nm": outcome.peak_torque_nm,
                "margin": margin,
                "notes": list(outcome.notes),
            }
        )
    console.print(table)
    return rows


def earthquakes(
    console: Console, twin: Twin, settings: Settings, folder: Path, swing: float = 0.8
) -> list[dict[str, Any]]:
    """Play each record at the largest peak that keeps the swing within its limit."""
    plant = Plant(twin, "acc_ground")
    believed = identified_model(
        identify_frame(hammer_tests(plant)), pendulum_of(twin), plant.known_input
    )
    controller = settings.design(believed, plant.delay)
    rows = []
    for name in QUAKES:
        path = folder / f"{name}.csv"
        if not path.exists():
            console.print(f"{path} is not there: {name} left out")
            continue
        peak = 0.1
        for _ in range(4):  # the swing is close to proportional: a few secant steps
            outcome = shaken(plant, controller, read_ground_motion(path, peak))
            if 0.97 * swing <= outcome.peak_swing_rad <= swing:
                break
            peak *= 0.985 * swing / outcome.peak_swing_rad
        rows.append(
            {
                "earthquake": name,
                "peak_m_s2": peak,
                "reduction": outcome.reduction.as_json(),
                "swing_rad": outcome.peak_swing_rad,
                "torque_nm": outcome.peak_torque_nm,
                "notes": list(outcome.notes),
            }
        )
        console.print(rows[-1])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--settings", type=Path, help="settings.json of twin tune")
    parser.add_argument("--plants", type=int, default=0, help="perturbed plants to run")
    parser.add_argument("--excite", default="force_ground", help="what excites those")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--quakes", type=Path, help="folder of the recorded ground motions")
    parser.add_argument("--only", choices=("paper", "worst", "perturbed", "quakes"))
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    console = Console()
    settings = Settings()
    if chosen.settings:
        settings = Settings.from_json(json.loads(chosen.settings.read_text())["settings"])
    twin = Twin.load("two_storey_absorber")
    found: dict[str, Any] = {"settings": settings.as_json()}
    if chosen.only in (None, "paper"):
        found["paper"] = paper_linear(console)
    if chosen.only in (None, "worst"):
        found["worst_case"] = nonlinear(console, twin, settings)
    if chosen.plants:
        plant = Plant(twin, chosen.excite)
        believed = identified_model(
            identify_frame(hammer_tests(plant)), pendulum_of(twin), plant.known_input
        )
        controller = settings.design(believed, plant.delay)
        found["perturbed"] = perturbed(console, plant, controller, chosen.plants, chosen.workers)
    if chosen.quakes and chosen.only in (None, "quakes"):
        found["earthquakes"] = earthquakes(console, twin, settings, chosen.quakes)
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
