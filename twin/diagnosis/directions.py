"""First guesses of which one is another one, only stronger."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twin.mechanisms.mechanism import Mechanism


def nearest(alike: Sequence[tuple[Mechanism, float]], strength: float) -> list[Mechanism]:
    """Return which of several strengths along one direction to follow: the one that is told.

    All where they are of either sign: so far from nothing the direction is another one.
    """
    ratios = np.array([ratio for _, ratio in alike])
    if np.any(ratios < 0):
        return [start for start, _ in alike]
    told = max(strength, float(np.min(ratios)))
    return [alike[int(np.argmin(np.abs(np.log(ratios / told))))][0]]


def directions_of(
    starts: Sequence[Mechanism],
) -> list[tuple[Mechanism, list[tuple[Mechanism, float]]]]:
    """Return first guesses of which none is another one, only stronger.

    Each with all that are: (mechanism, strength as a share of the first one's, either sign).
    """
    out: list[tuple[Mechanism, list[tuple[Mechanism, float]]]] = []
    for start in starts:
        for first, alike in out:
            if (ratio := _stronger(first, start)) is not None:
                alike.append((start, ratio))
                break
        else:
            out.append((start, [(start, 1.0)]))
    return out


def _stronger(first: Mechanism, other: Mechanism) -> float | None:
    """Return by what factor one mechanism is another one's strength, None where it is no such.

    A strength is a multiple of the first parameter, of its distance from one, or a power of it.
    """
    if not first.parameters or first.with_values(other.values) != other:
        return None  # nothing to be stronger, or one of another form
    name = next(iter(first.parameters))
    a, b = first.values[name], other.values[name]
    twice, thrice = (first.scaled(strength).values[name] for strength in (2.0, 3.0))
    ratios = []
    if np.isfinite(twice) and twice != a and np.isclose(thrice - twice, twice - a, rtol=1e-9):
        ratios.append(1 + (b - a) / (twice - a))
    if a > 0 and b > 0 and a != 1 and np.isclose(twice, a**2, rtol=1e-9):
        ratios.append(np.log(b) / np.log(a))
    for ratio in ratios:
        same = first.scaled(ratio).values
        if ratio and all(np.isclose(same[n], v, rtol=1e-9) for n, v in other.values.items()):
            return float(ratio)
    return None
