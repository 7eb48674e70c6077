"""``twin tune``: search the controller's weights and covariances within what the rig stands."""

from __future__ import annotations

import json as writer
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from twin.cli.common import (
    Json,
    Out,
    Seed,
    check_folder,
    check_json_target,
    console,
    write_json,
    write_whole,
)
from twin.cli.control import (
    KNOWN_INPUT,
    About,
    At,
    Delay,
    Excited,
    Inertia,
    Model,
    Noise,
    Recordings,
    identification_of,
    pendulum_read,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from twin.control.tuning import Trial

DEFAULT_FOLDER = Path("twin-tune")
RESULTS = "trials.jsonl"


def register(app: typer.Typer) -> None:
    """Add the command."""
    example = "Example: twin tune --max-swing 0.8 --max-torque 0.5 --out tuned"
    app.command("tune", epilog=example)(tune)


def tune(
    recordings: Recordings = None,
    max_swing: Annotated[
        float, typer.Option("--max-swing", help="Largest swing of the pendulum [rad].")
    ] = 0.8,
    max_torque: Annotated[float, typer.Option("--max-torque", help="Largest torque [N m].")] = 0.5,
    model: Model = "two_storey_absorber",
    excite: At = Excited.ground,
    rate: Annotated[float, typer.Option("--rate", help="Rate of the controller [Hz].")] = 32.0,
    delay: Delay = 1,
    spread: Annotated[
        float, typer.Option("--spread", min=0, max=0.5, help="Stiffness, mass off by this share.")
    ] = 0.05,
    count: Annotated[
        int, typer.Option("--candidates", min=1, max=4096, help="How many controllers to try.")
    ] = 48,
    workers: Annotated[
        int, typer.Option("--workers", min=0, help="Processes; 0 for as many as there are cores.")
    ] = 0,
    inertia_about: Inertia = About.centre,
    noise: Noise = 0.01,
    out: Out = None,
    seed: Seed = 0,
    json: Json = None,
) -> None:
    """Search weights and covariances; pick the best controller that respects the limits.

    Each candidate is designed on the identified model, must be stable on draws of that model's
    uncertainty with and without one more sample of delay, and is then simulated in MuJoCo on the
    rig as it is and on a perturbed one. The folder of --out (twin-tune) gets settings.json for
    twin control --settings, and trials.jsonl, from which an interrupted search goes on.
    """
    from twin.campaign import campaign
    from twin.control.plant import Plant
    from twin.control.study import Settings, identified_model
    from twin.control.tuning import (
        Limits,
        candidates,
        evaluate,
        front,
        identity,
        pick,
        trials,
    )
    from twin.control.uncertainty import Uncertainty
    from twin.model import Twin
    from twin.view import control_figures, figures

    check_json_target(json)
    limits = Limits(max_swing, max_torque)
    plant = Plant(Twin.load(model), KNOWN_INPUT[excite.value], delay)
    pendulum = pendulum_read(plant, inertia_about)
    base = Settings(rate_hz=rate, torque_limit=plant.torque_limit)
    base.design(plant.linear(), delay)
    target = check_folder(out or DEFAULT_FOLDER)
    shown = Console(stderr=True)
    with Progress(console=shown, transient=True, disable=not shown.is_terminal) as bar:
        identification = identification_of(recordings, plant, noise, seed, bar)
        believed = identified_model(identification, pendulum, plant.known_input)
        uncertainty = Uncertainty.of(identification, spread)
        tasks = trials(candidates(count, seed, base), believed, plant, uncertainty, seed)
        bar_task = bar.add_task("controllers", total=count)

        def report(done: int, of: int) -> None:
            bar.update(bar_task, completed=done, total=of)

        # spawn: a fork would copy the progress bar's thread in whatever state it is
        with ProcessPoolExecutor(workers or os.cpu_count(), get_context("spawn")) as executor:
            results = campaign(evaluate, tasks, executor, target / RESULTS, identity(tasks), report)
        best = pick(results, limits)
        truth = _with_truth(tasks[best])
    result = _result(tasks, results, front(results), best, truth, limits)
    _show(console(json), result)
    settings = writer.dumps({"settings": result["settings"]}, indent=1) + "\n"
    write_whole(target / "settings.json", lambda part: part.write_text(settings))
    drawn = control_figures.front(result["front"], best, result["limits"])
    figures.save(drawn, target / "front.png")
    write_json(result, str(target / "tune.json"))
    write_json(result, json)


def _with_truth(trial: Trial) -> dict[str, Any]:
    """Return the simulated numbers of the same settings designed on the true plant."""
    from twin.control.closed_loop import run
    from twin.control.study import worst_case

    plant = trial.plant
    controller = trial.settings.design(plant.linear(), plant.delay)
    outcome = run(plant, controller, worst_case(plant), seed=trial.seed)
    return {
        "reduction": min(outcome.reduction.steady.values()),
        "swing_rad": outcome.peak_swing_rad,
        "torque_nm": outcome.peak_torque_nm,
    }


def _result(
    tasks: Mapping[str, Trial],
    results: Mapping[str, dict[str, Any]],
    best_ones: tuple[str, ...],
    best: str,
    truth: dict[str, Any],
    limits: Any,
) -> dict[str, Any]:
    from dataclasses import replace

    chosen = replace(tasks[best].settings, torque_limit=limits.torque_nm)
    return {
        "settings": chosen.as_json(),
        "picked": {"name": best, **results[best]},
        "with_true_model": truth,
        "loss": truth["reduction"] - results[best]["reduction"],
        "limits": {"swing_rad": limits.swing_rad, "torque_nm": limits.torque_nm},
        "tried": len(results),
        "stable": sum("reduction" in r for r in results.values()),
        "front": [
            {"name": n, **results[n], "settings": tasks[n].settings.as_json()} for n in best_ones
        ],
    }


def _show(screen: Console, result: dict[str, Any]) -> None:
    table = Table(title="front of reduction against torque and swing, worst of both simulations")
    names = ("trial", "reduction", "5 % of draws", "swing", "torque", "margin", "")
    for name in names:
        table.add_column(name, justify="right" if name else "left")
    for row in result["front"]:
        table.add_row(
            row["name"],
            f"{row['worst_reduction']:.1%}",
            f"{row['reduction_p5']:.1%}",
            f"{row['worst_swing_rad']:.3f} rad",
            f"{row['worst_torque_nm']:.3f} N m",
            f"{row['margin']:.2f}",
            "picked" if row["name"] == result["picked"]["name"] else "",
        )
    screen.print(table)
    picked = result["picked"]
    screen.print(
        f"trial {picked['name']}: {picked['reduction']:.1%} steady at the less calmed floor, "
        f"{100 * result['loss']:.2f} percentage points less than with the true model; "
        f"{result['stable']} of {result['tried']} controllers stable on all draws"
    )
