"""The band in segments of a few modes: poles refined and modes weighed one segment at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.separable import project, solve, start_drive
from twin.identification.separable_terms import Drive, Terms
from twin.identification.spectra import Spectrum
from twin.modal import mac

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Progress = Callable[[str, int, int], None]
"""Told what is done, which step it is and of how many."""

MODES = 6
"""Modes in a segment at most; the Gauss-Newton step of a segment grows with their square."""

LEAST_LINES = 24
"""Lines in a segment at least, for its noise level."""

NEIGHBOURS = 2
"""Modes beyond either end that a segment's model has too."""

ADDITIONS = 3
"""Modes that may be added to a segment."""

FIRST_STEPS = 5
"""Gauss-Newton steps of the first sweep, which only has to tell modes from mere poles."""

ROUNDS = 2
"""Times the noise level of a segment is estimated anew."""

TOLERANCE = 1e-5
MOST_STEPS = 8
"""When the Gauss-Newton iteration of a segment ends: at a relative fall of the cost far below one
unit of a likelihood's logarithm in a thousand lines, or after so many steps."""

SAME_SHAPE = 0.99
"""MAC above which two modes within one bandwidth are one."""

BROAD = 0.2
"""Damping ratio above which a mode is a background, not a resonance."""


@dataclass(frozen=True)
class Segment:
    """A part of the band.

    Attributes:
        low: first angular frequency [rad/s].
        high: last angular frequency [rad/s].
    """

    low: float
    high: float

    def holds(self, omega: Array) -> NDArray[np.bool_]:
        """Which frequencies lie inside."""
        return np.asarray((omega >= self.low) & (omega < self.high))

    def part(self, s: Spectrum) -> Spectrum:
        """Return the lines of a record inside the segment."""
        keep = self.holds(s.omega)
        noise = None if s.noise is None else s.noise[keep]
        return replace(s, omega=s.omega[keep], U=s.U[keep], Y=s.Y[keep], noise=noise)


def segments(omega: Array, low: float, high: float, resolution: float) -> list[Segment]:
    """Cut the band in the middle of the widest gaps between modes until few are left in each."""
    found = [Segment(low, np.nextafter(high, np.inf))]
    while True:
        sizes = [int(np.sum(s.holds(omega))) for s in found]
        cut = None
        for index in np.argsort(sizes)[::-1]:
            inside = np.sort(omega[found[index].holds(omega)])
            if len(inside) <= MODES:
                break
            middle = (inside[1:] + inside[:-1]) / 2
            least = LEAST_LINES * resolution
            allowed = (middle - found[index].low > least) & (found[index].high - middle > least)
            gaps = np.where(allowed, np.diff(inside), 0)
            if gaps.max() > 0:
                cut = index, float(middle[np.argmax(gaps)])
                break
        if cut is None:
            return found
        index, at = cut
        old = found[index]
        found[index : index + 1] = [Segment(old.low, at), Segment(at, old.high)]


def level_weights(error: ComplexArray, power: Array, noise: Array) -> Array:
    """Return 1 / standard deviation of noise of known form for every line and output.

    Args:
        error: residual, (lines, outputs).
        power: smallest variance to believe, (outputs,).
        noise: its form, relative standard deviations, (lines, outputs).
    """
    variance = np.maximum(np.mean(np.abs(error / noise) ** 2, axis=0), power)
    return np.asarray(1 / (np.sqrt(variance) * noise))


