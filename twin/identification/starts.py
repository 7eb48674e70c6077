"""Starting poles for the refinement: OKID/ERA on the whole record, ERA on the free decay."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.era import HankelFactors, era
from twin.identification.okid import okid
from twin.identification.order import order_from_singular_values
from twin.identification.records import Records
from twin.identification.spectra import USABLE_FRACTION, excited_band
from twin.identification.stabilisation import (
    StablePole,
    continuous_poles,
    persistent_poles,
    stabilisation,
)
from twin.signals.resampling import resample
from twin.state_space import StateSpace

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

OBSERVER_LENGTH = 80
MARKOV_PARAMETERS = 400
HIGHEST_ORDER = 40
DECAY_SAMPLES = 32
ASSUMED_NOISE = 1e-4
"""Noise power, as a share of each channel's, that a second observer takes for granted."""
ALIKE = 0.003
"""Starting poles this close lead to the same fit."""
RIDGES = (1e-10, 1e-8, 1e-6, 1e-4)
"""Noise assumed on records that are nearly free of it, until the observer is stable."""
GIVEN = "given"
SLOWING_MARGIN = 1.2
"""How far the slower rate's usable band reaches beyond the excited one."""


@dataclass(frozen=True)
class Realizations:
    """What OKID and ERA say, before any refinement.

    Attributes:
        records: what OKID saw, resampled where the input excites low frequencies only.
        hankel: the factorised Hankel matrix of the whole records.
        p: number of observer Markov parameters used.
        order: chosen order, even.
        chosen_by: how the order was chosen, in words.
        diagram: the stabilisation diagram.
        observer: the realization of that order, observer gain included.
    """

    records: Records
    hankel: HankelFactors
    p: int
    order: int
    chosen_by: str
    diagram: tuple[StablePole, ...]
    observer: StateSpace


