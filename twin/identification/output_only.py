"""Modes from responses alone, to a force that nobody measured: covariance-driven subspace.

Under white excitation the covariances of the outputs, R_k = E y(t+k) y(t)^T, are the impulse
responses of a system with the structure's poles and shapes, so that the realization of eqs.
(32)-(38) applies to them. Modal masses, and with them the scale of the shapes, remain unknown.
A mode is listed where the jackknife over parts of the records proves its damping. Frequencies and
dampings, with their deviations, are then those of maximum likelihood where the lines near the
resonance allow it, and those of the subspace and the jackknife elsewhere.

Source: Peeters and De Roeck 1999 (covariance-driven stochastic subspace identification); Efron
1982, The Jackknife, chapter 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft, stats

from twin.errors import IdentificationError, RecordingError
from twin.identification.as_json import modes_as_json
from twin.identification.doubts import doubts_of_data
from twin.identification.era import HankelFactors, era
from twin.identification.listing import FALSE_MODES
from twin.identification.output_refined import numerator_power, refined
from twin.identification.pole_diagram import Pick, PoleDiagram, of_outputs
from twin.identification.segments import Progress
from twin.identification.spectra import USABLE_FRACTION
from twin.identification.stabilisation import (
    StablePole,
    continuous_poles,
    persistent_columns,
    stabilisation,
)
from twin.modal import ModalModel, mac
from twin.recording import Recording
from twin.signals.resampling import resample

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

BLOCKS = 20
"""Parts of the records that the jackknife leaves out in turn: standard deviations are then known
to a sixth of their value, 1 / sqrt(2 * 19)."""

LAGS = 400
"""Covariances behind the realization at most; half of them are block rows."""

LAGS_IN_BLOCK = 4
"""A part of the records spans its longest lag at least so often: parts are then nearly
independent."""

HIGHEST_ORDER = 80
REFERENCES = 8
"""Outputs that the others are correlated with, at most: those of largest power."""

PRESENT = 0.9
"""Share of the jackknife's replicates that have a mode; without it, it hangs on few parts."""

SAME_SHAPE = 0.8
"""MAC above which a replicate's mode is the same mode (Allemang 2003: below it, not alike)."""


@dataclass(frozen=True)
class OutputOnly:
    """Modes identified without a measured input.

    Attributes:
        modal: natural frequencies, damping ratios and shapes, their scale arbitrary.
        diagram: the stabilisation diagram over the spectra of the outputs.
        recordings: what it was identified from.
        sampling_hz: of the covariances [Hz].
        notes: what a reader has to know, warnings first.
    """

    modal: ModalModel
    diagram: PoleDiagram
    recordings: tuple[Recording, ...]
    sampling_hz: float
    notes: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the dictionary of the identification's contract; null for what inputs give."""
        order = 2 * len(self.modal.natural_freq)
        return modes_as_json(self.modal, (), self.sampling_hz, order, self.notes)


def identify_output_only(
    recordings: Sequence[Recording],
    outputs: Sequence[str] | None = None,
    band_hz: tuple[float, float] | None = None,
    progress: Progress | None = None,
    pick: Pick | None = None,
) -> OutputOnly:
    """Identify modes from responses to excitation that was not measured.

    Args:
        recordings: at the same sampling rate, with common outputs.
        outputs: channels that respond; all common ones that move by default.
        band_hz: frequencies to list modes in; all usable ones by default.
        progress: told what is done, which step it is and of how many.
        pick: chooses poles in the stabilisation diagram; modes are looked for nowhere else.

    Raises:
        TwinError: the recordings do not allow it; the message says why.
    """
    first = recordings[0]
    names = _names(recordings, outputs)
    rate = first.sampling_hz
    top = USABLE_FRACTION * rate if band_hz is None else min(band_hz[1], USABLE_FRACTION * rate)
    low = 0.0 if band_hz is None else band_hz[0]
    factor = max(int(USABLE_FRACTION * rate / top), 1)
    y = [r.matrix(names) - r.matrix(names).mean(axis=0) for r in recordings]
    if factor > 1:
        y = [resample(x, rate, rate / factor) for x in y]
        rate /= factor
    blocks, counts = covariances(y, *_sizes(y, first.source))
    whole = _hankel(blocks.sum(axis=0) / counts.sum())
    orders = range(2, HIGHEST_ORDER + 1, 2)
    references = blocks.shape[3]
    diagram = tuple(stabilisation(whole, 1 / rate, references, orders))
    columns = [c for c in persistent_columns(diagram) if low <= c[0].frequency_hz <= top]
    shown = of_outputs(diagram, y, rate)
    if pick is not None:
        poles = pick(shown)
        columns = [[p for p in diagram if p.pole == pole] for pole in poles]
    modal = _with_deviations(columns, blocks, counts, rate, names, progress)
    modal, likeliest = refined(modal, y, rate, numerator_power(recordings, names))
    if not len(modal.natural_freq):
        raise IdentificationError(
            f"{first.source}: no pole stays in the stabilisation diagram of the outputs alone: "
            "choose a --band that holds resonances, or record for longer"
        )
    notes = (
        *doubts_of_data(recordings, (), names),
        "from responses alone: the shapes have no scale, there are no masses and stiffnesses",
        "white excitation is assumed: a narrow peak in the spectrum of what excites the structure "
        "looks like a mode",
        *_elsewhere(modal, likeliest),
    )
    return OutputOnly(modal, shown, tuple(recordings), rate, notes)


