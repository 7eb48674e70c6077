"""Segments refined: their poles one segment at a time, and which of them pay for themselves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.additions import (
    BROAD,
    MOST_STEPS,
    TOLERANCE,
    held_modes,
    unknowns_of_mode,
    with_what_is_missing,
    without_what_another_covers,
)
from twin.identification.segment import Segment, level_weights
from twin.identification.separable import project, solve, start_drive
from twin.identification.separable_terms import Drive, Terms
from twin.modal import mac

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Progress = Callable[[str, int, int], None]
"""Told what is done, which step it is and of how many."""

NEIGHBOURS = 2
"""Modes beyond either end that a segment's model has too."""

FIRST_STEPS = 5
"""Gauss-Newton steps of the first sweep, which only has to tell modes from mere poles."""

ROUNDS = 2
"""Times the noise level of a segment is estimated anew."""

SAME_SHAPE = 0.99
"""MAC above which two modes within one bandwidth are one."""


@dataclass(frozen=True)
class Step:
    """What is done to segments.

    Attributes:
        first: whether poles are rough still: a few iterations will do.
        adding: whether modes that the residual asks for come in.
        by_hand: whether the modes were chosen by hand: all stay.
    """

    first: bool = False
    adding: bool = False
    by_hand: bool = False


def refine_segment(
    drive: Drive,
    segment: Segment,
    terms: Terms,
    step: Step,
    psi: ComplexArray | None = None,
) -> Drive:
    """Fit the modes of one segment, neighbours included, and drop those that pay for nothing.

    A mode goes where the rise of the cost without it is less than the Bayesian information
    criterion charges for its unknowns, or where another within its bandwidth can stand for it.
    Where the shapes ``psi`` of all modes are known, (outputs, modes), the response of those far
    away is taken off first; the direct terms alone stand for it otherwise, and nothing for its
    leakage.

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
    if not len(own.Y):
        return drive.only(np.flatnonzero(inside))  # beyond the band's end
    if psi is not None:
        far = np.setdiff1d(np.arange(len(drive.omega)), members)
        own = without(own, drive.only(far), psi[:, far])
    here = Drive(drive.omega[members], drive.zeta[members], drive.v[members], drive.anchor[members])
    floor = 1e-14 * np.mean(np.abs(own.Y) ** 2, axis=0) + np.finfo(float).tiny
    weight = level_weights(own.Y, floor, own.noise)
    steps = FIRST_STEPS if step.first else MOST_STEPS
    for _ in range(1 if step.first else ROUNDS):
        here, done = solve(here, own, weight, TOLERANCE, steps, held_modes(here, segment))
        weight = level_weights(done.error, floor, own.noise)
    while not step.by_hand and (mine := segment.holds(here.omega)).any():
        done = project(here, own, weight, derivative=False)
        assert done.loss is not None
        price = np.log(2 * own.Y.size) * unknowns_of_mode(own)
        loss = np.where(here.zeta > BROAD, 0, done.loss)
        cheap = np.flatnonzero(mine & (loss < price))
        if not len(cheap):
            break
        # One mode may stand in for another: not all go at once.
        gone = cheap[np.argsort(loss[cheap])[: (len(cheap) + 1) // 2]]
        here = here.without(gone)
        if not len(here.omega):
            break
        here, done = solve(here, own, weight, TOLERANCE, steps, held_modes(here, segment))
        weight = level_weights(done.error, floor, own.noise)
    if step.adding and len(here.omega):
        here = with_what_is_missing(here, segment, own, floor)
    if not step.first and not step.by_hand and len(here.omega):
        here = without_what_another_covers(here, segment, own, floor)
    mine = segment.holds(here.omega)
    if step.by_hand:
        mine = np.isin(members, np.flatnonzero(inside))
    return Drive(here.omega[mine], here.zeta[mine], here.v[mine], here.anchor[mine])


def without(own: Terms, drive: Drive, psi: ComplexArray) -> Terms:
    """Return lines less the response of some modes, free responses included.

    Args:
        own: the lines.
        drive: the modes.
        psi: their shapes, (outputs, modes).
    """
    if not len(drive.omega):
        return own
    E, _, mirror, _ = own.modal(drive.poles)
    a = np.einsum("knq,nq->kn", E, drive.v)
    m = np.einsum("knq,nq->kn", mirror, drive.v.conj())
    left = own.Y - a @ psi.T - m @ psi.conj().T
    parts = zip(own.spectra, own.rows, strict=True)
    return replace(own, spectra=tuple(replace(s, Y=left[rows]) for s, rows in parts))


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
    step: Step,
    progress: Progress | None = None,
    psi: ComplexArray | None = None,
) -> Drive:
    """Refine every segment once and gather the modes, as of ``refine_segment``."""
    gathered: list[Drive] = []
    for index, segment in enumerate(parts):
        if progress:
            progress("refining", index + 1, len(parts))
        try:
            gathered.append(refine_segment(drive, segment, terms, step, psi))
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
