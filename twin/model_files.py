"""The MJCF files that come with the package, found in a checkout and in an installed wheel."""

from __future__ import annotations

from pathlib import Path

from twin.errors import ModelError, available

_PACKAGE = Path(__file__).resolve().parent


def _folder() -> Path:
    installed = _PACKAGE / "_models"
    return installed if installed.is_dir() else _PACKAGE.parent / "models"


def shipped_names() -> tuple[str, ...]:
    """Return the names of the models that come with the package ("two_storey", ...)."""
    return tuple(sorted(path.stem for path in _folder().glob("*.xml")))


def shipped(name: str) -> Path:
    """Return the path of a model that comes with the package.

    Raises:
        ModelError: there is no model of that name; the message lists those there are.
    """
    stem = name.removesuffix(".xml")
    if stem not in shipped_names():
        raise ModelError(f"no model '{name}'; the package has {available(shipped_names())}")
    return _folder() / f"{stem}.xml"
