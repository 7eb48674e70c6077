"""Where a discrepancy stands, and how large it is expected to be.

No law has quite the form that it is given, and an analyser's filter smears those that jump: at each
law's port acts a latent force beside it, and to each channel that sees a law jump a latent reading
is added (Kennedy and O'Hagan 2001, section 4.1). Laws that act at times err only then, where they
are alone at their port: by a share of their force (``twin.estimation.acting``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twin.diagnosis.plants import TINY
from twin.estimation.model import Unknown
from twin.mechanisms.mechanism import Law
from twin.model.linear import LinearModel
from twin.model.port import parallel

SEEN = 0.01
"""Share of the largest acceleration that an output may see of any motion, from which it sees that
of a law's force."""

DISCREPANCY_SHARE, DISCREPANCY_DEVIATION = 0.01, 2.0
"""Prior of a law's discrepancy: a hundredth of the forces at its port, give or take a factor of
seven; of a channel's that sees it jump, the same of its reading."""


def port_of(place: str, laws: Sequence[Law], model: LinearModel) -> str:
    """Return the first port of a law that moves in proportion to another law's.

    Latent forces at several such ports would be one: none could be told from the others.
    """
    row = model.port
    places = (law.place for law in laws)
    return next((p for p in places if p == place or parallel(row(p), row(place))), place)


def smeared_outputs(laws: Sequence[Law], model: LinearModel) -> tuple[str, ...]:
    """Return the outputs that see the force of a law that jumps."""
    seen = np.zeros(len(model.outputs))
    for law in (law for law in laws if law.jumps):
        moved = np.linalg.solve(model.M, model.port(law.place))
        through = np.abs(model.Ca @ moved) / np.linalg.norm(moved)
        seen = np.maximum(seen, through / np.maximum(np.max(np.abs(model.Ca), axis=1), 1e-300))
    return tuple(n for n, s in zip(model.outputs, seen, strict=True) if s > SEEN)


def error_of(port: str) -> Unknown:
    """Return the share by which laws that act at times are off at a port."""
    level = float(np.log(DISCREPANCY_SHARE))
    return Unknown(f"discrepancy {port} share", level, DISCREPANCY_DEVIATION, True, "error",
                   level=True)  # fmt: skip


def unknowns_at(place: str, size: float, quick_hz: float) -> tuple[Unknown, Unknown]:
    """Return level and corner frequency of a discrepancy.

    Args:
        place: port or output.
        size: of forces at the port, or of the output's reading.
        quick_hz: about which its corner frequency lies.
    """
    level = float(np.log(DISCREPANCY_SHARE * max(size, TINY)))
    return (
        Unknown(f"discrepancy {place}", level, DISCREPANCY_DEVIATION, True, level=True),
        Unknown(f"discrepancy {place} frequency", float(np.log(quick_hz)), 1.0, True),
    )
