"""Public benchmark recordings: got, checked against their SHA-256, written as the house's CSV."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from twin.errors import RecordingError
from twin.fetching import bouc_wen, f16, lanl_bumper, silverbox
from twin.fetching.archive import members_in
from twin.fetching.download import located
from twin.fetching.sets import SETS, BenchmarkSet, benchmark_set
from twin.files import folder
from twin.formats import write_recording
from twin.recording import Recording

__all__ = ["SETS", "BenchmarkSet", "Fetched", "benchmark_set", "fetch"]

_CONVERTERS: Mapping[str, Callable[[Mapping[str, bytes]], list[Recording]]] = {
    "silverbox": silverbox.recordings,
    "f16": f16.recordings,
    "lanl_bumper": lanl_bumper.recordings,
    "bouc_wen": bouc_wen.recordings,
}


@dataclass(frozen=True)
class Fetched:
    """What was written.

    Attributes:
        files: recordings, in the order of the set.
        notes: what a reader should know: how it was checked, what was left out.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def fetch(name: str, out: Path, source: str | None = None) -> Fetched:
    """Get a set, check it and write its recordings.

    Args:
        name: of the set.
        out: folder to write in.
        source: a folder with the archive or its files, or a mirror's address; the set's own
            address if None.

    Raises:
        RecordingError: an unknown set, no network, a wrong checksum, an archive without the files.
    """
    wanted = benchmark_set(name)
    place, notes = located(wanted, source)
    members, more = members_in(wanted, place)
    found = _CONVERTERS[name](members)
    if not found:
        raise RecordingError(f"{place}: holds no recording of {name}")
    folder(out)
    written: list[Path] = []
    try:
        for recording in found:
            written.append(write_recording(recording, out / recording.source))
    except BaseException:
        for path in written:
            path.unlink(missing_ok=True)
        raise
    return Fetched(tuple(written), (*notes, *more, *found[0].notes))
