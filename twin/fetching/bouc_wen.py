"""The Bouc-Wen benchmark's two tests: a steady multisine and a sine sweep from rest."""

from __future__ import annotations

from collections.abc import Mapping

from twin.errors import RecordingError
from twin.fetching.matlab import variable
from twin.recording import Recording

RATE_HZ = 750.0
KINDS = {"multisine": "multisine", "sinesweep": "sweep"}


def recordings(members: Mapping[str, bytes]) -> list[Recording]:
    """Return the tests: force [N] and displacement [m]."""
    out = []
    for kind, name in KINDS.items():
        u, y = (
            variable(members, f"{letter}val_{kind}.mat", f"{letter}val_{kind}").ravel()
            for letter in "uy"
        )
        if len(u) != len(y):
            raise RecordingError(f"{kind}: {len(u)} samples of force, {len(y)} of displacement")
        columns = {"force_floor1": u, "disp_floor1": y}
        out.append(Recording.build(RATE_HZ, columns, f"bouc_wen_test_{name}.csv"))
    return out
