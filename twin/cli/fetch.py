"""``twin fetch``: public benchmark recordings as files that the other commands read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from twin.cli.common import Json, Out, check_folder, check_json_target, console, write_json
from twin.errors import TwinError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("fetch", epilog="Example: twin fetch silverbox --out silverbox")(fetch)


def fetch(
    name: Annotated[
        str | None, typer.Argument(help="silverbox, f16, lanl_bumper or bouc_wen.")
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="Say what there is.")] = False,
    source: Annotated[
        str | None,
        typer.Option(
            "--from", metavar="FOLDER|URL",
            help="A folder (or file://) with the archive or its files, or a mirror's address.",
        ),
    ] = None,
    out: Out = None,
    json: Json = None,
) -> None:  # fmt: skip
    """Get a benchmark's recordings, check their SHA-256 and write them as CSV in SI units.

    Archives are kept in the cache of this user (FRAME_TWIN_CACHE names another folder), so that the
    second time needs no network.
    """
    from twin.fetching import SETS, benchmark_set
    from twin.fetching import fetch as whole

    check_json_target(json)
    terminal = console(json)
    if listed:
        for one in SETS:
            terminal.print(f"{one.name:12s} {one.title}\n{'':12s} {one.page}\n{'':12s} {one.cite}",
                           soft_wrap=True)  # fmt: skip
        write_json({"sets": [{"name": s.name, "title": s.title, "page": s.page} for s in SETS]},
                   json)  # fmt: skip
        return
    if name is None:
        raise TwinError("fetch needs a name; twin fetch --list says which there are")
    chosen = benchmark_set(name)
    target = out or Path(f"twin-{name}")
    check_folder(target)
    found = whole(name, target, source)
    result: dict[str, Any] = {
        "name": name,
        "files": [str(path) for path in found.files],
        "notes": list(found.notes),
        "cite": chosen.cite,
    }
    terminal.print(f"{len(found.files)} recordings in {target}, the first is {found.files[0].name}",
                   soft_wrap=True)  # fmt: skip
    for note in found.notes:
        terminal.print(f"  {note}", soft_wrap=True)
    terminal.print(f"  cite: {chosen.cite}", soft_wrap=True)
    terminal.print(f"try: {chosen.diagnosis.format(out=target)}", soft_wrap=True)
    write_json(result, json)
