"""Modes that a segment lacks: what its residual asks for, and what lies beyond the band's ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.projected import Projected
from twin.identification.segment import LEAST_LINES, Segment, level_weights
from twin.identification.separable import project, solve, start_drive
from twin.identification.separable_terms import Drive, Terms
from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

ADDITIONS = 3
"""Modes that may be added to a segment."""

TOLERANCE = 1e-5
MOST_STEPS = 8
"""When the Gauss-Newton iteration of a segment ends: at a relative fall of the cost far below one
unit of a likelihood's logarithm in a thousand lines, or after so many steps."""

BROAD = 0.2
"""Damping ratio above which a mode is a background, not a resonance."""

BEYOND = 1.28
"""Factor beyond the band's ends within which a mode may lie whose flank is felt inside: an analyser
leaves 1/2.56 of the sampling rate clean, and half of it is the highest frequency there is."""

FLANK = 0.01
"""Damping ratio that is first tried for such a mode; a flank hardly depends on it."""


def with_what_is_missing(drive: Drive, segment: Segment, own: Terms, floor: Array) -> Drive:
    """Add modes as long as they pay for their unknowns: beyond the band, then in the residual.

    Args:
        drive: modes of the segment and its neighbours.
        segment: the segment, which at the band's ends reaches beyond its lines.
        own: its lines.
        floor: smallest variance of the noise to believe, (outputs,).
    """
    done = project(drive, own, level_weights(own.Y, floor, own.noise), derivative=False)
    for pole in _beyond(segment, own):
        weight = level_weights(done.error, floor, own.noise)
        found = _tried(drive, done, pole, segment, own, weight, floor)
        if found is not None and not _among_lines(found[0].omega[-1], own):
            drive, done = found
    for _ in range(ADDITIONS):
        weight = level_weights(done.error, floor, own.noise)
        done = project(drive, own, weight, derivative=False)
        weight = level_weights(done.error, floor, own.noise)
        loudest = _loudest(done.error * weight, segment, own)
        if loudest is None:
            break
        found = _tried(drive, done, loudest, segment, own, weight, floor)
        if found is None:
            break
        drive, done = found
    return drive


def without_what_another_covers(drive: Drive, segment: Segment, own: Terms, floor: Array) -> Drive:
    """Drop one of two modes within one bandwidth where the other alone, refined, does as well.

    Modes that came in while their neighbours were still away from their place stand beside them.

    Args:
        drive: modes of the segment and its neighbours.
        segment: the segment.
        own: its lines.
        floor: smallest variance of the noise to believe, (outputs,).
    """
    while True:
        fewer = _with_one_fewer(drive, segment, own, floor)
        if fewer is None:
            return drive
        drive = fewer


def _with_one_fewer(drive: Drive, segment: Segment, own: Terms, floor: Array) -> Drive | None:
    width = drive.zeta * drive.omega
    apart = np.abs(drive.omega[:, None] - drive.omega) / (width[:, None] + width)
    apart[np.diag_indices_from(apart)] = np.inf
    nearest = apart.min(axis=1, initial=np.inf)
    close = np.flatnonzero((nearest < 1) & segment.holds(drive.omega))
    if not len(close):
        return None
    weight = level_weights(own.Y, floor, own.noise)
    for _ in range(2):
        done = project(drive, own, weight, derivative=False)
        weight = level_weights(done.error, floor, own.noise)
    for mode in close[np.argsort(nearest[close])]:
        tried = drive.without(np.array([mode]))
        held = held_modes(tried, segment)
        tried, better = solve(tried, own, weight, TOLERANCE, MOST_STEPS, held)
        near = _around(drive, own, int(mode))
        if near.any() and _gain(better, done, near, own, floor) < _price(own):
            return tried
    return None


def _gain(worse: Projected, better: Projected, near: NDArray[np.bool_], own: Terms,
          floor: Array) -> float:  # fmt: skip
    """Return twice the rise of the logarithm of the likelihood of some lines."""
    before, after = (_level(d.error / own.noise, near, floor) for d in (worse, better))
    return 2 * float(near.sum()) * float(np.sum(np.log(before / after)))


def _price(own: Terms) -> float:
    """Return what the Bayesian information criterion charges for a mode."""
    return float(np.log(2 * own.Y.size)) * unknowns_of_mode(own)


