"""A picture of a Rerun recording, from a viewer without a window, for this computer only."""

from __future__ import annotations

import re
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from twin.errors import TwinError
from twin.files import write_whole
from twin.view.viewer import LOCAL, ended, free_port, started, wait

ATTEMPTS = 30
PAUSE_S = 0.4

DRIVER = "it needs a Vulkan driver, such as Debian's mesa-vulkan-drivers"


SIZE = (1920, 1080)
NARROW = 800
"""Below this width [pixel] the views do not stand beside one another: one is shown."""


def screenshot(
    recording: Path,
    picture: Path,
    at_s: float | None = None,
    size: tuple[int, int] = SIZE,
    view: str | None = None,
) -> Path:
    """Open the recording in a headless viewer and write what it shows as PNG.

    Args:
        recording: an .rrd file.
        picture: the PNG to write.
        at_s: time to show [s].
        size: width and height of the window [pixel].
        view: a part of the name of the one view to show; on a narrow window the first without.

    Raises:
        TwinError: the viewer cannot start (it needs a Vulkan driver), or cannot show this; there
            is no such view.
    """
    from rerun.experimental import ViewerClient

    last = b""
    with tempfile.TemporaryFile() as said, _viewer(said, size) as (process, port):
        try:
            wait(process, port)
            client = ViewerClient.connect(f"rerun+http://{LOCAL}:{port}/proxy")
            client.open(str(recording.resolve()))
            if view is not None or size[0] < NARROW:
                _show_one(client, view or "")
            if at_s is not None:
                client.set_time("time", duration=at_s, play_state="paused")
            for _ in range(ATTEMPTS):
                now = client.take_screenshot()
                if now == last:
                    break
                last = now
                time.sleep(PAUSE_S)
        except TwinError as error:
            raise TwinError(f"{recording}: {error}") from None
        except Exception as error:  # the viewer's process ends, and its client says how it sees it
            said.seek(0)
            reason = complaint(said.read().decode("utf-8", "replace"), str(error))
            raise TwinError(f"{recording}: the headless Rerun viewer takes no picture: {reason}") \
                from None  # fmt: skip
    return write_whole(picture, lambda part: part.write_bytes(last))


def _show_one(client: Any, wanted: str) -> None:
    """Put all views into tabs, the wanted one in front."""
    for _ in range(ATTEMPTS):
        views = client.get_state().views
        if views:
            break
        time.sleep(PAUSE_S)
    names = sorted((view.name, f"/view/{view.view_id}") for view in views)
    layout = client.get_blueprint().blueprint
    client.set_blueprint(one_view(layout, names, wanted), of="recording")


def one_view(
    layout: dict[str, Any], names: Sequence[tuple[str, str]], wanted: str
) -> dict[str, Any]:
    """Return a blueprint whose views are tabs.

    Args:
        layout: the blueprint, by entity path.
        names: name and path of every view.
        wanted: a part of the name of the view in front, the first without.

    Raises:
        TwinError: no view has it.
    """
    found = [path for name, path in names if wanted.lower() in name.lower()]
    if not found:
        raise TwinError(
            f"no view '{wanted}'; there are {', '.join(sorted({name for name, _ in names}))}"
        )
    root = layout["/viewport"]["ViewportBlueprint"]["root_container"]
    tabs = {
        "container_kind": "Tabs",
        "contents": [path for _, path in names],
        "active_tab": found[0],
        "visible": True,
    }
    gone = {"Clear": {"is_recursive": True}}
    out = {p: gone if p.startswith("/container/") else what for p, what in layout.items()}
    return {**out, f"/container/{root}": {"ContainerBlueprint": tabs}}


def complaint(said: str, error: str) -> str:
    """Return why there is no picture, in a line: the viewer's last words, else its client's."""
    found = re.search(r"panicked at '?(.*?)'?\s*\n", said)
    words = " ".join((found[1] if found else error).split())[:160]
    missing = re.search(r'No glyph for "(.*?)"', words)
    if missing:
        return f"its font lacks the letter {missing[1]!r} of a name in this recording"
    return f"{words or 'it ended at once'}; {DRIVER}"


@contextmanager
def _viewer(
    said: IO[bytes], size: tuple[int, int] = SIZE
) -> Iterator[tuple[subprocess.Popen[Any], int]]:
    """Run a viewer without a window on a free port of this computer only."""
    port = free_port()
    window = ["--window-size", "{}x{}".format(*size)]
    process = started(["--headless", "--hide-welcome-screen", *window], port, said)
    try:
        yield process, port
    finally:
        ended(process)
