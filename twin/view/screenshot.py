"""A picture of a Rerun recording, from a viewer without a window, for this computer only."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from twin.errors import TwinError
from twin.files import write_whole

ATTEMPTS = 30
PAUSE_S = 0.4

LOCAL = "127.0.0.1"
START_S = 20.0
"""How long the viewer may take to listen [s]."""

STOP_S = 5.0
"""How long it may take to end [s]."""

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
            _wait(process, port)
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
    with socket.socket() as free:
        free.bind((LOCAL, 0))
        port = free.getsockname()[1]
    command = [
        sys.executable, "-m", "rerun", "--headless", "--hide-welcome-screen",
        "--bind", LOCAL, "--port", str(port),
    ]  # fmt: skip
    # a session of its own: the viewer is a child of what is started, and both have to end
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True
    )
    try:
        yield process, port
    finally:
        _end(process)


def _end(process: subprocess.Popen[Any]) -> None:
    if not hasattr(os, "killpg"):
        process.terminate()
        return
    for how in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, how)
            process.wait(STOP_S)
        except ProcessLookupError:
            process.poll()
            return
        except subprocess.TimeoutExpired:
            continue


def _wait(process: subprocess.Popen[Any], port: int) -> None:
    """Wait until the viewer listens. Raises RuntimeError when it ends instead."""
    end = time.monotonic() + START_S
    while time.monotonic() < end:
        if process.poll() is not None:
            raise RuntimeError(f"it ended with code {process.returncode}")
        try:
            socket.create_connection((LOCAL, port), 0.2).close()
            return
        except OSError:
            time.sleep(0.1)
    raise RuntimeError(f"it did not listen within {START_S:g} s")