def refine_segment(
    drive: Drive, segment: Segment, terms: Terms, last: bool, by_hand: bool = False
) -> Drive:
    """Fit the modes of one segment, neighbours included, and drop those that pay for nothing.

    A mode goes where the rise of the cost without it is less than the Bayesian information
    criterion charges for its unknowns. The last time, modes that the residual asks for come in.
    Modes that were chosen by hand stay, and no others come in.

    Returns:
        The refined modes inside the segment.
    """
    inside = segment.holds(drive.omega)
    order = np.argsort(drive.omega)
    position = np.flatnonzero(inside[order])
    if not len(position):
        return drive.without(np.arange(len(drive.omega)))
    members = order[max(position[0] - NEIGHBOURS, 0) : position[-1] + NEIGHBOURS + 1]
    own = Terms(
        tuple(segment.part(s) for s in terms.spectra), terms.hold, terms.powers, terms.w_max
    )
    here = Drive(drive.omega[members], drive.zeta[members], drive.v[members], drive.anchor[members])
    floor = 1e-14 * np.mean(np.abs(own.Y) ** 2, axis=0) + np.finfo(float).tiny
    weight = level_weights(own.Y, floor, own.noise)
    own_low, own_high = (min(s.omega[0] for s in terms.spectra), terms.w_max)
    steps = MOST_STEPS if last else FIRST_STEPS
    for _ in range(ROUNDS if last else 1):
        here, done = solve(here, own, weight, TOLERANCE, steps, _outside(here, segment))
        weight = level_weights(done.error, floor, own.noise)
    while not by_hand and (mine := segment.holds(here.omega)).any():
        done = project(here, own, weight, derivative=False)
        assert done.loss is not None
        price = np.log(2 * own.Y.size) * _unknowns_of_mode(own)
        outside = (here.omega < own_low) | (here.omega > own_high)
        loss = np.where((here.zeta > BROAD) | outside, 0, done.loss)
        cheap = np.flatnonzero(mine & (loss < price))
        if not len(cheap):
            break
        # One mode may stand in for another: not all go at once.
        gone = cheap[np.argsort(loss[cheap])[: (len(cheap) + 1) // 2]]
        here = here.without(gone)
        if not len(here.omega):
            break
        here, done = solve(here, own, weight, TOLERANCE, steps, _outside(here, segment))
        weight = level_weights(done.error, floor, own.noise)
    if last and len(here.omega) and not by_hand:
        here = _with_what_is_missing(here, segment, own, floor)
    mine = segment.holds(here.omega)
    if by_hand:
        mine = np.isin(members, np.flatnonzero(inside))
    return Drive(here.omega[mine], here.zeta[mine], here.v[mine], here.anchor[mine])


def _with_what_is_missing(drive: Drive, segment: Segment, own: Terms, floor: Array) -> Drive:
    """Add the mode that the residual asks for most, as long as it pays for its unknowns."""
    done = project(drive, own, level_weights(own.Y, floor, own.noise), derivative=False)
    for _ in range(ADDITIONS):
        weight = level_weights(done.error, floor, own.noise)
        done = project(drive, own, weight, derivative=False)
        weight = level_weights(done.error, floor, own.noise)
        pole = _loudest(done.error * weight, segment, own)
        if pole is None:
            break
        asked = replace(own, spectra=_with_outputs(own, done.error), powers=())
        one = start_drive(np.array([pole]), asked, np.ones((len(weight), 1)))
        tried = Drive(
            np.append(drive.omega, one.omega),
            np.append(drive.zeta, one.zeta),
            np.vstack([drive.v, one.v]),
            np.append(drive.anchor, one.anchor),
        )
        tried, better = solve(tried, own, weight, TOLERANCE, MOST_STEPS, _outside(tried, segment))
        near = _around(tried, own)
        if not near.any():
            break  # it has left the segment
        before, after = (_level(d.error / own.noise, near, floor) for d in (done, better))
        gain = 2 * float(near.sum()) * float(np.sum(np.log(before / after)))
        sound = segment.holds(tried.omega[-1:])[0] and tried.zeta[-1] < BROAD
        if gain < np.log(2 * own.Y.size) * _unknowns_of_mode(own) or not sound:
            break
        drive, done = tried, better
    return drive


def _outside(drive: Drive, segment: Segment) -> NDArray[np.intp]:
    """Modes of the neighbours: without lines of their own their poles would go astray."""
    return np.flatnonzero(~segment.holds(drive.omega))


def _around(drive: Drive, own: Terms) -> NDArray[np.bool_]:
    """Lines around the last mode: its gain must stand against the noise that is there.

    What nobody measured but drives the structure too, wind or traffic, is loud at resonances.
    """
    omega = np.concatenate([s.omega for s in own.spectra])
    resolution = float(np.median(np.diff(own.spectra[0].omega)))
    off = np.abs(drive.omega - drive.omega[-1])
    width = float(np.max((drive.zeta * drive.omega)[np.argsort(off)[:2]]))
    reach = max(LEAST_LINES / 2 * resolution, 2 * width)
    return np.asarray(np.abs(omega - drive.omega[-1]) <= reach)


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


def _unknowns_of_mode(own: Terms) -> int:
    """Real unknowns of one more mode: pole, drive less its scale, and shape."""
    return 2 * (own.Y.shape[1] + own.drives)


def families(drive: Drive, psi: ComplexArray) -> list[NDArray[np.intp]]:
    """Gather modes of the same shape within one bandwidth of a stronger one, that one first.

    A mode whose frequency or damping depends on amplitude shows as several of them. Every family
    surrounds its strongest member: a broad pole between two resonances does not make them one.
    """
    width = drive.zeta * drive.omega
    near = np.abs(drive.omega[:, None] - drive.omega) < width[:, None] + width
    alike = near & (mac(psi, psi) > SAME_SHAPE)
    energy = np.sum(np.abs(psi) ** 2, axis=0) * np.sum(np.abs(drive.v) ** 2, axis=1) / width
    found = []
    free = np.ones(len(width), bool)
    for leader in np.argsort(energy)[::-1]:
        if free[leader]:
            others = np.flatnonzero(alike[leader] & free)
            found.append(np.r_[leader, others[others != leader]])
            free[found[-1]] = False
    return found


def refine(
    drive: Drive,
    terms: Terms,
    parts: list[Segment],
    last: bool,
    progress: Progress | None = None,
    by_hand: bool = False,
) -> Drive:
    """Refine every segment once and gather the modes."""
    gathered: list[Drive] = []
    for index, segment in enumerate(parts):
        if progress:
            progress("refining", index + 1, len(parts))
        try:
            gathered.append(refine_segment(drive, segment, terms, last, by_hand))
        except (IdentificationError, np.linalg.LinAlgError):
            gathered.append(drive.only(np.flatnonzero(segment.holds(drive.omega))))
    return joined(gathered)


def joined(parts: list[Drive]) -> Drive:
    """Return one drive of all modes, by frequency."""
    omega = np.concatenate([p.omega for p in parts])
    order = np.argsort(omega)
    return Drive(
        omega[order],
        np.concatenate([p.zeta for p in parts])[order],
        np.vstack([p.v for p in parts])[order],
        np.concatenate([p.anchor for p in parts])[order],
    )


def starting_drive(poles: ComplexArray, terms: Terms) -> Drive:
    """Return a first drive of all poles, residues solved for with equal weights."""
    weight = np.ones((len(terms.Y), 1))
    return start_drive(poles, terms, weight)
