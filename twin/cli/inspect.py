"""``twin inspect``: what a model offers, or what a recording holds."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from twin.cli.common import Json, check_json_target
from twin.cli.convert import Map, Rate
from twin.errors import TwinError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("inspect")(inspect)


def inspect(
    what: Annotated[
        str,
        typer.Argument(metavar="MODEL|RECORDING", help="MJCF, shipped model's name, or recording."),
    ],
    channel_map: Map = None,
    rate: Rate = None,
    model: Annotated[
        str | None,
        typer.Option("--model", help="Of a recording: suggest a --map to this model's channels."),
    ] = None,
    json: Json = None,
) -> None:
    """List what a model offers, or what a recording holds.

    Of a model: inputs, sensors, ports, bodies, modes and which mechanisms can sit where. Of a
    recording: channels, units, rate, faults, and the --map it suggests.

    Example: twin inspect portal_3d --json portal.json
    """
    from twin.model_files import shipped_names

    check_json_target(json)
    if what.endswith(".xml") or (what in shipped_names() and not Path(what).is_file()):
        from twin.cli.inspect_model import inspect_model

        inspect_model(what, json)
        return
    if not Path(what).exists():
        raise TwinError(
            f"{what}: no such file, and no model that comes with the package; those are "
            f"{', '.join(shipped_names())}"
        )
    import_module("twin.cli.inspect_recording").inspect_recording(
        Path(what), channel_map, rate, json, model
    )
