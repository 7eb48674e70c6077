"""A picture of a Rerun recording, from a viewer without a window, for this computer only."""

from __future__ import annotations

import re
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from twin.errors import TwinError
from twin.files import write_whole
from twin.view.viewer import LOCAL, ended, free_port, started, wait

ATTEMPTS = 30
PAUSE_S = 0.4

DRIVER = "it needs a Vulkan driver, such as Debian's mesa-vulkan-drivers"


def screenshot(recording: Path, picture: Path, at_s: float | None = None) -> Path:
    """Open the recording in a headless viewer and write what it shows as PNG.

    Args:
        recording: an .rrd file.
        picture: the PNG to write.
        at_s: time to show [s].

    Raises:
        TwinError: the viewer cannot start (it needs a Vulkan driver), or cannot show this.
    """
    from rerun.experimental import ViewerClient

    last = b""
    with tempfile.TemporaryFile() as said, _viewer(said) as (process, port):
        try:
            wait(process, port)
            client = ViewerClient.connect(f"rerun+http://{LOCAL}:{port}/proxy")
            client.open(str(recording.resolve()))
            if at_s is not None:
                client.set_time("time", duration=at_s, play_state="paused")
            for _ in range(ATTEMPTS):
                now = client.take_screenshot()
                if now == last:
                    break
                last = now
                time.sleep(PAUSE_S)
        except Exception as error:  # the viewer's process ends, and its client says how it sees it
            said.seek(0)
            reason = complaint(said.read().decode("utf-8", "replace"), str(error))
            raise TwinError(f"{recording}: the headless Rerun viewer takes no picture: {reason}") \
                from None  # fmt: skip
    return write_whole(picture, lambda part: part.write_bytes(last))


def complaint(said: str, error: str) -> str:
    """Return why there is no picture, in a line: the viewer's last words, else its client's."""
    found = re.search(r"panicked at '?(.*?)'?\s*\n", said)
    words = " ".join((found[1] if found else error).split())[:160]
    missing = re.search(r'No glyph for "(.*?)"', words)
    if missing:
        return f"its font lacks the letter {missing[1]!r} of a name in this recording"
    return f"{words or 'it ended at once'}; {DRIVER}"


@contextmanager
def _viewer(said: IO[bytes]) -> Iterator[tuple[subprocess.Popen[Any], int]]:
    """Run a viewer without a window on a free port of this computer only."""
    port = free_port()
    process = started(["--headless", "--hide-welcome-screen"], port, said)
    try:
        yield process, port
    finally:
        ended(process)
