"""The twin's own parameters as findings: one beside what was found, or several at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from twin.diagnosis.base import bent, storey_values
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.refining import refined
from twin.diagnosis.stage import DECISIVE
from twin.mechanisms.mass import Mass
from twin.mechanisms.mechanism import Mechanism
from twin.mechanisms.p_delta import PDelta
from twin.mechanisms.stiffness import Stiffness

LOOSE = 50.0
"""How much wider the tolerances are where the parameters are freed."""

LIKELY_FACTOR = 1.2
"""Share of the weight that acts in a storey of clamped beams."""


def several(
    bench: Bench, nothing: Fit, hopeless: Callable[[Fit], bool] = lambda loose: False
) -> Fit | None:
    """Return the fit in which those masses, stiffnesses and dampings are free that need to be.

    All are freed at once; then whatever the Bayesian information criterion can do without goes back
    to its tolerance, one after the other.

    Args:
        bench: model and trials.
        nothing: the fit within the tolerances.
        hopeless: whether the fit with all of them free, which no selection of them beats, is not
            good enough to go on.
    """
    base = nothing.hypothesis
    wide = replace(base, tolerance=tuple(LOOSE * t for t in base.tolerance))
    try:
        loose = refined(bench, [wide], nothing.slack, nothing.starts, rounds=4)
    except np.linalg.LinAlgError:
        return None
    if hopeless(loose):
        return None
    free = tuple(m for m in loose.hypothesis.base if not is_floor_dashpot(m))
    level = tuple(m.with_values({"change": 0.0}) for m in base.base)
    begun = replace(loose, hypothesis=replace(base, base=level))
    current = _fit(bench, begun, free)
    while current is not None and len(current.hypothesis.found) > 1:
        without = [
            f
            for i in range(len(current.hypothesis.found))
            if (f := _fit(bench, current, _less(current.hypothesis.found, i))) is not None
        ]
        best = min(without, key=lambda f: f.bic, default=None)
        if best is None or best.bic > current.bic:
            break
        current = best
    return current


def promoted(bench: Bench, current: Fit, needed: float = 0.0) -> Fit | None:
    """Return the fit with the parameter that is furthest beyond its tolerance as a finding.

    Args:
        bench: model and trials.
        current: the fit of what was found.
        needed: by which the BIC must be worse without that parameter: no model of what was found is
            exact, and beside it one is bent a little for nothing.

    Returns:
        None where none is far off, where its prior does not ask for it, or where less is lost.
    """
    whole = current.hypothesis
    off = [i for i in bent(whole) if not is_floor_dashpot(whole.base[i])]
    if not whole.found or not off:
        return None
    one = [off[0], *_alike(bench, whole, off[0])]
    change = sum(whole.base[i].values["change"] for i in one)
    own = whole.base[off[0]].with_values({"change": change})
    kept = [i for i in range(len(whole.base)) if i not in one]
    held = replace(
        whole,
        base=tuple(whole.base[i] for i in kept),
        tolerance=tuple(whole.tolerance[i] for i in kept),
    )
    base = tuple(
        m.with_values({"change": 0.0}) if i in one else m for i, m in enumerate(whole.base)
    )
    try:
        hypothesis = replace(whole, base=base).including(own)
        found = refined(bench, [hypothesis], current.slack, current.starts, rounds=2)
        if found.bic > current.bic - DECISIVE:
            return None
        if needed:
            without = refined(bench, [held], current.slack, rounds=2)
            if without.bic < found.bic + needed:
                return None
    except np.linalg.LinAlgError:
        return None
    return found


def _alike(bench: Bench, whole: Hypothesis, index: int) -> list[int]:
    """Return which of the base's dashpots is the same: the lowest floor's is its storey's."""
    own = whole.base[index]
    if (own.name, own.place) != ("damping", "storey1") or "ground" in bench.model.coordinates:
        return []
    return [i for i, m in enumerate(whole.base) if is_floor_dashpot(m) and m.place == "floor1"]


def straightens(other: Fit, own: Fit) -> bool:
    """Return whether in another fit the parameter that was found last is within its tolerance."""
    last = own.hypothesis.found[-1]
    base = other.hypothesis.base
    return all((type(base[i]), base[i].place) != (type(last), last.place)
               for i in bent(other.hypothesis))  # fmt: skip


def is_floor_dashpot(mechanism: Mechanism) -> bool:
    """Return whether a base parameter only stands for damping that is no chain of storeys'."""
    return mechanism.name == "damping" and mechanism.place.startswith("floor")


def _less(found: tuple[Mechanism, ...], index: int) -> tuple[Mechanism, ...]:
    return tuple(m for i, m in enumerate(found) if i != index)


def _fit(bench: Bench, start: Fit, found: tuple[Mechanism, ...]) -> Fit | None:
    bare = replace(start.hypothesis, found=())
    sized = tuple(_nudged(bench, m) for m in found)
    try:
        return refined(bench, [bare.including(*sized)], start.slack, start.starts, rounds=4)
    except np.linalg.LinAlgError:
        return None


def _nudged(bench: Bench, mechanism: Mechanism) -> Mechanism:
    """Give a change that is zero a size, from which a fit takes its steps."""
    model = bench.model
    if mechanism.name in ("stiffness", "damping"):
        matrix = model.K if mechanism.name == "stiffness" else model.R
        scale = storey_values(model, matrix)[mechanism.place]
    else:
        index = model.coordinates.index(mechanism.place)
        scale = float(model.M[index, index])
    change = mechanism.values["change"]
    least = 0.01 * scale
    return mechanism.with_values({"change": change if abs(change) > least else least})


def gravity_instead(bench: Bench, current: Fit, heights: Mapping[str, float]) -> list[Fit]:
    """Return fits in which P-Delta takes the place of each storey stiffness that was lost."""
    out = []
    for index, mechanism in enumerate(current.hypothesis.found):
        if not isinstance(mechanism, Stiffness) or mechanism.change >= 0:
            continue
        other = PDelta(mechanism.place, LIKELY_FACTOR, heights.get(mechanism.place, 1.0))
        found = list(current.hypothesis.found)
        found[index] = other
        hypothesis = replace(current.hypothesis, found=tuple(found))
        try:
            out.append(refined(bench, [hypothesis], current.slack, current.starts, rounds=4))
        except np.linalg.LinAlgError:
            continue
    return out


def is_parameter(mechanism: Mechanism) -> bool:
    """Return whether a finding is a change of the twin's own masses, stiffnesses or dampings."""
    return isinstance(mechanism, (Mass, Stiffness)) or mechanism.name == "damping"