def _elsewhere(modal: ModalModel, likeliest: NDArray[np.bool_]) -> tuple[str, ...]:
    """Say which modes have no maximum-likelihood values."""
    if likeliest.all():
        return ()
    named = ", ".join(f"{f:.4g}" for f in modal.natural_freq[~likeliest])
    return (
        f"at {named} Hz the lines of the spectra support no maximum-likelihood fit: the values are "
        "those of the covariance-driven subspace",
    )


def _names(recordings: Sequence[Recording], outputs: Sequence[str] | None) -> tuple[str, ...]:
    first = recordings[0]
    for other in recordings[1:]:
        if not np.isclose(other.sampling_hz, first.sampling_hz, rtol=1e-9):
            raise RecordingError(
                f"{other.source} is sampled at {other.sampling_hz:g} Hz and {first.source} at "
                f"{first.sampling_hz:g} Hz; convert one with --resample"
            )
    shared = [n for n in first.outputs if all(n in r.outputs for r in recordings)]
    names = tuple(outputs or shared)
    still = [n for n in names if not any(np.ptp(r.column(n)) for r in recordings)]
    moving = tuple(n for n in names if n not in still)
    if not moving:
        raise IdentificationError(f"{first.source}: no output moves")
    return moving


def _sizes(y: Sequence[Array], source: str) -> tuple[int, int]:
    """Return the number of lags and the length of a block."""
    samples = sum(len(x) for x in y)
    length = samples // BLOCKS
    lags = min(LAGS, length // LAGS_IN_BLOCK, min(len(x) for x in y) // 2)
    if lags < 8:
        raise IdentificationError(f"{source}: {samples} samples are too few without an input")
    return lags, length


def covariances(y: Sequence[Array], lags: int, length: int) -> tuple[Array, Array]:
    """Return sums of y(t+k) y_ref(t)^T over blocks of the records, and how many terms they have.

    Args:
        y: outputs of every record, (samples, outputs).
        lags: highest lag k.
        length: samples of a block; what is left at the end of a record joins its last block.

    Returns:
        (blocks, lags + 1, outputs, references) and (blocks,).
    """
    power = np.sum([np.sum(x**2, axis=0) for x in y], axis=0)
    references = np.sort(np.argsort(power)[::-1][:REFERENCES])
    sums, counts = [], []
    for x in y:
        usable = len(x) - lags
        edges = [*range(0, max(usable - length // 2, 1), length), usable]
        for start, stop in pairwise(edges):
            n = fft.next_fast_len(stop - start + lags, real=True)
            ahead = fft.rfft(x[start : stop + lags], n, axis=0)
            here = fft.rfft(x[start:stop, references], n, axis=0)
            product = fft.irfft(ahead[:, :, None] * here[:, None].conj(), n, axis=0)
            sums.append(product[: lags + 1])
            counts.append(stop - start)
    return np.array(sums), np.array(counts, float)


def _hankel(covariance: Array) -> HankelFactors:
    return era(covariance, keep=HIGHEST_ORDER + 20)


def _with_deviations(
    columns: Sequence[Sequence[StablePole]],
    blocks: Array,
    counts: Array,
    rate: float,
    names: tuple[str, ...],
    progress: Progress | None,
) -> ModalModel:
    """Return the modes that the parts of the records agree on, with the jackknife's deviations.

    Of every column the pole is taken whose damping the parts agree on best: low orders miss what
    stands beside the mode, high ones divide it among several poles.
    """
    total, count, parts = blocks.sum(axis=0), counts.sum(), len(blocks)
    poles = [p for column in columns for p in column]
    column_of = np.repeat(np.arange(len(columns)), [len(column) for column in columns])
    seen = np.full((parts, len(poles), 2), np.nan)
    for b in range(parts):
        if progress:
            progress("jackknife", b + 1, parts)
        hankel = _hankel((total - blocks[b]) / (count - counts[b]))
        for order in {p.order for p in poles}:
            found, shapes = continuous_poles(hankel.realize(order, 1 / rate, blocks.shape[3]))
            for i, pole in enumerate(poles):
                if pole.order == order and len(found):
                    seen[b, i] = _same(pole, found, shapes)
    here = np.array([(p.frequency_hz, p.damping_ratio) for p in poles]).reshape(-1, 2)
    present = np.isfinite(seen[:, :, 0])
    std = np.full(here.shape, np.inf)
    for k in np.flatnonzero(present.mean(axis=0) >= PRESENT):
        replicates = seen[present[:, k], k]
        n = len(replicates)
        std[k] = np.sqrt((n - 1) / n * np.sum((replicates - replicates.mean(axis=0)) ** 2, axis=0))
    limit = stats.t.isf(FALSE_MODES / max(len(columns), 1), parts - 1)
    best = [
        int(members[np.argmin(std[members, 1])])
        for members in (np.flatnonzero(column_of == c) for c in range(len(columns)))
    ]
    proven = [i for i in best if here[i, 1] > limit * std[i, 1]]
    kept = sorted(proven, key=lambda i: float(here[i, 0]))
    shape = np.array([poles[i].shape for i in kept], complex).reshape(len(kept), len(names)).T
    return ModalModel(here[kept, 0], here[kept, 1], shape, names, std[kept, 0], std[kept, 1])


def _same(pole: StablePole, poles: ComplexArray, shapes: ComplexArray) -> tuple[float, float]:
    """Return frequency and damping of a replicate's mode of the same shape, or NaN."""
    alike = mac(pole.shape[:, None], shapes)[0] > SAME_SHAPE
    if not alike.any():
        return np.nan, np.nan
    near = poles[alike][np.argmin(np.abs(poles[alike] - pole.pole))]
    if abs(near - pole.pole) > -2 * pole.pole.real:
        return np.nan, np.nan
    return abs(near) / (2 * np.pi), -near.real / abs(near)
