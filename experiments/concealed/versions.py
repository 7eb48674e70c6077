"""What a campaign was made with."""

from __future__ import annotations

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = {
    "twin": "frame-twin", "mujoco": "mujoco", "numpy": "numpy", "scipy": "scipy",
    "numba": "numba",
}  # fmt: skip


def versions() -> dict[str, str]:
    """Return the versions of all that decides a result, the commit where git knows one."""
    found = {"python": platform.python_version(), "machine": platform.machine()}
    for name, package in PACKAGES.items():
        try:
            found[name] = version(package)
        except PackageNotFoundError:
            found[name] = "not installed"  # run from a checkout: then the commit says it
    commit = _commit()
    return {**found, "commit": commit} if commit else found


def _commit() -> str:
    """Return what git says of the checkout that this file is in; nothing in an installed wheel."""
    here = Path(__file__).resolve().parents[2]
    if not (here / ".git").exists():
        return ""
    try:
        done = subprocess.run(
            ["git", "describe", "--always", "--dirty"],
            cwd=here, capture_output=True, text=True, check=True, timeout=20,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip()
