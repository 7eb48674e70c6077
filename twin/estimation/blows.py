"""Blows that an analyser's filter has spread: a force that was short is seen to ring.

A law that holds would follow the ringing and slide where it never did, and so where its force
jumps the force itself has to be known. A blow pushes, in one direction, for a few samples: its
force p(t) = sum_j p_j hat(t - t_j) >= 0 is straight between parts of a sample, and the filter h
makes of it

    u(k) = sum_j p_j (h * hat)(k - t_j),

which is solved by non-negative least squares (Lawson and Hanson 1974) for the smoothest force that
tells it as well. Where that tells all of the ringing it was a blow. What it does not tell of the
measured force stays beside it, so that through the filter the two together are what was measured.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, nnls

from twin.estimation.low_pass import REACH, LowPass, hat_response

Array = NDArray[np.float64]

PARTS = 8
"""Parts of a sample in which a blow is looked for."""

PUSHES = 0.1
"""Share of the peak above which a force may be that of a blow, with a sample to either side."""

LONGEST = 16
"""Samples that a blow pushes for at most: what is longer has its own spectrum in the band."""

TOLD = 0.01
"""Share of the ringing's energy that may be left of a blow: a tenth of its amplitude."""

SMOOTHEST, SMOOTHNESSES = 10.0, 8
"""Weight of a blow's second differences beside its readings, to begin with, and how often it is
taken ten times less: the smoothest of the blows that tell a force as well counts."""

AS_WELL = 1.5
"""Error with which a smooth blow tells a force as well, over the least one: twice its energy."""

WITHIN = 8
"""Points of a part of a sample between which a half sine is summed."""

LATELY = 1024
"""Pieces of inputs that are remembered, a few kilobytes each: a fit comes back to the same blows in
every pass."""

FARTHEST = 4 * REACH
"""Samples after which a filter shows nothing of a hat any more: Butterworth's, too."""


@dataclass(frozen=True)
class Blow:
    """Where a blow is in a recording.

    Attributes:
        column: of the input.
        first, last: samples from and up to which it is seen to ring.
        near: which of them its contact may be in, (last - first,).
    """

    column: int
    first: int
    last: int
    near: NDArray[np.bool_]


@dataclass(frozen=True)
class Blows:
    """The blows in a recording's inputs, looked for where laws are simulated.

    Attributes:
        u: the inputs, (samples, r).
        low_pass: the filter that they passed.
        part: first of the samples whose blows these are, and the one after the last.
    """

    u: Array
    low_pass: LowPass
    part: tuple[int, int | None] = (0, None)

    def of_part(self, first: int, last: int) -> Blows:
        """Return those of a part of the samples, as the whole recording shows them."""
        return replace(self, part=(first, last))

    def shown(self) -> Array:
        """Return what the filter shows of them at the samples, (samples, r)."""
        return self._found(PARTS)[1][slice(*self.part)]

    def finely(self, steps: int) -> tuple[Array, Array]:
        """Return the forces at the parts of each sample, (samples steps, r), and what is shown."""
        force, shown = (found[slice(*self.part)] for found in self._found(steps))
        return force.reshape(-1, force.shape[2]), shown

    def onsets(self, steps: int) -> list[float]:
        """Return where each begins to push [samples], as parts of a sample tell."""
        force, out = self._found(steps)[0], []
        first, last = self.part[0], len(force) if self.part[1] is None else self.part[1]
        for blow in self.each:
            pushes = force[blow.first : blow.last, :, blow.column].ravel()
            onset = blow.first + np.flatnonzero(pushes)[0] / steps
            if first <= onset < last:
                out.append(float(onset - first))
        return out

    @cached_property
    def each(self) -> tuple[Blow, ...]:
        """The blows of the whole recording."""
        return blows_in(self.u, self.low_pass)

    def _found(self, steps: int) -> tuple[Array, Array]:
        """Return forces at the parts, (samples, steps, r), and what is shown, (samples, r)."""
        samples, r = self.u.shape
        force, shown = np.zeros((samples, steps, r)), np.zeros((samples, r))
        for blow in self.each:
            where = slice(blow.first, blow.last)
            u = self.u[where, blow.column]
            side = np.sign(u[np.argmax(np.abs(u))])
            piece = (side * u).tobytes()
            pushes, seen = _pushes(piece, blow.near.tobytes(), self.low_pass, steps)
            force[where, :, blow.column] += side * pushes
            shown[where, blow.column] += side * seen
        return force, shown


def blows_in(u: Array, low_pass: LowPass) -> tuple[Blow, ...]:
    """Return the blows in inputs.

    Args:
        u: as measured, (samples, r).
        low_pass: the analyser's filter.
    """
    each = []
    for column, force in enumerate(u.T):
        side = np.sign(force[np.argmax(np.abs(force))])
        contact = np.flatnonzero(side * force > PUSHES * np.max(np.abs(force)))
        groups = np.split(contact, np.flatnonzero(np.diff(contact) > 2 * REACH) + 1)
        for group in groups if len(contact) else ():
            if len(group) > LONGEST:
                continue
            first, last = max(group[0] - REACH, 0), min(group[-1] + REACH + 1, len(u))
            near = np.zeros(last - first, bool)
            for beside in (-1, 0, 1):
                near[np.clip(group - first + beside, 0, len(near) - 1)] = True
            if _is_told((side * force[first:last]).tobytes(), near.tobytes(), low_pass):
                each.append(Blow(column, first, last, near))
    return tuple(each)


