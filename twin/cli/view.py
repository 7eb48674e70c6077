"""``twin view``: open a Rerun recording, or take its picture."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer

from twin.errors import TwinError

MAGIC = b"RRF"
MIN_PX, MAX_PX = 200, 8192
"""Of a picture's width and height; most graphics drivers draw no larger one."""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("view")(view)


def view(
    recording: Annotated[Path, typer.Argument(metavar="FILE.rrd", help="A Rerun recording.")],
    screenshot: Annotated[
        Path | None,
        typer.Option("--screenshot", metavar="PNG", help="Write a picture; open no window."),
    ] = None,
    web: Annotated[
        bool, typer.Option("--web", help="Show it in the browser, where no window can open.")
    ] = False,
    time: Annotated[
        float | None, typer.Option("--time", metavar="S", help="Time to show in the picture [s].")
    ] = None,
    size: Annotated[
        str, typer.Option("--size", metavar="WxH", help="Size of the picture [pixel].")
    ] = "1920x1080",
    part: Annotated[
        str | None,
        typer.Option("--part", metavar="NAME", help="The one view to show in the picture."),
    ] = None,
) -> None:
    """Open a Rerun recording in the viewer.

    Where no window can open, --web shows it in a browser of this computer.

    Example: twin view twin-demo/identification.rrd
    """
    check_rrd(recording)
    if screenshot is not None:
        from twin.view.screenshot import screenshot as take

        typer.echo(f"written: {take(recording, screenshot, time, _pixels(size), part)}")
        return
    from twin.view.viewer import window_can_open

    if not web and not window_can_open():
        raise TwinError("no window can open here; give --web, or --screenshot PNG for a picture")
    # the viewer listens on all addresses unless told not to
    arguments = ["--bind", "127.0.0.1", *(["--serve-web"] if web else []), str(recording)]
    try:
        done = subprocess.run([sys.executable, "-m", "rerun", *arguments], check=False)
    except KeyboardInterrupt:
        return
    if done.returncode:
        raise TwinError(f"{recording}: the Rerun viewer ended with code {done.returncode}")


def _pixels(size: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{2,5})x(\d{2,5})", size)
    if match is None or not all(MIN_PX <= int(n) <= MAX_PX for n in match.groups()):
        raise TwinError(f"--size {size}: write it as 400x800, each {MIN_PX} to {MAX_PX}")
    return int(match[1]), int(match[2])


def check_rrd(recording: Path) -> None:
    """Raise TwinError unless the file is a Rerun recording."""
    if not recording.is_file():
        raise TwinError(f"{recording}: no such file; twin demo and twin identify write one")
    with recording.open("rb") as file:
        if file.read(3) != MAGIC:
            raise TwinError(f"{recording}: not a Rerun recording (.rrd)")
