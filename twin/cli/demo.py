"""``twin demo``: the whole chain on a virtual hammer test."""

from __future__ import annotations

from pathlib import Path

import typer

from twin.cli.common import (
    Json,
    Out,
    Seed,
    check_folder,
    check_json_target,
    console,
    folder,
    made,
    write_json,
)

DEFAULT_FOLDER = Path("twin-demo")
MODEL = "two_storey"
PEAK_N = 1.0
"""A light tap: the true modes are those of small vibration, and the flexible frame softens."""
NOISE = 0.01


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("demo")(demo)


def demo(out: Out = None, seed: Seed = 0, json: Json = None) -> None:
    """Do a hammer test in MuJoCo, identify the frame, find a concealed effect.

    The paper's test: first floor, 32 Hz, 32 s, anti-alias cut-off 16 Hz; 1 % noise on force and
    accelerations. Then an effect is concealed in a rig, and its recordings are diagnosed with a
    model that lacks it. Writes recordings, figures, a report and two Rerun recordings.

    Example: twin demo --out twin-demo --seed 0
    """
    from twin.formats import write_recording
    from twin.identification.as_json import as_json
    from twin.identification.identify import identify
    from twin.instruments import Instrument
    from twin.laboratory import Experiment, Hammer, perform
    from twin.model import Twin
    from twin.view.report import print_identification, write_identification

    check_json_target(json)
    terminal = console(json)
    target = folder(check_folder(out or DEFAULT_FOLDER))
    rig = Twin.load(MODEL)
    instruments = {kind: Instrument(noise_fraction=NOISE) for kind in ("acc", "force")}
    test = Experiment(Hammer(peak_n=PEAK_N), instruments=instruments)
    with terminal.status("hitting the first floor"):
        performance = perform(test, rig, seed)
    write_recording(performance.recording, target / "hammer.csv")
    with terminal.status("identifying"):
        result = identify([performance.recording])
    print_identification(terminal, result, rig)
    with terminal.status("drawing"):
        origin = made([target / "hammer.csv"], seed)
        files = write_identification(target, result, rig, performance, origin)
    terminal.print(f"written: {', '.join(str(p) for p in [target / 'hammer.csv', *files])}")
    terminal.print(f"look at it: twin view {files[-1]}")
    from twin.cli.demo_concealed import find_concealed

    find_concealed(target / "concealed", terminal, seed)
    write_json(as_json(result), json)
