"""The data elements of a MATLAB file of version 5 to 7, looked at before they are loaded.

The reader takes an element's type as an index without looking: a damaged byte there ends the
interpreter, not only the reading (MAT-File Format, MathWorks, "Level 5 MAT-File Format").
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

from twin.errors import RecordingError

HEADER = 128
MATRIX, COMPRESSED = 14, 15
DATA_TYPES = {*range(1, 8), 9, 12, 13, MATRIX, COMPRESSED, 16, 17, 18}
"""Codes that the format defines: 8, 10 and 11 are reserved."""

PLAIN_CLASSES = {4, *range(6, 16)}
"""Classes whose elements hold no others: text and numbers."""


def check_elements(path: Path) -> None:
    """Refuse text and numbers stored under a data type that the format does not have.

    Raises:
        RecordingError: there is such an element.
        struct.error, zlib.error: the file ends within an element, or cannot be inflated.
    """
    data = path.read_bytes()
    if len(data) < HEADER or data[126:128] not in (b"IM", b"MI"):
        return  # version 4, which is read without elements, or no such file at all
    order = "<" if data[126:128] == b"IM" else ">"
    for kind, body in _elements(data[HEADER:], order, padded=False):
        if kind == COMPRESSED:
            inflated = zlib.decompressobj().decompress(body)
            kind, body = next(_elements(inflated, order), (COMPRESSED, b""))
        if kind != MATRIX:
            continue
        parts = list(_elements(body, order))
        if not parts or not parts[0][1] or _class(parts[0][1], order) not in PLAIN_CLASSES:
            continue
        for code, _ in parts:
            if code not in DATA_TYPES:
                raise RecordingError(f"{path}: damaged, or no MAT file (data type {code})")


def _class(flags: bytes, order: str) -> int:
    return int(struct.unpack_from(f"{order}I", flags)[0]) & 0xFF


def _elements(data: bytes, order: str, padded: bool = True) -> Iterator[tuple[int, bytes]]:
    """Yield data type and content of one element after the other."""
    position = 0
    while position + 8 <= len(data):
        kind, count = struct.unpack_from(f"{order}II", data, position)
        if kind >> 16:  # four bytes or less stand within the tag
            yield kind & 0xFFFF, data[position + 4 : position + 4 + min(kind >> 16, 4)]
            position += 8
            continue
        yield kind, data[position + 8 : position + 8 + count]
        position += 8 + count + (-count % 8 if padded else 0)
