"""Where a discrepancy stands, and how large it is expected to be.

No law has quite the form that it is given, and an analyser's filter smears those that jump: at each
law's port acts a latent force beside it, and to each channel that sees a law jump a latent reading
is added (Kennedy and O'Hagan 2001, section 4.1). Laws that act at times err only then, where they
are alone at their port: by a share of their force (``twin.estimation.acting``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from twin.diagnosis.plant_states import stationary
from twin.diagnosis.scales import TINY
from twin.estimation.model import Unknown
from twin.mechanisms.mechanism import Law
from twin.mechanisms.unmeasured_force import oscillator_shaping
from twin.model.linear import LinearModel
from twin.model.port import parallel

Array = NDArray[np.float64]

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


@dataclass(frozen=True)
class Discrepancy:
    """A latent force at a port, or a latent reading of an output, as a band of noise.

    What laws leave is as smooth as the structure makes it: a force of an oscillator, from that of
    one corner frequency (bandwidth far above the frequency) to one at a resonance. What a filter's
    smear leaves of a reading is rough: it has one corner and no bandwidth.

    Attributes:
        place: port or output.
        rms: N, N m, or the output's unit.
        frequency: about which it lies, or its corner [Hz].
        bandwidth: of a latent force [Hz].
    """

    place: str
    rms: float
    frequency: float
    bandwidth: float | None = None

    def shaping(self) -> tuple[Array, Array, Array]:
        """Return the filter that makes it of white noise: block (k, k), drive and shape (k,)."""
        if self.bandwidth is not None:
            return oscillator_shaping(self.frequency, self.bandwidth, self.rms)
        rate = 2 * np.pi * self.frequency
        return np.array([[-rate]]), np.array([self.rms * np.sqrt(2 * rate)]), np.ones(1)

    def varying(self, longest_s: float) -> float:
        """Return the RMS by which it varies within a time [s].

        The mean over T has the variance 2/T^2 int_0^T (T - t) R(t) dt of the autocovariance R
        (Papoulis 1991, ch. 13).
        """
        block, drive, shape = self.shaping()
        k = len(block)
        start = stationary(block, drive)
        # the top right of the exponential is int_0^1 (1 - x) exp(A T x) dx (Van Loan 1978)
        upper = np.eye(3 * k, k=k)
        upper[:k, :k] = block * longest_s
        kept = shape @ expm(upper)[:k, 2 * k :] @ start @ shape
        return float(np.sqrt(max(self.rms**2 - 2 * kept, 0.0)))


def unknowns_at(place: str, size: float, quick_hz: float, latent_force: bool) -> list[Unknown]:
    """Return level, frequency and, of a latent force, bandwidth of a discrepancy.

    Args:
        place: port or output.
        size: of forces at the port, or of the output's reading.
        quick_hz: about which its frequency lies; half of its bandwidth, too, for then it has one
            corner there, beyond which it is smooth.
        latent_force: whether it is one.
    """
    level = float(np.log(DISCREPANCY_SHARE * max(size, TINY)))
    quick, name = float(np.log(quick_hz)), f"discrepancy {place}"
    out = [
        Unknown(name, level, DISCREPANCY_DEVIATION, True, level=True),
        Unknown(f"{name} frequency", quick, 1.0, True),
    ]
    if latent_force:
        width = quick + float(np.log(2.0))
        out.append(Unknown(f"{name} bandwidth", width, DISCREPANCY_DEVIATION, True))
    return out
