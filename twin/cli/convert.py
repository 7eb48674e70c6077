"""``twin convert``: recordings from one format to another, in SI units."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from twin.cli.common import Json, check_json_target, write_json
from twin.errors import TwinError

Map = Annotated[
    list[str] | None,
    typer.Option(
        "--map",
        metavar="'COLUMN=CHANNEL [UNIT]'",
        help="What a column of the file is, e.g. 'Force=force_floor1 [N]'. Repeat it for each "
        "column that is wanted; the others are left out.",
    ),
]
Rate = Annotated[
    float | None,
    typer.Option("--rate", metavar="HZ", help="Sampling rate of a file without time."),
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("convert")(convert)


def convert(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="IN OUT", help="Recording to read, with --responses several; file to write."
        ),
    ],
    channel_map: Map = None,
    rate: Rate = None,
    resample: Annotated[
        float | None,
        typer.Option("--resample", metavar="HZ", help="New sampling rate, band-limited."),
    ] = None,
    start: Annotated[
        float | None, typer.Option("--start", metavar="S", help="First time to keep [s].")
    ] = None,
    stop: Annotated[
        float | None, typer.Option("--stop", metavar="S", help="First time to leave out [s].")
    ] = None,
    responses: Annotated[
        str | None,
        typer.Option(
            "--responses",
            metavar="H1|H2|Hv",
            help="Write frequency responses by this estimator, averaged over all recordings, with "
            "coherence and standard deviation, as CSV.",
        ),
    ] = None,
    json: Json = None,
) -> None:
    """Read a recording, convert it to SI units and write it in the format of OUT's suffix.

    Reads CSV, Excel, UFF-58, MAT, TDMS, MCAP, HDF5 and NumPy files; writes all of them but Excel's,
    TDMS and MCAP.

    Example: twin convert hits/hammer_floor1_01.csv hit.h5 --resample 16 --start 1
    """
    from twin.formats import parse_channel_map, read_recording, write_recording
    from twin.signals.sections import resample_recording, trim_seconds

    check_json_target(json)
    *sources, target = files
    if responses is not None:
        from twin.cli.convert_responses import convert_responses

        if resample is not None or start is not None or stop is not None:
            raise TwinError("--responses takes whole recordings: convert them first")
        convert_responses(sources, target, responses, channel_map, rate, json)
        return
    if len(sources) != 1:
        raise TwinError(
            f"convert takes IN and OUT, here are {len(files)} files; several recordings go with "
            "--responses"
        )
    (source,) = sources
    recording = read_recording(source, parse_channel_map(channel_map or []), rate)
    if resample is not None:
        # before trimming, so that the filter sees what lies beyond the ends
        recording = resample_recording(recording, resample)
    if start is not None or stop is not None:
        recording = trim_seconds(recording, start, stop)
    write_recording(recording, target)
    for note in recording.notes:
        typer.echo(f"twin: {note}", err=True)
    typer.echo(
        f"{target}: {recording.samples} samples at {recording.sampling_hz:.9g} Hz "
        f"({recording.duration_s:.6g} s) of {', '.join(recording.names)}",
        err=json == "-",
    )
    write_json(
        {
            "input": str(source),
            "output": str(target),
            "sampling_hz": recording.sampling_hz,
            "samples": recording.samples,
            "start_s": recording.start_s,
            "duration_s": recording.duration_s,
            "channels": [{"name": c.name, "unit": c.unit} for c in recording.channels],
            "notes": list(recording.notes),
        },
        json,
    )
