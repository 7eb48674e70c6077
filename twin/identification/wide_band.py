"""Modes of a test with many lines, modes or channels: found, refined by segments, weighed.

Least-squares complex frequency gives the stabilisation diagram, its columns the starting poles;
variable projection refines them segment by segment with a noise level of each segment's own, and
modes that do not pay for their unknowns go. All residues are then solved for at once, and the
covariance of poles follows from the Fisher information.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.additions import BEYOND, unknowns_of_mode
from twin.identification.clusters import clusters, diagram
from twin.identification.complex_frequency import denominator
from twin.identification.holds import DECISIVE, converted, likelier_hold, other_hold
from twin.identification.levels import levelled, log_likelihood, segment_weights
from twin.identification.maximum_likelihood import ModalFit
from twin.identification.modal_response import Hold
from twin.identification.projected import Projected
from twin.identification.segment import LEAST_LINES, Segment, segments
from twin.identification.segments import (
    Progress,
    Step,
    families,
    refine,
    starting_drive,
)
from twin.identification.seminormal import covariance_of
from twin.identification.separable import project, solve
from twin.identification.separable_terms import Drive, Terms
from twin.identification.spectra import Spectrum
from twin.identification.stabilisation import StablePole
from twin.identification.wide_parameters import as_fit

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

HIGHEST_ORDER = 60
POWERS = (0, 2, -2)
"""Direct term, modes above and modes below the band, as powers of frequency."""

SWEEPS = 2
"""Times the segments are refined: the second time with neighbours that are refined already."""

AT_ONCE = 0.1
"""What a step of the fit of all modes at once promises at least, in squared standard deviations of
all parameters together: the fit ends within a third of one of the optimum."""

STEPS_AT_ONCE = 8
"""Gauss-Newton steps of that fit at most; from where the segments end it takes two or three."""

STEADY = 0.4
"""Share of the orders that a column of stable poles spans at least."""

LINES_A_POLE = 6
"""Lines for each pole of the highest order, at least."""

LINES_IN_PART = 1500
"""Lines of a part of the band that gets a stabilisation diagram of its own, at most."""

REACH = 5.0
"""Half bandwidths to either side in which one mode is fitted to a family of them."""

MARGIN = 0.1
"""By how much of its width such a part overlaps its neighbours."""


@dataclass(frozen=True)
class WideFit:
    """Modes found over a wide band.

    Attributes:
        fit: the modal fit, companions included.
        diagram: the stabilisation diagram.
        families: indices of modes of one shape within one bandwidth; one of them stands for all.
        leader: the index of the strongest, of every family.
        omega: its angular frequency, or that of one mode fitted to the family's response [rad/s].
        zeta: its damping ratio, likewise.
        std: standard deviations of frequency [Hz] and damping ratio, (2, families).
        by_hand: whether the poles were chosen by hand; all of them are listed then.
    """

    fit: ModalFit
    diagram: tuple[StablePole, ...]
    families: list[NDArray[np.intp]]
    leader: NDArray[np.intp]
    omega: Array
    zeta: Array
    std: Array
    by_hand: bool = False


def starting_poles(
    spectra: Sequence[Spectrum], progress: Progress | None = None
) -> tuple[ComplexArray, tuple[StablePole, ...]]:
    """Return the steady columns of the stabilisation diagrams of parts of the band.

    A weak mode that a diagram of the whole band misses stands out in one with a few others.

    Args:
        spectra: the records.
        progress: told what is done.
    """
    low, high = float(spectra[0].omega[0]), float(spectra[0].omega[-1])
    resolution = float(np.median(np.diff(spectra[0].omega)))
    lines = len(spectra[0].omega)
    count = max(int(np.ceil(lines / LINES_IN_PART)), 1)
    width = (high - low) / count
    poles: list[complex] = []
    shown: list[StablePole] = []
    for index in range(count):
        if progress:
            progress("least-squares complex frequency", index + 1, count)
        start, stop = low + index * width, low + (index + 1) * width
        part = Segment(start - MARGIN * width, stop + MARGIN * width)
        records = [part.part(s) for s in spectra]
        held = min(len(s.omega) for s in records)
        highest = int(min(HIGHEST_ORDER, max(held // LINES_A_POLE, 4)))
        orders = range(2, highest + 1, 2)
        equations = denominator(records, highest, [s.weight for s in records])
        found = diagram(equations, orders, resolution)
        steady = [c for c in clusters(found, resolution) if c.orders >= STEADY * len(orders)]
        poles += [c.pole for c in steady if start <= c.pole.imag < stop]
        shown += [p for p in found if start <= p.pole.imag < stop]
    return np.array(sorted(poles, key=abs), complex), tuple(shown)


def fit_wide(
    spectra: Sequence[Spectrum],
    hold: Hold | None,
    poles: ComplexArray,
    found: tuple[StablePole, ...],
    progress: Progress | None = None,
    by_hand: bool = False,
) -> WideFit:
    """Refine poles segment by segment, drop what does not pay, and solve for all residues.

    Poles that were chosen by hand all stay, each a mode of its own, and are fitted to the lines
    around them: what nobody chose must not draw them away.

    Without a given behaviour of the input between samples, the one is taken that the evidence of
    the first sweep's poles decides for; a band-limited input where it does not.

    Raises:
        IdentificationError: no pole to start from, or none left.
    """
    if not len(poles):
        raise IdentificationError(
            "no pole stays in the stabilisation diagram: the force excites no resonance inside "
            "the band; choose another with --band"
        )
    w_max = max(float(s.omega[-1]) for s in spectra)
    w_min = min(float(s.omega[0]) for s in spectra)
    resolution = float(np.median(np.diff(spectra[0].omega)))
    if by_hand:
        spectra = around(spectra, poles, resolution)
    terms = Terms(tuple(spectra), hold or "band-limited", POWERS, w_max)
    drive = starting_drive(poles, terms)
    for sweep in range(SWEEPS):
        parts = segments(drive.omega, w_min / BEYOND, w_max * BEYOND, resolution)
        step = Step(first=sweep == 0, adding=sweep == SWEEPS - 1 and not by_hand, by_hand=by_hand)
        drive = _swept(drive, terms, parts, step, progress)
        if hold is None and sweep == 0:
            drive, terms = likelier_hold(drive, terms, parts)
    polish = Step(by_hand=by_hand)
    other, there = drive, replace(terms, hold=other_hold(terms.hold))
    if hold is None:
        # What is left over tells the input's behaviour where the poles are good.
        other = _swept(converted(drive, terms, there), there, parts, polish, progress)
    drive = _swept(drive, terms, parts, polish, progress)
    if hold is None:
        gain = log_likelihood(other, there, parts) - log_likelihood(drive, terms, parts)
        # Where the records do not tell, an anti-alias filter speaks for a band-limited input.
        if gain > (DECISIVE / 2 if there.hold == "held" else -DECISIVE / 2):
            drive, terms = other, there
    drive, done, weight = _settled(drive, terms, parts, by_hand)
    fit = as_fit(drive, done, terms, weight, w_min)
    alone = [np.array([i]) for i in range(len(drive.omega))]
    kin = alone if by_hand else families(drive, done.psi)
    return replace(_named(fit, found, kin), by_hand=by_hand)


def around(spectra: Sequence[Spectrum], poles: ComplexArray, resolution: float) -> list[Spectrum]:
    """Return the lines around some poles.

    Args:
        spectra: the records.
        poles: [rad/s].
        resolution: distance of the lines [rad/s].
    """
    reach = np.maximum(-REACH * poles.real, LEAST_LINES / 2 * resolution)
    found = []
    for s in spectra:
        near = np.any(np.abs(s.omega[:, None] - np.abs(poles)) <= reach, axis=1)
        noise = None if s.noise is None else s.noise[near]
        found.append(replace(s, omega=s.omega[near], U=s.U[near], Y=s.Y[near], noise=noise))
    return found


def _named(
    fit: ModalFit,
    found: tuple[StablePole, ...],
    kin: list[NDArray[np.intp]],
) -> WideFit:
    """Let one mode stand for each family."""
    p = fit.parameters
    leader = np.array([members[0] for members in kin])
    omega, zeta = p.omega[leader].copy(), p.zeta[leader].copy()
    std = np.array(fit.modal_std())[:, leader]
    for index, members in enumerate(kin):
        if len(members) > 1:
            alone = _as_one(fit, members, leader[index])
            # The family's poles are exchangeable: how far they are apart is what is not known.
            spread = abs(alone[0] - omega[index]) / (2 * np.pi), abs(alone[1] - zeta[index])
            omega[index], zeta[index] = alone
            std[:, index] = np.maximum(
                spread, np.array(fit.modal_std(bound=True))[:, leader[index]]
            )
    return WideFit(fit, found, kin, leader, omega, zeta, std)


def _as_one(fit: ModalFit, members: NDArray[np.intp], leader: int) -> tuple[float, float]:
    """Fit one mode to the response that a family has together, where its own bandwidth is."""
    p = fit.parameters
    centre = float(p.omega[leader])
    reach = REACH * float(p.zeta[leader] * centre)
    omega = np.linspace(centre - reach, centre + reach, 201)
    residue = p.psi[:, members] * np.sum(p.participation[members], axis=1)
    Y = (1 / (1j * omega[:, None] - p.poles[members])) @ residue.T
    s = Spectrum(omega, np.ones((len(omega), 1), complex), Y, 1, 1.0, transient=False)
    terms = Terms((s,), "band-limited", (0,), float(omega[-1]))
    one = Drive(
        p.omega[[leader]], p.zeta[[leader]], np.ones((1, 1), complex), np.zeros(1, np.int64)
    )
    one, _ = solve(one, terms, np.ones(Y.shape), 1e-6, 20)
    return float(one.omega[0]), float(one.zeta[0])


def _swept(
    drive: Drive, terms: Terms, parts: list[Segment], step: Step, progress: Progress | None
) -> Drive:
    """Refine every segment once, from the second time on with the others' response taken off."""
    psi = None if step.first else levelled(drive, terms, parts).psi
    drive = refine(drive, terms, parts, step, progress, psi)
    if not len(drive.omega):
        raise IdentificationError("no mode pays for its unknowns: the outputs hold noise only")
    return drive


