"""Measured frequency responses as files: universal files, text and MATLAB."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from twin.formats import responses_mat, responses_text, responses_uff
from twin.formats.contents import check_contents
from twin.formats.response_pairs import gathered
from twin.signals.responses import ResponseSet

READERS = {
    **dict.fromkeys((".uff", ".unv", ".58"), responses_uff),
    **dict.fromkeys((".csv", ".tsv", ".txt"), responses_text),
    ".mat": responses_mat,
}
"""Suffix of a file and the module that reads it."""


def holds_responses(path: str | Path) -> bool:
    """Whether a file holds frequency responses rather than time histories."""
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    return reader is not None and path.is_file() and reader.holds(path)


def read_responses(paths: str | Path | Sequence[str | Path]) -> ResponseSet:
    """Read frequency responses from one file, or from several that hold some pairs each.

    Universal files name responding and driven points "NODE.DIRECTION". A text file's first column
    is ``frequency [Hz]``; the others are ``RESPONSE/REFERENCE real`` and ``... imag``, or
    ``... magnitude`` and ``... phase [deg]`` (or ``[rad]``), and, where it was measured,
    ``... coherence``. A MATLAB file holds ``f`` [Hz], ``H`` (lines, outputs, inputs), and
    optionally ``coherence`` of the same shape, or as (lines, outputs), and the names ``outputs``
    and ``inputs``.

    Raises:
        RecordingError: no frequency responses, different lines, or a pair that is missing.
    """
    several = [paths] if isinstance(paths, str | Path) else paths
    read = []
    for path in map(Path, several):
        check_contents(path, ", ".join(READERS))
        reader = READERS.get(path.suffix.lower(), responses_text)
        read.append((path, reader.read(path)))
    return gathered(read)
