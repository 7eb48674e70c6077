"""``twin control``: the absorber under LQG control, in MuJoCo, and to the lab computer."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import Progress, TaskID

from twin.cli.common import (
    Json,
    Out,
    Rerun,
    Seed,
    check_folder,
    check_json_target,
    console,
    made,
    watched,
    write_json,
)
from twin.errors import TwinError

if TYPE_CHECKING:
    from twin.control.controller import Controller
    from twin.control.excitation import WorstCase
    from twin.control.outcome import Outcome
    from twin.control.plant import Plant
    from twin.control.study import Settings
    from twin.frame import Pendulum
    from twin.identification.result import Identification
    from twin.laboratory import Earthquake


class Excited(StrEnum):
    """Where the excitation enters."""

    ground = "ground"
    floor1 = "floor1"
    table = "table"


class About(StrEnum):
    """The two readings of I_zz,3."""

    centre = "centre"
    pivot = "pivot"


KNOWN_INPUT = {"ground": "force_ground", "floor1": "force_floor1", "table": "acc_ground"}

Recordings = Annotated[
    list[Path] | None,
    typer.Argument(
        metavar="[RECORDING]...",
        help="Recordings of the frame without pendulum; default: a virtual hammer test of it.",
    ),
]
Model = Annotated[str, typer.Option("--model", help="MJCF file or shipped model, the true rig.")]
At = Annotated[
    Excited,
    typer.Option(
        "--excite",
        help="ground: shaker on the unbolted ground; floor1: force on it; table: shake table.",
    ),
]
Delay = Annotated[
    int, typer.Option("--delay", min=0, max=8, help="Computation delay of the loop [samples].")
]
Inertia = Annotated[
    About,
    typer.Option("--inertia-about", help="Which reading of I_zz,3 the design takes (56)."),
]
Noise = Annotated[
    float, typer.Option("--noise", min=0, help="Noise of the hammer test, share of the RMS.")
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("control", epilog="Example: twin control --out lab --json -")(control_absorber)


def control_absorber(
    recordings: Recordings = None,
    model: Model = "two_storey_absorber",
    excite: At = Excited.ground,
    settings: Annotated[
        Path | None, typer.Option("--settings", help="Settings that twin tune has written.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option("--rate", help="Rate of the controller [Hz]; default 32.")
    ] = None,
    delay: Delay = 1,
    torque_limit: Annotated[
        float | None, typer.Option("--torque-limit", help="Of the motor [N m]; default 0.5.")
    ] = None,
    ramp: Annotated[
        float | None, typer.Option("--ramp", help="Soft start [s]; default 10.")
    ] = None,
    inertia_about: Inertia = About.centre,
    printed: Annotated[
        bool,
        typer.Option("--printed-frequencies", help="(57) at 1.9 and 6.8 Hz, not the plant's own."),
    ] = False,
    earthquake: Annotated[
        Path | None, typer.Option("--earthquake", help="A ground motion; needs --excite table.")
    ] = None,
    peak: Annotated[
        float, typer.Option("--peak", help="Scale the earthquake to this peak [m/s^2].")
    ] = 0.15,
    noise: Noise = 0.01,
    out: Out = None,
    seed: Seed = 0,
    json: Json = None,
    rerun: Rerun = False,
) -> None:
    """Identify the frame, design the LQG absorber on it and close the loop in MuJoCo.

    Control is off for 32 s and on for 32 s. Reductions are those of (60), from switching on, and
    over the last half of each when the vibration is steady. The same is done with a controller that
    knows the true plant. With --out, DIR gets the controller as MAT, CSV and C, the run as run.csv,
    figures and a Rerun recording.
    """
    from dataclasses import replace

    from twin.cli.control_results import about, show, write_run
    from twin.control.export import export
    from twin.control.plant import Plant
    from twin.control.study import identified_model, judged
    from twin.model import Twin
    from twin.view.control_report import write_control

    check_json_target(json)
    if out is not None:
        check_folder(out)
    chosen = read_settings(settings)
    changes: dict[str, Any] = {"rate_hz": rate, "torque_limit": torque_limit, "ramp_s": ramp}
    chosen = replace(chosen, **{k: v for k, v in changes.items() if v is not None})
    plant = Plant(Twin.load(model), KNOWN_INPUT[excite.value], delay, chosen.torque_limit)
    pendulum = pendulum_read(plant, inertia_about)
    true = plant.linear()
    # what cannot be is refused before the long work begins
    chosen.design(true, delay)
    excitation = excitation_of(plant, earthquake, peak, printed)
    screen = console(json)
    with watched(rerun) as viewer:
        tell = viewer.tell if viewer is not None else _silent
        shown = Console(stderr=True)
        with Progress(console=shown, transient=True, disable=not shown.is_terminal) as bar:
            tell("identifying")
            identification = identification_of(recordings, plant, noise, seed, bar)
            believed = identified_model(identification, pendulum, plant.known_input)
            results, outcomes, controllers = [], [], []
            for label, design in (("identified", believed), ("true", true)):
                tell(f"closing the loop with a controller of the {label} model")
                controller = chosen.design(design, delay)
                task = bar.add_task(f"loop, {label} model", total=1.0)
                outcome = _run(plant, controller, excitation, seed, bar, task)
                results.append(judged(outcome, controller, design, delay))
                outcomes.append(outcome)
                controllers.append(controller)
        if viewer is not None:
            from twin.view.control_rrd import blueprint, log_control

            viewer.stream.send_blueprint(blueprint(outcomes[0]))
            log_control(viewer.stream, outcomes[0], plant, controllers[0], believed)
        result = {
            **results[0],
            "with_true_model": results[1],
            **about(plant, pendulum, identification, outcomes[0]),
            "settings": chosen.as_json(),
        }
        show(screen, result)
        if out is not None:
            written = [*export(controllers[0], out), write_run(outcomes[0], out / "run.csv")]
            origin = made([model, *(recordings or []), *filter(None, [settings, earthquake])], seed)
            about_it = outcomes[0], plant, controllers[0], believed, result, origin
            written += write_control(out, *about_it)
            write_json(result, str(out / "control.json"))
            screen.print(
                f"{len(written) + 1} files in {out}: controller.c, .mat, .csv, run.csv, "
                f"control.html, figures; look at it: twin view {written[-1]}"
            )
        write_json(result, json)


def _silent(message: str) -> None:
    del message


def read_settings(path: Path | None) -> Settings:
    """Return the settings in a file, or the defaults."""
    import json as reader

    from twin.control.study import Settings

    if path is None:
        return Settings()
    try:
        found = reader.loads(path.read_text(encoding="utf-8"))
        return Settings.from_json(found.get("settings", found))
    except (OSError, ValueError, AttributeError) as error:
        raise TwinError(f"{path}: no settings of a controller ({error})") from None


def pendulum_read(plant: Plant, about: About) -> Pendulum:
    """Return the pendulum of the model file, its inertia read about the centre or the pivot."""
    from dataclasses import replace

    from twin.control.bare import pendulum_of

    found = pendulum_of(plant.twin)
    return replace(found, inertia_about="centre" if about is About.centre else "pivot")


def identification_of(
    recordings: list[Path] | None, plant: Plant, noise: float, seed: int, bar: Progress
) -> Identification:
    """Identify the frame from files, or from a virtual hammer test."""
    from twin.control.study import hammer_tests, identify_frame
    from twin.formats import read_recording

    task = bar.add_task("identification", total=None)
    if recordings:
        found = [read_recording(path) for path in recordings]
    else:
        found = list(hammer_tests(plant, noise, seed))
    identification = identify_frame(found)
    bar.update(task, total=1, completed=1)
    return identification


def excitation_of(
    plant: Plant, earthquake: Path | None, peak: float, printed: bool
) -> Earthquake | WorstCase:
    """Return the earthquake in a file, or (57)."""
    from twin.control.study import worst_case
    from twin.laboratory import read_ground_motion

    if earthquake is None:
        return worst_case(plant, printed)
    if plant.known_input != KNOWN_INPUT["table"]:
        raise TwinError("an earthquake needs the shake table: add --excite table")
    return read_ground_motion(earthquake, peak)


def _run(
    plant: Plant,
    controller: Controller,
    excitation: Earthquake | WorstCase,
    seed: int,
    bar: Progress,
    task: TaskID,
) -> Outcome:
    from twin.control.closed_loop import run
    from twin.control.study import shaken
    from twin.laboratory import Earthquake

    def report(share: float) -> None:
        bar.update(task, completed=share)

    if isinstance(excitation, Earthquake):
        return shaken(plant, controller, excitation, seed, report)
    return run(plant, controller, excitation, seed=seed, progress=report)
