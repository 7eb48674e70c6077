"""What a plan could show at best: the Fisher information of every effect, beside every other's.

An effect of size s changes the outputs by s g. In the metric in which the noise of the outputs, and
of the measured inputs through the structure, has unit variance, and with everything projected out
that the drawing's tolerance can take up, the true model is on average

    L(s) = s^2 g^T g / 2     nats

likelier than the twin without the effect, and L (1 - R^2) likelier than another effect of any size
and shape, R^2 the share of g that the other explains.

Source: Rao 1948 (score test); MacKay 1992, Bayesian interpolation (what a parameter costs).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model.linear import LinearModel
from twin.rehearsal.effects import Effect, adds, sized
from twin.rehearsal.whitening import Trial, Whitener

Array = NDArray[np.float64]

SMALL = 1e-3
"""Size, as a multiple of an effect's reference, at which its direction is taken: linear to a
thousandth, and far above rounding."""

FALSE_ALARM = 0.01
FOUND = 0.9
"""Chance of naming anything where nothing is, and of naming what there is at its limit."""

FARTHEST = 100.0
"""Multiples of a visible effect beyond which no limit is stated: the linear prediction is void."""


SPREAD = 1.5
"""Prior deviation of a parameter's logarithm: a factor of four and a half either way. Where the
data tell it to 1 / sqrt(2 L), the evidence pays ln(1.5 sqrt(2 L)) for it (MacKay 1992)."""

CLOSE = 1.01
"""A size is solved for to a hundredth."""

SAME = 1e-6
"""Share of two directions' area below which they are one."""


@dataclass(frozen=True)
class Known:
    """How well the drawing is known.

    Attributes:
        tolerance: deviation of masses and stiffnesses, as a share.
        damping_tolerance: the same of modal dampings.
    """

    tolerance: float
    damping_tolerance: float


@dataclass(frozen=True)
class Prospect:
    """What is to be expected of one effect.

    Attributes:
        seen: multiple of its reference from which the twin without it is refuted; inf for never.
        named: multiple from which the nearest rival is, too; inf for never.
        rival: the nearest other mechanism and place, or None.
    """

    seen: float
    named: float
    rival: tuple[str, str] | None = None


def needed_nats(candidates: int) -> float:
    """Return the mean log likelihood ratio at which an effect is found in nine of ten cases [nat].

    Of noise alone, the ratio of one candidate beats ln(candidates / alarm) with a probability of
    at most alarm / candidates (Markov's inequality). Of the effect it is normal with mean L and
    variance 2 L, and beats that in nine of ten cases if L - 1.2816 sqrt(2 L) is as much.
    """
    half = float(ndtri(FOUND)) / np.sqrt(2)
    return float((half + np.sqrt(half**2 + np.log(max(candidates, 1) / FALSE_ALARM))) ** 2)


APART = 2 * float(ndtri(FOUND)) ** 2
"""Nats by which the true model is on average likelier than one rival where it is so in nine of
ten cases: L = 1.2816 sqrt(2 L)."""


def prospects(
    model: LinearModel, trials: Sequence[Trial], known: Known, concealed: Sequence[Effect],
    others: Sequence[Effect] = (),
) -> list[Prospect]:  # fmt: skip
    """Return for every effect from which size on it is seen, and named.

    Args:
        model: linear equations of the twin with the trials' inputs and outputs.
        trials: the training recordings, nothing concealed.
        known: what may be taken up by the drawing's own numbers.
        concealed: the effects that are asked for; each is a rival of the others.
        others: rivals that are not asked for.
    """
    effects = (*concealed, *others)
    whitened = [Whitener(model, trial) for trial in trials]
    base = _own(model, Known(SMALL * known.tolerance, SMALL * known.damping_tolerance))
    # nuisance first, then the shapes of each effect, in their order
    directions: list[tuple[int, Mechanism]] = [
        (i, shape)
        for i, effect in enumerate(effects)
        for shape in effect.shapes
        if not isinstance(shape, Disturbance)
    ]
    gram = np.zeros((len(base) + len(directions),) * 2)
    for white in whitened:
        # along a tangent: a per cent of a frequency is cycles at a recording's end
        changes = [(white.edited(other) - white.nominal) / SMALL for other in base]
        for i, shape in directions:
            step = SMALL if effects[i].sized else 1.0
            changes.append(white.change(sized(shape, step) if step != 1.0 else shape) / step)
        V = white(changes)
        gram += V.T @ V
    inside = _beside(gram, len(base))
    wanted = needed_nats(len(effects))
    owners = np.array([i for i, _ in directions], int)
    groups = [np.flatnonzero(owners == i) for i in range(len(effects))]
    same = [_no_rivals(effects, i, model) for i in range(len(concealed))]
    return [
        _of_process(whitened, effect, wanted)
        if isinstance(effect.reference, Disturbance) or adds(effect.reference)
        else _prospect(inside, groups, i, same[i], effects, wanted)
        for i, effect in enumerate(concealed)
    ]


def _beside(gram: Array, count: int) -> Array:
    """Return inner products with the first directions projected out, held to their unit priors."""
    own, across, rest = gram[:count, :count], gram[:count, count:], gram[count:, count:]
    return np.asarray(rest - across.T @ np.linalg.solve(np.eye(count) + own, across))


