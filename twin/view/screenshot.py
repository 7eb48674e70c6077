"""A picture of a Rerun recording, from a viewer without a window."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from twin.errors import TwinError
from twin.files import write_whole

ATTEMPTS = 30
PAUSE_S = 0.4


def _viewer() -> str | None:
    """Return the viewer beside this Python; a shell whose PATH lacks it finds it all the same."""
    beside = Path(sys.executable).with_name("rerun")
    return str(beside) if beside.exists() else None


@contextmanager
def _quietly() -> Iterator[None]:
    """Keep what the viewer's process writes, a panic of 35 lines for one, from the terminal."""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def screenshot(recording: Path, picture: Path, at_s: float | None = None, port: int = 9977) -> Path:
    """Open the recording in a headless viewer and write what it shows as PNG.

    Args:
        recording: an .rrd file.
        picture: the PNG to write.
        at_s: time to show [s].
        port: of the viewer.

    Raises:
        TwinError: the viewer cannot start (it needs a Vulkan driver).
    """
    from rerun.experimental import ViewerClient

    last = b""
    try:
        with _quietly():
            viewer = ViewerClient.spawn(
                headless=True, port=port, hide_welcome_screen=True, executable_path=_viewer()
            )
            try:
                viewer.open(str(recording.resolve()))
                if at_s is not None:
                    viewer.set_time("time", duration=at_s, play_state="paused")
                for _ in range(ATTEMPTS):
                    now = viewer.take_screenshot()
                    if now == last:
                        break
                    last = now
                    time.sleep(PAUSE_S)
            finally:
                viewer.quit()
    except (
        Exception
    ) as error:  # the viewer's own process ends, and its client says how it sees that
        reason = " ".join(str(error).split())[:120]
        raise TwinError(
            f"{recording}: the headless Rerun viewer takes no picture ({reason}); it needs a "
            "Vulkan driver, such as Debian's mesa-vulkan-drivers"
        ) from None
    return write_whole(picture, lambda part: part.write_bytes(last))
