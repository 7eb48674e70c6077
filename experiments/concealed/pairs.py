"""Two effects at once, one masking the other, each of which the recordings demand.

With one of the two known in its place and its parameters free, and all masses, stiffnesses and
dampings free besides, what the other one does must still be left by so many nats.
"""

from __future__ import annotations

import numpy as np

from .columns import change, frame, tangent
from .concealed import Concealed
from .likelihood import Left, Likelihood, nats
from .rehearsal import Rehearsal
from .strengths import draw
from .tables import Combination

APART_NATS = 25.0
"""The pair is by so much likelier than either alone with any frame."""

VISIBLE = 3.0
"""Each, taken away, changes the outputs of a training recording by so many times noise."""

CHANGES_FRAME = ("mass", "stiffness", "damping")
TRIES = 12


def draw_two(
    rng: np.random.Generator, combination: Combination, rehearsal: Rehearsal
) -> Concealed | None:
    """Draw two effects that both show."""
    likelihood = Likelihood(rehearsal)
    for _ in range(TRIES):
        effects = tuple(draw(rng, *pair, rehearsal.rig, rehearsal.scale) for pair in combination)
        runs = rehearsal.moved(effects)
        if not rehearsal.physical(runs):
            continue
        given = rehearsal.given(effects, runs)
        found: list[tuple[str, float]] = []
        whole, base = change(likelihood, effects, runs), frame(likelihood, runs)
        each = {m: tangent(likelihood, m, runs) for m in effects}
        both = nats(Left([*each[effects[0]], *each[effects[1]], *base]).of(whole))
        for one, other in (effects, effects[::-1]):
            # a change of the frame is nothing beside a free frame: it is weighed without
            free = [] if one.name in CHANGES_FRAME else base
            left = nats(Left([*each[other], *free]).of(whole)) - both
            found.append((f"nats_of_{one.name}", left))
            alone = rehearsal.given((other,), rehearsal.moved((other,)))
            shift = max(
                np.sqrt(np.sum((a - b) ** 2) / np.sum(a**2))
                for a, b in zip(given, alone, strict=True)
            )
            found.append((f"change_over_noise_of_{one.name}", float(shift / rehearsal.chain.noise)))
        enough = [v > (APART_NATS if k.startswith("nats") else VISIBLE) for k, v in found]
        if all(enough):
            return Concealed(effects, rehearsal.effect(effects, runs), tuple(found))
    return None