@lru_cache(LATELY)
def _is_told(piece: bytes, contact: bytes, low_pass: LowPass) -> bool:
    """Return whether a push where a contact may be tells the ringing around it.

    Args:
        piece: of an input, its samples as they lie in memory.
        contact: which of them its contact may be in, likewise.
        low_pass: the analyser's filter.
    """
    force, near = np.frombuffer(piece), np.frombuffer(contact, bool)
    response = responses(len(force), _at(near, PARTS), low_pass, PARTS)
    left = (force - response @ nnls(response, force)[0])[~near]
    return bool(np.sum(left**2) < TOLD * np.sum(force[~near] ** 2))


def _at(near: NDArray[np.bool_], steps: int) -> NDArray[np.intp]:
    """Return the parts of samples that a contact may be in."""
    return np.flatnonzero(np.repeat(near, steps))


def responses(samples: int, at: NDArray[np.intp], low_pass: LowPass, steps: int) -> Array:
    """Return what a filter shows of hats at parts of samples, (samples, parts)."""
    lag = np.arange(samples)[:, None] * steps - at
    farthest = FARTHEST * steps
    return _table(low_pass, steps)[np.clip(lag, -farthest, farthest) + farthest]


@lru_cache(LATELY)
def _pushes(piece: bytes, contact: bytes, low_pass: LowPass, steps: int) -> tuple[Array, Array]:
    """Return a blow's force, (samples, steps), and what is shown of it, (samples,).

    The arguments are those of ``_is_told``, and parts of a sample.
    """
    force, near = np.frombuffer(piece), np.frombuffer(contact, bool)
    at = _at(near, steps)
    response = responses(len(force), at, low_pass, steps)
    found, least = nnls(response, force)
    half_sine = _half_sine(force, at / steps, found, response)
    if half_sine is not None and np.linalg.norm(force - response @ half_sine) < AS_WELL * least:
        found = half_sine
    else:
        bends = np.diff(np.eye(len(at) + 4), 2, axis=0)[:, 2:-2]  # it begins and ends with nothing
        for weight in SMOOTHEST * 10.0 ** -np.arange(SMOOTHNESSES):
            smooth, _ = nnls(np.vstack([response, weight * bends]),
                             np.concatenate([force, np.zeros(len(bends))]))  # fmt: skip
            if np.linalg.norm(force - response @ smooth) < AS_WELL * least:
                found = smooth
                break
    pushes = np.zeros(len(force) * steps)
    pushes[at] = found
    return pushes.reshape(-1, steps), response @ found


@cache
def _table(low_pass: LowPass, steps: int) -> Array:
    """Return the filter's response to a hat, in parts of a sample from before it to behind it."""
    parts = np.arange(-FARTHEST * steps, FARTHEST * steps + 1)
    response = hat_response(low_pass, steps)(parts / steps)
    response[[0, -1]] = 0.0  # and beyond
    return response


def _half_sine(force: Array, t: Array, rough: Array, response: Array) -> Array | None:
    """Return the half sine that tells a force best, at instants t, (t,); None where nothing pushes.

    Args:
        force: as measured, (samples,).
        t: instants [samples].
        rough: a force there that tells it, (t,).
        response: the filter's to hats at these instants, (samples, t).
    """
    total = float(np.sum(rough))
    if not total > 0:
        return None
    middle = float(rough @ t) / total
    spread = np.sqrt(float(rough @ (t - middle) ** 2) / total)
    step = t[1] - t[0]
    inner = (np.arange(WITHIN) + 0.5) / WITHIN - 0.5
    instants = t[:, None] + step * np.concatenate([inner - 0.5, inner + 0.5])
    hat = 1 - np.abs(instants[0] - t[0]) / step
    hat /= np.sum(hat)

    def shape(numbers: Array) -> Array:
        """Return a half sine as hats see it, so that no impulse is lost between them."""
        phase = (instants - numbers[0]) / max(numbers[1], step) + 0.5
        push = np.where((phase > 0) & (phase < 1), np.sin(np.pi * phase), 0.0)
        return np.asarray(numbers[2] * push @ hat)

    # the variance of a half sine is w^2 (1/4 - 2 / pi^2)
    width = max(spread / np.sqrt(0.25 - 2 / np.pi**2), 2 * step)
    begin = np.array([middle, width, total * step * np.pi / (2 * width)])
    found = least_squares(lambda x: response @ shape(x) - force, begin,
                          x_scale=[width, width, begin[2]])  # fmt: skip
    return shape(found.x)