def _settled(
    drive: Drive, terms: Terms, parts: list[Segment], by_hand: bool
) -> tuple[Drive, Projected, Array]:
    """Fit all modes at once, lines weighed by their segment's noise; drop what is too vague.

    A segment knows the modes of others only by what they were before it was fitted: errors that
    enter each other's are not at the bound until all are solved for together. Modes that do not pay
    for their unknowns beside all others go, and those among the lines whose damping is vaguer than
    it is large; that of a flank from beyond the band always is.
    """
    lines = np.concatenate([s.omega for s in terms.spectra])
    first, last = lines.min(), lines.max()
    price = unknowns_of_mode(terms) * float(np.log(2 * terms.Y.size))

    def needless(done: Projected, vague: NDArray[np.bool_]) -> NDArray[np.intp]:
        assert done.loss is not None
        cheap = np.flatnonzero(vague | (done.loss < price))
        # One mode may stand in for another: not all go at once.
        gone = cheap[np.argsort(done.loss[cheap])[: (len(cheap) + 1) // 2]]
        return np.array([], np.intp) if by_hand or len(gone) == len(vague) else gone

    # What is needless where the segments end would only lead the fit astray.
    weight = segment_weights(levelled(drive, terms, parts).error, terms, parts)
    while True:
        done = project(drive, terms, weight, derivative=False)
        gone = needless(done, np.zeros(len(drive.omega), bool))
        if not len(gone):
            break
        drive = drive.without(gone)
        weight = segment_weights(done.error, terms, parts)
    while True:
        drive, done = solve(drive, terms, weight, AT_ONCE / (2 * terms.Y.size), STEPS_AT_ONCE)
        assert done.gram is not None
        std = np.sqrt(np.diag(covariance_of(done.gram)))
        vague = std.reshape(*drive.v.shape, 2)[:, 0, 1] > 1
        gone = needless(done, vague & (drive.omega >= first) & (drive.omega <= last))
        if not len(gone):
            return drive, done, weight
        drive = drive.without(gone)
        weight = segment_weights(done.error, terms, parts)
