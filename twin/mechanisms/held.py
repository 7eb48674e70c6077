"""What a user's model already holds, as mechanisms of the base.

The exported twin needs none of them: they are in its text. An estimator starts from them, with
their values as priors.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError
from twin.mechanisms import from_json
from twin.mechanisms.hysteresis import Hysteresis
from twin.mechanisms.mechanism import Mechanism
from twin.mechanisms.microslip import Microslip
from twin.model.amplitudes import Effect
from twin.model.linear import LinearModel
from twin.model.nonlinear import NonlinearElement

Array = NDArray[np.float64]

DIGITS = 9
"""Digits of a port's direction that make it another line: rounding leaves more."""


@dataclass(frozen=True)
class Held:
    """What a model holds beyond its linear equations.

    Attributes:
        mechanisms: those that matter, with the model's own values, in the order of their effect.
        notes: a sentence for every element: what it is taken for, or why it does not matter.
    """

    mechanisms: tuple[Mechanism, ...]
    notes: tuple[str, ...]


def as_mechanism(element: NonlinearElement) -> Mechanism | None:
    """Return an element as the vocabulary has it, or None where it does not."""
    if not element.mechanism or not element.port:
        return None
    data = {"mechanism": element.mechanism, "location": element.port, "values": element.values}
    return from_json(data)


def gathered(
    elements: Iterable[NonlinearElement], model: LinearModel
) -> tuple[NonlinearElement, ...]:
    """Return the elements, springs that yield one after the other along one line as one of them.

    Args:
        elements: of a structure, or what an exported twin has of a law with many sliders.
        model: whose ports say which lines are one.
    """
    out, sliders = list[NonlinearElement](), dict[bytes, list[NonlinearElement]]()
    for element in elements:
        if element.mechanism == Hysteresis.name and element.port in model.ports:
            sliders.setdefault(line_of(model, element.port), []).append(element)
        else:
            out.append(element)
    for group in sliders.values():
        each = [(e.values["stiffness"], e.values["yield_force"]) for e in group]
        one = Microslip.of_sliders(group[0].port, [(k, force / k) for k, force in each])
        out += [_together(one, group)] if one is not None else group
    return tuple(out)


def line_of(model: LinearModel, port: str) -> bytes:
    """Return what ports along one line, whichever way they count, have in common."""
    row = model.port(port)
    return bytes((np.round(row / row[np.argmax(np.abs(row))], DIGITS) + 0.0).tobytes())


def _together(slip: Microslip, group: Sequence[NonlinearElement]) -> NonlinearElement:
    """Return sliders as one element, which slips as a mechanism does."""

    def law(drift: Array, rate: Array) -> Array:
        forces = [element.law(drift, rate) for element in group if element.law is not None]
        return np.sum(forces, axis=0)

    values = slip.as_json()["values"]
    words = (
        f"{len(group)} springs of together {sum(e.values['stiffness'] for e in group):.4g} "
        "that yield one after the other"
    )
    first, last = group[0].element, group[-1].element.split(" ")[-1]
    return NonlinearElement(f"{first} to {last}", slip.place, slip.name, values, words, law)


def mechanisms_of(elements: Iterable[NonlinearElement]) -> tuple[Mechanism, ...]:
    """Return those elements that the vocabulary has, as mechanisms with the model's values."""
    found = (as_mechanism(element) for element in elements)
    return tuple(mechanism for mechanism in found if mechanism is not None)


def held(effects: Sequence[Effect], allowed: float, source: str) -> Held:
    """Return which elements are mechanisms of the base, and which do not matter.

    Args:
        effects: of every element in a test (``twin.model.amplitudes.effects``), the largest over
            all tests.
        allowed: share of an output's RMS that may be changed without a word in the model.
        source: the model's name, for messages.

    Raises:
        ModelError: an element that matters, or whose effect has no number, and that the vocabulary
            does not have; the message names it.
    """
    mechanisms, notes = [], []
    for effect in effects:
        element = effect.element
        if not np.isnan(effect.share) and effect.share <= allowed:
            notes.append(f"{effect}: left aside")
            continue
        mechanism = as_mechanism(element)
        if mechanism is None:
            raise ModelError(
                f"{source}: {effect}; no mechanism of the vocabulary is that, so the model cannot "
                "stand for it: take the element out, or test so gently that it does not matter"
            )
        mechanisms.append(mechanism)
        notes.append(f"{effect}: taken as {mechanism.name} at {mechanism.place}, in the model")
    return Held(tuple(mechanisms), tuple(notes))
