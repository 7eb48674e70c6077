"""Where a result comes from: command, versions, files with their SHA-256, seed, date."""

from __future__ import annotations

import hashlib
import os
import platform
import shlex
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("frame-twin", "mujoco", "numpy", "scipy")
"""Packages that numbers depend on."""

BLOCK = 1 << 20


@dataclass(frozen=True)
class Provenance:
    """What it takes to make a result again.

    Attributes:
        date: when, as "2026-05-04 13:05 UTC".
        versions: name and version of each program.
        command: as a shell takes it; empty from Python.
        files: name and SHA-256 of each file that was read.
        seed: of what is random, or None.
    """

    date: str
    versions: tuple[tuple[str, str], ...]
    command: str = ""
    files: tuple[tuple[str, str], ...] = ()
    seed: int | None = None

    def rows(self) -> Iterator[tuple[str, str]]:
        """Return what and how much, a line each."""
        if self.command:
            yield "command", self.command
        yield "date", self.date
        yield "versions", ", ".join(f"{name} {number}" for name, number in self.versions)
        if self.seed is not None:
            yield "seed", str(self.seed)


def provenance(
    command: Sequence[str] = (), files: Iterable[str | Path] = (), seed: int | None = None
) -> Provenance:
    """Return the provenance of a result that is made now.

    The date is SOURCE_DATE_EPOCH where that is set, so that the same files can be made again.

    Args:
        command: its arguments, "twin" left out.
        files: that were read; what is no file (a shipped model's name) is left out.
        seed: of what is random.
    """
    found = [(str(path), sha256(Path(path))) for path in files if Path(path).is_file()]
    line = shlex.join(["twin", *command]) if command else ""
    return Provenance(_date(), _versions(), line, tuple(dict.fromkeys(found)), seed)


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file, 64 hexadecimal digits."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            digest.update(block)
    return digest.hexdigest()


def _date() -> str:
    set_to = os.environ.get("SOURCE_DATE_EPOCH", "")
    moment = datetime.fromtimestamp(int(set_to), UTC) if set_to.isdigit() else datetime.now(UTC)
    return moment.strftime("%Y-%m-%d %H:%M UTC")


def _versions() -> tuple[tuple[str, str], ...]:
    out = [("Python", platform.python_version())]
    for name in PACKAGES:
        try:
            out.append((name, version(name)))
        except PackageNotFoundError:
            continue
    return (*out, (platform.system(), platform.machine()))
