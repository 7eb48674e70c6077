"""What a file really is, from its first bytes."""

from __future__ import annotations

from pathlib import Path
from zipfile import BadZipFile, ZipFile

from twin.errors import RecordingError

_MAGIC = (
    (b"\x89PNG\r\n\x1a\n", "a PNG image", ()),
    (b"\xff\xd8\xff", "a JPEG image", ()),
    (b"%PDF", "a PDF document", ()),
    (b"\x1f\x8b", "a gzip archive", (".gz",)),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file", (".h5", ".hdf5")),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file", (".mat",)),
    (b"MATLAB 7.3 MAT-file", "a MATLAB 7.3 file", (".mat", ".h5", ".hdf5")),
    (b"TDSm", "a TDMS file", (".tdms",)),
    (b"\x89MCAP0\r\n", "an MCAP file", (".mcap",)),
    (b"\x93NUMPY", "a NumPy array", (".npy",)),
    (b"    -1", "a universal file", (".uff", ".unv", ".58")),
    (b"RRF2", "a Rerun recording", ()),
)
"""First bytes, what they say, and the suffixes that belong to them."""

BINARY = (".xlsx", ".mat", ".tdms", ".mcap", ".h5", ".hdf5", ".npz", ".npy")
"""Suffixes of files that never begin with a line of text."""


def check_contents(path: Path, supported: str) -> None:
    """Refuse what cannot be read, or what is visibly of another format than its suffix says.

    Args:
        path: the file.
        supported: the suffixes that can be read, for the message.

    Raises:
        RecordingError: missing, a folder, not readable, empty, or of another format.
    """
    try:
        if path.is_dir():
            raise RecordingError(f"{path}: this is a folder, not a recording")
        if path.exists() and not path.is_file():
            raise RecordingError(f"{path}: this is not a regular file")
        with path.open("rb") as file:
            head = file.read(64)
    except FileNotFoundError:
        raise RecordingError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RecordingError(f"{path}: cannot be read ({reason})") from None
    if not head:
        raise RecordingError(f"{path}: the file is empty")
    suffix = path.suffix.lower()
    if head.startswith(b"\xd0\xcf\x11\xe0"):
        raise RecordingError(
            f"{path}: this is an old Office document; save the sheet as .xlsx or .csv"
        )
    if head.startswith(b"PK\x03\x04"):
        _check_zip(path, suffix, supported)
        return
    known = any(head.startswith(magic) for magic, _, _ in _MAGIC)
    for magic, what, suffixes in _MAGIC:
        if head.startswith(magic) and suffix not in suffixes:
            if suffixes:
                raise RecordingError(
                    f"{path}: this is {what}; rename it to {path.stem}{suffixes[0]}"
                )
            raise RecordingError(f"{path}: this is {what}, not a recording ({supported})")
    if not known and suffix in BINARY and _is_text(head):
        raise RecordingError(f"{path}: this is text; rename it to {path.stem}.csv")


def _is_text(head: bytes) -> bool:
    """Return whether it begins as a table does: printable, with something that separates."""
    return all(b in b"\t\n\r" or 32 <= b < 127 for b in head) and any(b in b",;\t" for b in head)


def _check_zip(path: Path, suffix: str, supported: str) -> None:
    """Refuse a zip archive that is not what its suffix says: NumPy's, or Excel's."""
    try:
        with ZipFile(path) as archive:
            names = archive.namelist()
    except (BadZipFile, OSError, ValueError, NotImplementedError):
        if suffix in (".npz", ".xlsx"):
            return  # damaged: its reader says so
        names = []
    if any(name.startswith("xl/") for name in names):
        if suffix != ".xlsx":
            raise RecordingError(f"{path}: this is an Excel sheet; rename it to {path.stem}.xlsx")
    elif names and all(name.endswith(".npy") for name in names):
        if suffix != ".npz":
            raise RecordingError(f"{path}: these are NumPy arrays; rename it to {path.stem}.npz")
    elif suffix not in (".npz", ".xlsx") or names:
        raise RecordingError(
            f"{path}: this is a zip archive, not a recording ({supported}); unpack it first"
        )
