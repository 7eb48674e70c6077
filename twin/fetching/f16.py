"""The F-16's ground vibration test: full-band multisines, one CSV a level."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from twin.formats import read_recording
from twin.recording import Recording

RATE_HZ = 400.0
CHANNELS = {"Force": "force_floor1 [N]"} | {
    f"Acceleration{i}": f"acc_floor{i} [m/s^2]" for i in (1, 2, 3)
}
"""Acceleration 1 is at the shaker, 2 and 3 on the two sides of the wing's payload interface."""


def recordings(members: Mapping[str, bytes]) -> list[Recording]:
    """Return one recording a level; a floor stands for a sensor's place."""
    out = []
    with tempfile.TemporaryDirectory() as name:
        for member, data in sorted(members.items()):
            path = Path(name) / member
            path.write_bytes(data)
            level = member.split("Level")[1][0]
            read = read_recording(path, CHANNELS, RATE_HZ)
            out.append(replace(read, source=f"f16_level{level}.csv", notes=()))
    return out