def _among_lines(at: float, own: Terms) -> bool:
    omega = np.concatenate([s.omega for s in own.spectra])
    return bool(omega.min() <= at <= omega.max())


def _beyond(segment: Segment, own: Terms) -> list[complex]:
    """Return a pole half way to the ends of the segment that lie beyond its lines."""
    omega = np.concatenate([s.omega for s in own.spectra])
    found = []
    for end, last in ((segment.low, omega.min()), (segment.high, omega.max())):
        if max(end / last, last / end) > (1 + BEYOND) / 2:
            at = float(np.sqrt(end * last))
            found.append(complex(-FLANK * at, at))
    return found


def _tried(
    drive: Drive,
    done: Projected,
    pole: complex,
    segment: Segment,
    own: Terms,
    weight: Array,
    floor: Array,
) -> tuple[Drive, Projected] | None:
    """Return the drive with one more mode, or None where it does not pay for its unknowns."""
    asked = replace(own, spectra=_with_outputs(own, done.error), powers=())
    one = start_drive(np.array([pole]), asked, np.ones((len(weight), 1)))
    tried = Drive(
        np.append(drive.omega, one.omega),
        np.append(drive.zeta, one.zeta),
        np.vstack([drive.v, one.v]),
        np.append(drive.anchor, one.anchor),
    )
    try:
        tried, better = solve(tried, own, weight, TOLERANCE, MOST_STEPS, held_modes(tried, segment))
    except IdentificationError:
        return None
    near = _around(tried, own, -1)
    if not near.any():
        return None  # it has left the segment
    sound = segment.holds(tried.omega[-1:])[0] and tried.zeta[-1] < BROAD
    if _gain(done, better, near, own, floor) < _price(own) or not sound:
        return None
    return tried, better


def held_modes(drive: Drive, segment: Segment) -> NDArray[np.intp]:
    """Modes of the neighbours: without lines of their own their poles would go astray."""
    return np.flatnonzero(~segment.holds(drive.omega))


def _around(drive: Drive, own: Terms, mode: int) -> NDArray[np.bool_]:
    """Lines around a mode: its gain must stand against the noise that is there.

    What nobody measured but drives the structure too, wind or traffic, is loud at resonances.
    """
    omega = np.concatenate([s.omega for s in own.spectra])
    resolution = float(np.median(np.diff(own.spectra[0].omega)))
    centre = drive.omega[mode]
    off = np.abs(drive.omega - centre)
    width = float(np.max((drive.zeta * drive.omega)[np.argsort(off)[:2]]))
    reach = max(LEAST_LINES / 2 * resolution, 2 * width)
    if not _among_lines(float(centre), own):
        # A flank is felt as far inside the band as its pole lies outside.
        reach = 2 * float(np.abs(omega - centre).min()) + reach
    return np.asarray(np.abs(omega - centre) <= reach)


def _level(error: ComplexArray, lines: NDArray[np.bool_], floor: Array) -> Array:
    return np.maximum(np.mean(np.abs(error[lines]) ** 2, axis=0), floor)


def _loudest(white: ComplexArray, segment: Segment, own: Terms) -> complex | None:
    """Return a pole at the line where the residual is loudest, or None where that is chance."""
    power = np.sum(np.abs(white) ** 2, axis=1)
    at = int(np.argmax(power))
    omega = np.concatenate([s.omega for s in own.spectra])
    # Of N lines of exponential power the largest exceeds log N + c with probability e^-c.
    if not segment.holds(omega[at : at + 1])[0]:
        return None
    if power[at] < white.shape[1] + np.log(len(power)) + 3 * np.sqrt(white.shape[1]):
        return None
    resolution = float(np.median(np.diff(own.spectra[0].omega)))
    return complex(-2 * resolution, omega[at])


def _with_outputs(own: Terms, Y: ComplexArray) -> tuple[Spectrum, ...]:
    return tuple(
        replace(s, Y=Y[rows], edge=0) for s, rows in zip(own.spectra, own.rows, strict=True)
    )


def unknowns_of_mode(own: Terms) -> int:
    """Real unknowns of one more mode: pole, drive less its scale, and shape."""
    return 2 * (own.Y.shape[1] + own.drives)
