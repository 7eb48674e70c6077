"""A diagnosis under guard: what is sealed cannot be read while it runs.

The guard refuses, in this process and all its threads, every way in which Python opens, lists,
moves or copies files below a refused path (whatever link or relative path leads there), and every
start of another process, which would run without the guard. It hides the command line, which
holds the seed. Compiled code that opens files by itself is not seen: the diagnosis has none that
reads anything but models.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from twin.errors import TwinError

_PATHS = ("open", "os.", "shutil.", "glob.", "pathlib.", "sqlite3.connect", "tempfile.")
_PROCESSES = (
    "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork",
    "os.forkpty", "os.startfile", "pty.spawn",
)  # fmt: skip
_OF_FOLDERS = ("open", "os.rename", "os.link", "shutil.move", "shutil.copytree", "shutil.rmtree")
"""Events that reach what is below a folder when the folder itself is opened or moved."""

_SECRETS = ("cmdline", "environ", "mem")
"""Files of /proc that show other processes' command lines, and with them the seed."""


class SealedError(TwinError):
    """A diagnosis reached for what is sealed."""


class _Guard:
    def __init__(self, refused: tuple[str, ...]) -> None:
        self.refused = refused
        self.attempts: list[str] = []

    def refuse(self, what: str) -> NoReturn:
        self.attempts.append(what)
        raise SealedError(f"refused while diagnosing: {what}")


_active: list[_Guard] = []
_installed = False


@contextmanager
def guarded(*refused: Path) -> Iterator[list[str]]:
    """Refuse what is at or below these paths, and other processes, until the end of the block.

    Gives the list of what was tried and refused: a diagnosis may have swallowed the error.

    Raises:
        SealedError: within the block, at every such attempt.
    """
    _install()
    guard = _Guard(tuple(os.path.realpath(path) for path in refused))
    arguments = sys.argv, sys.orig_argv
    sys.argv, sys.orig_argv = sys.argv[:1], sys.orig_argv[:1]
    _active.append(guard)
    try:
        yield guard.attempts
    finally:
        _active.remove(guard)
        sys.argv, sys.orig_argv = arguments


def _install() -> None:
    """Add the hook, which Python never removes, and close the door that raises no event."""
    global _installed
    if _installed:
        return
    _installed = True
    sys.addaudithook(_hook)
    try:
        import _posixsubprocess as starter
    except ImportError:  # not on this system
        return
    start = starter.fork_exec

    def fork_exec(*arguments: Any) -> int:  # multiprocessing goes here without an event
        for guard in _active:
            guard.refuse("starting a process")
        return int(start(*arguments))

    starter.fork_exec = fork_exec


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if not _active or not event.startswith((*_PATHS, *_PROCESSES)):
        return
    for guard in tuple(_active):
        if event in _PROCESSES:
            guard.refuse(f"starting a process ({event})")
        for argument in arguments:
            path = _resolved(argument, event)
            if path is not None and _is_refused(path, guard.refused, event in _OF_FOLDERS):
                guard.refuse(f"{event} of {path}")


def _resolved(argument: Any, event: str) -> str | None:
    """Return what a path or a file descriptor leads to; None for anything else."""
    if isinstance(argument, bool):
        return None
    if isinstance(argument, int):
        if event == "open":  # its integers are flags; a descriptor stands as a path elsewhere
            return None
        try:
            return os.readlink(f"/proc/self/fd/{argument}")
        except OSError:
            return None
    if isinstance(argument, (str, bytes, os.PathLike)):
        try:
            return os.path.realpath(os.fsdecode(argument))
        except (OSError, ValueError):
            return None
    return None


def _is_refused(path: str, refused: tuple[str, ...], of_folders: bool) -> bool:
    below = any(path == one or path.startswith(one + os.sep) for one in refused)
    above = of_folders and any(one.startswith(path.rstrip(os.sep) + os.sep) for one in refused)
    secret = path.startswith("/proc/") and os.path.basename(path) in _SECRETS
    return below or above or secret
