"""``twin identify``: modes, matrices and their uncertainty from recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    refuse_doubles,
    write_json,
)
from twin.cli.convert import Map, Rate
from twin.cli.identify_others import choice, driven, from_outputs, from_responses, telling
from twin.cli.identify_update import write_updated
from twin.errors import TwinError

if TYPE_CHECKING:
    from twin.identification.result import Identification
    from twin.recording import Recording

DEFAULT_FOLDER = Path("twin-identify")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("identify")(identify_recordings)


def identify_recordings(
    recordings: Annotated[
        list[Path], typer.Argument(metavar="RECORDING...", help="Recordings of one structure.")
    ],
    order: Annotated[
        int | None,
        typer.Option("--order", min=1, help="Number of states; default: the data decide."),
    ] = None,
    p: Annotated[
        int | None, typer.Option("--p", min=1, help="Number of observer Markov parameters.")
    ] = None,
    inputs: Annotated[
        list[str] | None, typer.Option("--input", help="Input channel; repeat for several.")
    ] = None,
    outputs: Annotated[
        list[str] | None, typer.Option("--output", help="Output channel; repeat.")
    ] = None,
    band: Annotated[
        tuple[float, float] | None,
        typer.Option("--band", metavar="LOW HIGH", help="Frequencies to use [Hz]."),
    ] = None,
    channel_map: Map = None,
    rate: Rate = None,
    period: Annotated[
        int | None,
        typer.Option("--period", min=2, help="Samples in a period; the mean period is fitted."),
    ] = None,
    unseen: Annotated[
        int, typer.Option("--unseen", min=0, help="Last periods, kept for validation.")
    ] = 0,
    tests: Annotated[
        list[Path] | None,
        typer.Option("--test", metavar="FILE...", help="Recordings kept for validation."),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option("--model", help="MJCF to lay beside and to update to the identified modes."),
    ] = None,
    tolerance: Annotated[
        float,
        typer.Option(
            "--tolerance",
            min=0,
            help="How well the model's masses and stiffnesses are known, as a share.",
        ),
    ] = 0.01,
    pick: Annotated[
        bool,
        typer.Option("--pick", help="Choose poles in a window with the stabilisation diagram."),
    ] = False,
    poles: Annotated[
        str | None,
        typer.Option("--poles", metavar="HZ,HZ,...", help="Choose the stable poles nearest these."),
    ] = None,
    output_only: Annotated[
        bool,
        typer.Option("--output-only", help="No input was measured: modes without scale."),
    ] = False,
    window: Annotated[
        float | None,
        typer.Option(
            "--exponential-window",
            metavar="TAU",
            help="Time constant [s] of a window exp(-t/TAU) that the records have.",
        ),
    ] = None,
    out: Out = None,
    seed: Seed = 0,
    json: Json = None,
) -> None:
    """Identify natural frequencies, damping, mode shapes and matrices with their uncertainty.

    OKID/ERA, then maximum likelihood; the line "estimate" says which of the two was taken. Figures
    and a Rerun recording go to the folder of --out.

    Example: `twin identify hits/*.csv --model two_storey_lumped --out found --json found.json`
    """
    from twin.formats import parse_channel_map, read_recording
    from twin.formats.responses import holds_responses
    from twin.identification.as_json import as_json
    from twin.identification.exponential_window import identification_without_window
    from twin.identification.identify import identify
    from twin.identification.records import LEAST_SAMPLES
    from twin.model import Twin
    from twin.signals.periods import last_periods, mean_period
    from twin.view.report import print_identification, write_identification

    if unseen and not period:
        raise TwinError("--unseen counts periods: say how long one is with --period")
    if period is not None and period < LEAST_SAMPLES:
        raise TwinError(f"--period {period}: a period has at least {LEAST_SAMPLES} samples")
    if band is not None and not 0 <= band[0] < band[1]:
        raise TwinError(f"--band {band[0]:g} {band[1]:g}: two frequencies [Hz], the lower first")
    refuse_doubles([*recordings, *(tests or [])])
    chosen = choice(pick, poles)
    check_json_target(json)
    target = out or DEFAULT_FOLDER
    check_folder(target)
    terminal = console(json)
    origin = made([*recordings, *(tests or []), *([model] if model else [])], seed)
    if holds_responses(recordings[0]):
        return from_responses(recordings, band, window, chosen, terminal, target, origin, json)
    mapping = parse_channel_map(channel_map or [])
    truth = Twin.load(model) if model else None
    train = [read_recording(path, mapping, rate) for path in recordings]
    if output_only or not (inputs or any(driven(r) for r in train)):
        if window is not None:
            raise TwinError("--exponential-window needs a measured force or frequency responses")
        return from_outputs(train, outputs, band, chosen, terminal, target, origin, json)
    kept = [read_recording(path, mapping, rate) for path in tests or []]
    if period:
        kept += [last_periods(r, period, unseen) for r in train if unseen]
        train = [mean_period(r, period, unseen) for r in train]
    with terminal.status("identifying") as status:
        result = identify(train, order, p, inputs, outputs, band, telling(status), chosen)
    errors = unseen_errors(result, kept)
    if window is not None:
        result = identification_without_window(result, window)
    print_identification(terminal, result, truth, errors)
    files = write_identification(folder(target), result, truth, made=origin, unseen=errors)
    terminal.print(f"written: {', '.join(str(path) for path in files)}")
    more = {} if truth is None else write_updated(truth, result, tolerance, target, terminal)
    write_json(as_json(result) | {"unseen_nrmse": errors} | more, json)


def unseen_errors(result: Identification, recordings: list[Recording]) -> dict[str, float]:
    """Return the NRMSE on each recording that the fit has not seen."""
    from twin.identification.unseen import unseen_nrmse

    return {
        f"{recording.source} from {recording.start_s:g} s": unseen_nrmse(result, recording)
        for recording in recordings
    }
