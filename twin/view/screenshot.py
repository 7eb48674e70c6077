"""A picture of a Rerun recording, from a viewer without a window."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from twin.errors import TwinError
from twin.files import write_whole

ATTEMPTS = 30
PAUSE_S = 0.4


def _viewer() -> str | None:
    """Return the viewer beside this Python; a shell whose PATH lacks it finds it all the same."""
    beside = Path(sys.executable).with_name("rerun")
    return str(beside) if beside.exists() else None


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

    try:
        viewer = ViewerClient.spawn(
            headless=True, port=port, hide_welcome_screen=True, executable_path=_viewer()
        )
    except Exception as error:
        raise TwinError(
            f"the headless Rerun viewer does not start ({error}); it needs a Vulkan driver, such "
            "as Debian's mesa-vulkan-drivers"
        ) from None
    try:
        viewer.open(str(recording.resolve()))
        if at_s is not None:
            viewer.set_time("time", duration=at_s, play_state="paused")
        last = b""
        for _ in range(ATTEMPTS):
            now = viewer.take_screenshot()
            if now == last:
                break
            last = now
            time.sleep(PAUSE_S)
    finally:
        viewer.quit()
    return write_whole(picture, lambda part: part.write_bytes(last))
