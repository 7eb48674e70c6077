"""The Rerun viewer as a process of its own, which only this computer reaches."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

LOCAL = "127.0.0.1"
START_S = 20.0
"""How long the viewer may take to listen [s]."""

STOP_S = 5.0
"""How long it may take to end [s]."""


def free_port() -> int:
    """Return a port of this computer that nothing listens on."""
    with socket.socket() as free:
        free.bind((LOCAL, 0))
        return int(free.getsockname()[1])


def started(arguments: Sequence[str], port: int, said: IO[bytes] | int) -> subprocess.Popen[Any]:
    """Start the viewer; its output goes to ``said``.

    It has a session of its own: the viewer is a child of what is started, and both have to end.
    """
    command = [sys.executable, "-m", "rerun", *arguments, "--bind", LOCAL, "--port", str(port)]
    return subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True
    )


def wait(process: subprocess.Popen[Any], port: int) -> None:
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


def ended(process: subprocess.Popen[Any]) -> None:
    """End the viewer and what it has started; none of it listens any more."""
    if not hasattr(os, "killpg"):
        process.terminate()
        return
    for how in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, how)
        except ProcessLookupError:
            process.poll()
            return
        # its child is not ours to wait for, and may take a while to heed the first signal
        end = time.monotonic() + STOP_S
        while time.monotonic() < end:
            process.poll()
            if not _runs(process.pid):
                process.wait()
                return
            time.sleep(0.02)


def _runs(group: int) -> bool:
    """Return whether a process of a group still runs; one that nobody has waited for does not."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    own = [alive for alive, of in map(_listed, Path("/proc").glob("[0-9]*/stat")) if of == group]
    return not own or any(own)


def _listed(stat: Path) -> tuple[bool, int]:
    """Return whether any thread of a process runs, and its group, as Linux lists them (proc(5))."""
    try:
        fields = stat.read_text().rpartition(")")[2].split()
    except OSError:
        return False, 0
    state, group, threads = fields[0], int(fields[2]), int(fields[17])
    return state not in ("Z", "X") or threads > 1, group


def window_can_open() -> bool:
    """Return whether there is a screen for a window."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
