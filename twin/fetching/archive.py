"""The files that are wanted out of a folder, a ZIP archive, or a ZIP archive in one."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath

from twin.errors import RecordingError, available
from twin.fetching.sets import BenchmarkSet

LARGEST = 512 * 2**20
"""Bytes that a single file may have when it is unpacked."""


def members_in(wanted: BenchmarkSet, place: Path) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Return the set's files by name, and notes on those that are not there.

    Args:
        wanted: the set.
        place: the archive, one of the set's files, or a folder that holds either.

    Raises:
        RecordingError: none of the files, a wrong checksum, or a damaged archive.
    """
    found = _from_folder(wanted, place) if place.is_dir() else _from_file(wanted, place)
    if not found:
        raise RecordingError(
            f"{place}: neither {wanted.archive} nor any of {available(wanted.members)} is there"
        )
    for name, data in found.items():
        _check(f"{place}: {name}", data, wanted.members[name])
    missing = [name for name in wanted.members if name not in found]
    return found, (f"not there, so left out: {', '.join(missing)}",) if missing else ()


def _from_folder(wanted: BenchmarkSet, place: Path) -> dict[str, bytes]:
    archive = place / wanted.archive
    if archive.is_file():
        return _from_file(wanted, archive)
    files = {p.name: p for p in sorted(place.rglob("*")) if p.name in wanted.members}
    return {name: path.read_bytes() for name, path in files.items() if path.is_file()}


def _from_file(wanted: BenchmarkSet, path: Path) -> dict[str, bytes]:
    data = path.read_bytes()
    if path.suffix != ".zip" and not wanted.archive.endswith(".zip"):
        _check(str(path), data, wanted.sha256)
        return {wanted.archive: data}
    if path.name in wanted.members:
        return {path.name: data}
    _check(str(path), data, wanted.sha256)
    return _unzipped(data, str(path), wanted.members)


def _unzipped(data: bytes, name: str, members: Mapping[str, object]) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            found = _picked(archive, lambda n: n in members)
            if not found:  # some servers pack the archive once more
                for inner, content in _picked(archive, lambda n: n.endswith(".zip")).items():
                    found |= _unzipped(content, f"{name}/{inner}", members)
            return found
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError) as error:
        raise RecordingError(f"{name}: not a ZIP archive that can be read ({error})") from None


def _picked(archive: zipfile.ZipFile, wanted: Callable[[str], bool]) -> dict[str, bytes]:
    out = {}
    for info in archive.infolist():
        short = PurePosixPath(info.filename).name
        # what macOS adds to its archives has the same names
        if wanted(short) and "__MACOSX" not in info.filename and info.file_size <= LARGEST:
            out[short] = archive.read(info)
    return out


def _check(what: str, data: bytes, sha256: str | None) -> None:
    if sha256 is not None and hashlib.sha256(data).hexdigest() != sha256:
        raise RecordingError(f"{what}: its SHA-256 is not that of the benchmark's file")