def longest_observer(records: Records) -> int:
    """Return the default p: 80, or as many as the records determine with five-fold excess."""
    q = len(records.inputs) + len(records.outputs)
    samples = sum(len(u) for u in records.u)
    return max(min(OBSERVER_LENGTH, samples // (5 * q) - 1), 1)


def slowed(records: Records) -> Records:
    """Resample records whose input excites a small part of their bandwidth only.

    Poles crowd around 1 when the sampling is much faster than the vibration, and Markov
    parameters of a given number then span too short a time.
    """
    _, top = excited_band(records.u, records.dt)
    rate = 1 / records.dt
    factor = int(USABLE_FRACTION * rate / (SLOWING_MARGIN * top))
    shortest = min(len(u) for u in records.u)
    if factor < 2 or shortest // factor < 4 * DECAY_SAMPLES:
        return records
    u, y = (
        tuple(resample(block, rate, rate / factor) for block in blocks)
        for blocks in (records.u, records.y)
    )
    slow = tuple(replace(x, sampling_hz=rate / factor) for x in records.recordings)
    hits = tuple(h and (h[0] // factor, -(-h[1] // factor)) for h in records.hits)
    return replace(records, recordings=slow, u=u, y=y, hits=hits)


def realizations(records: Records, p: int | None, order: int | None) -> Realizations:
    """Run OKID and ERA on the whole records and choose the order.

    Noise-free records make a long observer ambiguous: p is then the longest for which the data
    matrix still has full rank, the paper's p m = n.

    Raises:
        IdentificationError: too few samples, or an order that the Hankel matrix does not have.
    """
    if order is not None and not 1 <= order <= HIGHEST_ORDER:
        raise IdentificationError(f"an order of {order} is not possible: 1 to {HIGHEST_ORDER} are")
    r = len(records.inputs)
    records = slowed(records)
    length, markov = _markov_parameters(records, p)
    hankel = era(markov, keep=HIGHEST_ORDER + 20)
    orders = range(2, HIGHEST_ORDER + 1, 2)
    diagram = stabilisation(hankel, records.dt, r, orders)
    chosen_by = GIVEN
    if order is None:
        order = order_from_singular_values(hankel.singular_values)
        chosen_by = "a clear gap in the singular values"
        if order is None:
            order = 2 * len(persistent_poles(diagram))
            chosen_by = "the poles that stay in the stabilisation diagram"
        if not order:
            raise IdentificationError(
                "no order stands out: neither a gap in the singular values nor a stable pole; "
                "choose one with --order"
            )
    observer = hankel.realize(order, records.dt, r)
    return Realizations(records, hankel, length, order, chosen_by, tuple(diagram), observer)


def _markov_parameters(records: Records, p: int | None) -> tuple[int, Array]:
    """Return the observer length used and the combined Markov parameters."""
    length = p or longest_observer(records)
    observer = okid(records.pairs, length, records.at_rest)
    if p is None and observer.rank_deficient:
        length = 1
        while not okid(records.pairs, length + 1, records.at_rest).rank_deficient:
            length += 1
        observer = okid(records.pairs, length, records.at_rest)
    count = max(min(MARKOV_PARAMETERS, max(len(u) for u in records.u) // 2), 2 * length + 2)
    markov = observer.markov(count)
    if _settles(markov):
        return length, markov
    length = p or longest_observer(records)
    for ridge in RIDGES:
        markov = okid(records.pairs, length, records.at_rest, ridge).markov(count)
        if _settles(markov):
            return length, markov
    raise IdentificationError(
        f"OKID found no stable observer of length {length}; choose another with --p"
    )


def _settles(markov: Array) -> bool:
    """Whether the Markov parameters stay bounded, as those of a damped structure do."""
    if not np.all(np.isfinite(markov)):
        return False
    quarter = len(markov) // 4
    return bool(np.abs(markov[-quarter:]).max() <= 3 * np.abs(markov[:quarter]).max())


def candidate_poles(found: Realizations) -> list[tuple[str, ComplexArray]]:
    """Return the starting poles worth trying, each with the name of its origin.

    With an order given by hand every start has as many modes; otherwise the stabilisation
    diagram may know more modes than the gap in the singular values shows.
    """
    modes = max(found.order // 2, 1)
    by_hand = found.chosen_by == GIVEN
    whole, _ = continuous_poles(found.observer)
    candidates = [("OKID/ERA", _most_lightly_damped(whole, modes))]
    steady = persistent_poles(found.diagram)
    if len(steady) >= modes or not by_hand:
        count = modes if by_hand else len(steady)
        candidates.append(("the stabilisation diagram", _most_lightly_damped(steady, count)))
    quieted = _with_assumed_noise(found.records)
    if len(quieted) >= modes or not by_hand:
        count = modes if by_hand else len(quieted)
        origin = "the stabilisation diagram, noise assumed"
        candidates.append((origin, _most_lightly_damped(quieted, count)))
    decay = _free_decay_poles(found.records, found.order)
    if decay is not None:
        candidates.append(("ERA on the free decay", _most_lightly_damped(decay, modes)))
    distinct: list[tuple[str, ComplexArray]] = []
    for name, poles in candidates:
        near = [len(q) == len(poles) and np.allclose(q, poles, rtol=ALIKE) for _, q in distinct]
        if len(poles) and not any(near):
            distinct.append((name, poles))
    return distinct


def _with_assumed_noise(records: Records) -> ComplexArray:
    """Return the stable poles of an observer that expects a per cent of noise on every channel.

    Where an input leaves part of the band empty and there is little noise, the plain observer
    models what happens in that part, to the last digit, and loses the modes.
    """
    length = longest_observer(records)
    count = max(min(MARKOV_PARAMETERS, max(len(u) for u in records.u) // 2), 2 * length + 2)
    observer = okid(records.pairs, length, records.at_rest, ASSUMED_NOISE)
    markov = observer.markov(count)
    if not _settles(markov):
        return np.zeros(0, complex)
    hankel = era(markov, keep=HIGHEST_ORDER + 20)
    orders = range(2, HIGHEST_ORDER + 1, 2)
    return persistent_poles(stabilisation(hankel, records.dt, len(records.inputs), orders))


def _most_lightly_damped(poles: ComplexArray, modes: int) -> ComplexArray:
    """Keep the ``modes`` most lightly damped poles: heavy damping is what noise looks like."""
    damping = -poles.real / np.abs(poles)
    kept = np.sort(np.argsort(np.abs(damping))[:modes])
    return np.asarray(poles[kept])


def free_decay_markov(records: Records) -> Array | None:
    """Return what follows the hits as impulse responses, (samples, outputs, records), or None."""
    tails = []
    for hit, y in zip(records.hits, records.y, strict=True):
        if hit is None or len(y) - hit[1] < DECAY_SAMPLES:
            return None
        tails.append(y[hit[1] :] - y[hit[1] :].mean(axis=0))
    length = min(len(tail) for tail in tails)
    return np.stack([tail[:length] for tail in tails], axis=2)


def _free_decay_poles(records: Records, order: int) -> ComplexArray | None:
    decay = free_decay_markov(records)
    if decay is None:
        return None
    markov = np.concatenate([np.zeros((1, *decay.shape[1:])), decay[: 2 * MARKOV_PARAMETERS]])
    try:
        model = era(markov).realize(order, records.dt, decay.shape[2])
    except IdentificationError:
        return None
    return continuous_poles(model)[0]
