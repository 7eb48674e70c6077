"""``twin convert --responses``: frequency responses measured from recordings, as a text file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import typer

from twin.cli.common import write_json
from twin.errors import TwinError, available


def convert_responses(
    sources: Sequence[Path],
    target: Path,
    estimator: str,
    channel_map: list[str] | None,
    rate: float | None,
    json: str | None,
) -> None:
    """Average the spectra of all recordings, divide them, and write what comes out.

    Raises:
        TwinError: no such estimator, or recordings or a file that do not allow it.
    """
    from twin.formats import parse_channel_map, read_recording
    from twin.formats.responses_text import write
    from twin.identification.records import prepare
    from twin.signals.estimators import Estimator
    from twin.signals.frf import measured_response

    known = {name.lower(): name for name in get_args(Estimator)}
    name = known.get(estimator.lower())
    if name is None:
        raise TwinError(f"--responses {estimator}: there are {available(get_args(Estimator))}")
    if target.suffix.lower() != ".csv":
        raise TwinError(f"{target}: frequency responses are written as .csv")
    if not sources:
        raise TwinError("--responses needs a recording to read and a file to write")
    columns = parse_channel_map(channel_map or [])
    records = prepare([read_recording(path, columns, rate) for path in sources])
    found = measured_response(records.pairs, 1 / records.dt, name)
    kinds = {c.name: c.unit for r in records.recordings for c in r.channels}
    lines = write(found, records.outputs, records.inputs, target)
    for note in records.notes:
        typer.echo(f"twin: {note}", err=True)
    if found.coherence is None:
        typer.echo(
            f"twin: {found.blocks} block(s) for {len(records.inputs)} input(s): neither coherence "
            "nor deviations can be told",
            err=True,
        )
    units = ", ".join(
        f"{o} [{kinds[o]}] over {i} [{kinds[i]}]" for o in records.outputs for i in records.inputs
    )
    typer.echo(
        f"{target}: {name} of {units} at {lines} lines ({found.blocks} blocks; {found.method})",
        err=json == "-",
    )
    write_json(
        {
            "input": [str(path) for path in sources],
            "output": str(target),
            "estimator": name,
            "lines": lines,
            "blocks": found.blocks,
            "method": found.method,
            "outputs": list(records.outputs),
            "inputs": list(records.inputs),
            "notes": list(records.notes),
        },
        json,
    )
