"""What a file really is, from its first bytes."""

from __future__ import annotations

from pathlib import Path

from twin.errors import RecordingError

_MAGIC = (
    (b"\x89PNG\r\n\x1a\n", "a PNG image", ()),
    (b"\xff\xd8\xff", "a JPEG image", ()),
    (b"%PDF", "a PDF document", ()),
    (b"\x1f\x8b", "a gzip archive", ()),
    (b"\xd0\xcf\x11\xe0", "an old Office document", ()),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file", (".h5", ".hdf5")),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file", (".mat",)),
    (b"MATLAB 7.3 MAT-file", "a MATLAB 7.3 file", (".mat", ".h5", ".hdf5")),
    (b"TDSm", "a TDMS file", (".tdms",)),
    (b"\x93NUMPY", "a NumPy array", (".npy",)),
    (b"PK\x03\x04", "a zip archive or an Excel sheet", (".npz",)),
    (b"    -1", "a universal file", (".uff", ".unv", ".58")),
    (b"RRF2", "a Rerun recording", ()),
)
"""First bytes, what they say, and the suffixes that belong to them."""


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
    for magic, what, suffixes in _MAGIC:
        if head.startswith(magic) and suffix not in suffixes:
            if suffixes:
                raise RecordingError(
                    f"{path}: this is {what}; rename it to {path.stem}{suffixes[0]}"
                )
            raise RecordingError(f"{path}: this is {what}, not a recording ({supported})")
