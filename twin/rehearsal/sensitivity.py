"""What a plan could show at best: the Fisher information of every effect, beside every other's.

An effect of size s changes the outputs by s g. In the metric in which the noise of the outputs, and
of the measured inputs through the structure, has unit variance, and with everything projected out
that the drawing's tolerance can take up, the true model is on average

    L(s) = s^2 g^T g / 2     nats

likelier than the twin without the effect, and L (1 - cos^2) likelier than another effect h of any
size, cos the cosine between g and h.

Source: Rao 1948 (score test); Kay, Fundamentals of Statistical Signal Processing, ch. 3 and 15.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model.linear import LinearModel
from twin.rehearsal.effects import Effect, sized
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
    model: LinearModel, trials: Sequence[Trial], known: Known, effects: Sequence[Effect]
) -> list[Prospect]:
    """Return for every effect from which size on it is seen, and named.

    Args:
        model: linear equations of the twin with the trials' inputs and outputs.
        trials: the training recordings, nothing concealed.
        known: what may be taken up by the drawing's own numbers.
        effects: what may be there; each is a rival of the others.
    """
    whitened = [Whitener(model, trial) for trial in trials]
    base = _own(model, Known(SMALL * known.tolerance, SMALL * known.damping_tolerance))
    # nuisance first, then the shapes of each effect, the reference first
    directions: list[tuple[int, Mechanism]] = [
        (i, shape)
        for i, effect in enumerate(effects)
        for shape in (effect.shapes if effect.sized else effect.shapes[:1])
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
    same = [_no_rivals(effects, i, model) for i in range(len(effects))]
    return [
        _of_disturbance(whitened, effect, wanted)
        if isinstance(effect.reference, Disturbance)
        else _prospect(inside, owners, i, same[i], effects, wanted)
        for i, effect in enumerate(effects)
    ]


def _beside(gram: Array, count: int) -> Array:
    """Return inner products with the first directions projected out, held to their unit priors."""
    own, across, rest = gram[:count, :count], gram[:count, count:], gram[count:, count:]
    return np.asarray(rest - across.T @ np.linalg.solve(np.eye(count) + own, across))


def _prospect(
    inside: Array, owners: NDArray[np.int64], index: int, excluded: NDArray[np.bool_],
    effects: Sequence[Effect], wanted: float,
) -> Prospect:  # fmt: skip
    at = int(np.flatnonzero(owners == index)[0])
    power = np.maximum(np.diagonal(inside), 0.0)
    if not power[at] > 0:
        return Prospect(np.inf, np.inf)
    cosine = inside[at] ** 2 / np.maximum(power[at] * power, 1e-300)
    cosine[excluded[owners] | (power <= 0)] = 0.0
    nearest = int(np.argmax(cosine))
    rival = effects[owners[nearest]].label if cosine[nearest] > 0 else None
    nats = 0.5 * power[at]
    apart = nats * max(1 - float(cosine[nearest]), 0.0)
    seen = float(np.sqrt(wanted / nats))
    named = float(np.sqrt(APART / apart)) if apart > 0 else np.inf
    if not effects[index].sized:
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


def _of_disturbance(whitened: Sequence[Whitener], effect: Effect, wanted: float) -> Prospect:
    """Return from which size on a random force is seen: its likelihood ratio is one of spectra."""
    assert isinstance(effect.reference, Disturbance)
    ratio = np.concatenate([white.spectrum(effect.reference) for white in whitened])

    def nats(times: float) -> float:
        return float(np.sum(times**2 * ratio - np.log1p(times**2 * ratio)))

    low, high = 1e-6, FARTHEST
    if nats(high) < wanted:
        return Prospect(np.inf, np.inf)
    while high / low > 1.01:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if nats(middle) < wanted else (low, middle)
    return Prospect(high, high)
