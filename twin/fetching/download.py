"""An archive brought to this machine once, by pooch, and checked; or found where a user has it."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from twin.errors import RecordingError
from twin.fetching.sets import BenchmarkSet
from twin.files import write_whole

CACHE_VARIABLE = "FRAME_TWIN_CACHE"
"""Environment variable with another folder for the downloads."""
LEARNT = "registry.json"
"""In the cache: SHA-256 of archives whose owner has published none, from the first download."""
SECONDS = 60.0


def located(wanted: BenchmarkSet, source: str | None) -> tuple[Path, tuple[str, ...]]:
    """Return the archive, or a folder that may hold it or its files, and notes.

    Args:
        wanted: the set.
        source: a folder or file, "file://...", an address to download from, or None.

    Raises:
        RecordingError: nothing there, no network, a wrong checksum, or pooch missing.
    """
    if source is None and wanted.url is None:
        raise RecordingError(
            f"{wanted.name}: its owner gives no address for programs; download {wanted.archive} "
            f"from {wanted.page} and say --from FOLDER"
        )
    address = source or str(wanted.url)
    scheme = urlsplit(address).scheme
    if scheme in ("http", "https"):
        if source is not None and not address.endswith((".zip", ".mat")):
            address = f"{address.rstrip('/')}/{wanted.archive}"
        return _downloaded(wanted, address)
    path = Path(unquote(urlsplit(address).path)) if scheme == "file" else Path(address)
    if not path.exists():
        raise RecordingError(f"{wanted.name}: {path} does not exist")
    return path, ()


def _downloaded(wanted: BenchmarkSet, address: str) -> tuple[Path, tuple[str, ...]]:
    try:
        import pooch
    except ImportError:
        raise RecordingError(
            "downloading needs pooch; pip install 'frame-twin[fetch]', or give --from FOLDER"
        ) from None
    pooch.get_logger().setLevel(logging.ERROR)
    key = f"{wanted.name}-{wanted.archive}"
    store = pooch.create(pooch.os_cache("frame-twin"), "", env=CACHE_VARIABLE, urls={key: address})
    learnt = Path(store.path) / LEARNT
    known = wanted.sha256 or _read(learnt).get(key)
    store.registry = {key: known and f"sha256:{known}"}
    if known is None:  # a file that nothing vouches for is not taken for the archive
        (Path(store.path) / key).unlink(missing_ok=True)
    path = _fetched(wanted, address, lambda: store.fetch(key, downloader=_downloader(pooch)))
    if wanted.sha256:
        return path, ("the checksum is the published one",)
    found = pooch.file_hash(str(path))
    if known is None:
        _remember(learnt, key, found)
        return path, (
            f"no checksum is published; SHA-256 {found} is kept in {learnt} for the next time",
        )
    return path, ("the checksum is that of the first download; none is published",)


def _downloader(pooch: Any) -> Any:
    return pooch.HTTPDownloader(timeout=SECONDS, headers={"User-Agent": "frame-twin"})


def _fetched(wanted: BenchmarkSet, address: str, fetch: Callable[[], str]) -> Path:
    """Run pooch; whatever it raises becomes one line."""
    try:
        return Path(fetch())
    except ValueError as error:
        if "hash" not in str(error).lower():
            raise RecordingError(f"{wanted.name}: {address}: {error}") from None
        raise RecordingError(
            f"{wanted.name}: what {address} gave has a wrong SHA-256 and was thrown away; "
            f"get {wanted.archive} from {wanted.page} and say --from FOLDER"
        ) from None
    except OSError as error:  # the errors of requests are OSErrors
        raise RecordingError(
            f"{wanted.name}: cannot download {address} ({type(error).__name__}); without a "
            f"network get {wanted.archive} from {wanted.page} and say --from FOLDER"
        ) from None


def _read(path: Path) -> dict[str, str]:
    try:
        found = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}


def _remember(path: Path, key: str, sha256: str) -> None:
    text = json.dumps(_read(path) | {key: sha256}, indent=1) + "\n"
    write_whole(path, lambda part: part.write_text(text))
