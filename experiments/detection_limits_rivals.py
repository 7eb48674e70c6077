"""Which other name comes nearest to an effect at its limit, and how far the two are apart.

The limit asks that the true model beats the frame without an effect. To be named right it must
beat the other candidates, too, each with the strength and the frame that suit it best.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import ndtri

from experiments.concealed.columns import change, tangent
from experiments.concealed.likelihood import Left, nats
from experiments.concealed.mechanisms import places
from experiments.concealed.rig import Array
from experiments.concealed.strengths import draw
from experiments.detection_limits_theory import FOUND, PAIRS, Bench

SHAPES = 6
"""Gaps, corners and frequencies of a rival that are tried: the campaign's, drawn so many times."""

IN_FRAME = ("mass", "stiffness", "damping")
NEVER_WEAK = ("sensor_polarity", "sensor_swap", "unmeasured_force")
"""A rival of these names has no strength that could be small, or no shape of its own."""

APART_NATS = 2 * float(ndtri(FOUND)) ** 2
"""The true model is likelier than one rival in nine of ten cases when it is so on average."""


def nearest(
    bench: Bench, rng: np.random.Generator, shapes: int = SHAPES
) -> dict[str, tuple[str, float]]:
    """Return for every pair its nearest rival at the limit and the nats that tell them apart."""
    healthy, likelihood = bench.rehearsal.healthy, bench.likelihood
    vectors = {}
    for pair in PAIRS:
        effect = bench.effect(pair, bench.limit(pair))
        runs = healthy if effect.in_sensor else bench.rehearsal.moved([effect])
        vectors[pair.title] = bench.taken.of(change(likelihood, [effect], runs))
    found = {title: ("-", nats(vector)) for title, vector in vectors.items()}
    for rival, columns in _rivals(bench, rng, shapes):
        left = Left([bench.taken.of(column) for column in columns])
        for title, vector in vectors.items():
            apart = nats(left.of(vector))
            if rival != title and apart < found[title][1]:
                found[title] = rival, apart
    return found


def _rivals(
    bench: Bench, rng: np.random.Generator, shapes: int
) -> Iterator[tuple[str, list[Array]]]:
    """Give every rival with the columns of its strength and of small changes of its shape."""
    r = bench.rehearsal
    for name, place in places(bench.rig.storeys):
        if name in IN_FRAME or name in NEVER_WEAK:
            continue
        for _ in range(shapes):
            rival = draw(rng, name, place, bench.rig, r.scale)
            columns = tangent(bench.likelihood, rival, r.healthy)
            yield f"{name} {place}", columns


def names_at(apart: float) -> float:
    """Return the severity over the limit at which nine of ten effects beat the nearest rival.

    Args:
        apart: what tells them apart at the limit [nats]; it goes with the severity's square.
    """
    return float(np.sqrt(max(1.0, APART_NATS / max(apart, 1e-9))))