def _alike(inside: Array, own: NDArray[np.int64], at: int) -> float:
    """Return the share of a direction that an effect explains at best, 0 to 1.

    Its sizes are positive, as the directions of its first guesses are; between two neighbours it
    may have any shape, which both together come near.

    Args:
        inside: inner products of all directions, (d, d).
        own: those of the effect, in the order of its first guesses.
        at: the direction that is to be explained.
    """
    best = 0.0
    for k, first in enumerate(own):
        if inside[first, first] > 0:
            best = max(best, max(inside[first, at], 0.0) ** 2 / inside[first, first])
        for second in own[k + 1 : k + 2]:
            pair = [first, second]
            block, across = inside[np.ix_(pair, pair)], inside[pair, at]
            if np.linalg.det(block) > SAME * block[0, 0] * block[1, 1]:
                sizes = np.linalg.solve(block, across)
                if np.all(sizes > 0):
                    best = max(best, float(across @ sizes))
    return best / float(inside[at, at])


def _prospect(
    inside: Array, groups: Sequence[NDArray[np.int64]], index: int,
    excluded: NDArray[np.bool_], effects: Sequence[Effect], wanted: float,
) -> Prospect:  # fmt: skip
    own = effects[index]
    at = int(groups[index][effects[index].middle])
    nats = 0.5 * float(inside[at, at])
    if not nats > 0:
        return Prospect(np.inf, np.inf)
    alike = np.array(
        [0.0 if e else _alike(inside, g, at) for g, e in zip(groups, excluded, strict=True)]
    )
    nearest = int(np.argmax(alike))
    rival = effects[nearest].label if alike[nearest] > 0 else None
    apart = nats * max(1 - float(alike[nearest]), 0.0)
    wanted += _cost(own, wanted)
    seen = float(np.sqrt(wanted / nats))
    named = float(np.sqrt(APART / apart)) if apart > 0 else np.inf
    if not own.sized:
        seen, named = (1.0 if x <= 1 else np.inf for x in (seen, named))
    seen, named = (x if x <= FARTHEST else np.inf for x in (seen, max(seen, named)))
    return Prospect(seen, named, rival)


def _no_rivals(effects: Sequence[Effect], index: int, model: LinearModel) -> NDArray[np.bool_]:
    """Return which effects are no rivals of one.

    Those are itself; what is read off the samples, for it is no fit's explanation; and what has no
    size beside what has: it is never a little of anything.
    """
    own = effects[index]
    name, place = own.label

    def apart(e: Effect) -> bool:
        fault = e.reference
        read_off = isinstance(fault, ChannelFault) and not fault.fitted
        here = e.label[0] == name and same_place(e.label[1], place, model)
        return here or read_off or e.sized != own.sized

    return np.array([apart(e) for e in effects])


def same_place(one: str, other: str, model: LinearModel) -> bool:
    """Return whether two places are one: a name, two channels in any order, a row alike."""
    if sorted(one.split("+")) == sorted(other.split("+")):
        return True
    if one not in model.ports or other not in model.ports:
        return False
    a, b = model.port(one), model.port(other)
    return bool(min(np.linalg.norm(a - b), np.linalg.norm(a + b)) < 1e-6 * np.linalg.norm(b))


def _own(model: LinearModel, known: Known) -> list[LinearModel]:
    """Return the twin with each of its own numbers a prior's deviation off."""
    out = []
    compliance = np.linalg.pinv(model.K)
    for name in model.places("drift"):
        row = model.port(name)
        if (seen := float(row @ compliance @ row)) > 0:
            out.append(model.adding(K=known.tolerance / seen, along=row))
    for body in model.bodies.values():
        rows = body.translation
        out.append(model.adding(M=known.tolerance * body.mass * rows.T @ rows))
    for i, own in enumerate(np.diagonal(model.R)):
        along = np.eye(len(model.R))[i]
        out.append(model.adding(R=known.damping_tolerance * max(float(own), 0.0), along=along))
    return out


def _of_process(whitened: Sequence[Whitener], effect: Effect, wanted: float) -> Prospect:
    """Return from which size on a random process is seen: its likelihood ratio is one of spectra.

    With a the power at a frequency over the noise's, it is a - ln(1 + a) there (Whittle 1953).
    """
    process = effect.reference
    ratio = np.concatenate(
        [
            white.spectrum(process) if isinstance(process, Disturbance) else white.power(process)
            for white in whitened
        ]
    )
    wanted += _cost(effect, wanted)

    def nats(times: float) -> float:
        return float(np.sum(times**2 * ratio - np.log1p(times**2 * ratio)))

    low, high = 1e-6, FARTHEST
    if nats(high) < wanted:
        return Prospect(np.inf, np.inf)
    while high / low > CLOSE:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if nats(middle) < wanted else (low, middle)
    return Prospect(high, high)


def _cost(effect: Effect, wanted: float) -> float:
    """Return what the evidence pays for an effect's parameters, known as well as that [nat]."""
    return len(effect.reference.parameters) * float(np.log(SPREAD * np.sqrt(2 * wanted)))
