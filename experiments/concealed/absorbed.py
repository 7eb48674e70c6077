"""Effects that a calibration takes up: weak, most of them read as another mass or damping.

The strength is set so that free masses, stiffnesses and dampings explain most of what the effect
does to the recordings, and leave as many nats as were drawn: enough to tell in principle, too few
to see in a fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .columns import change, columns, frame
from .concealed import Concealed
from .distinct import evidence
from .likelihood import Left, Likelihood, nats
from .mechanisms import Mechanism, build
from .motions import Run
from .plans import log_uniform
from .rehearsal import Rehearsal
from .strengths import draw
from .tables import Combination

LEFT_NATS = (25.0, 2500.0)
"""What the calibration leaves, drawn evenly in the logarithm."""

ABSORBED = 0.35
"""Share of the effect's nats that the calibration takes up, at least."""

NEAR = 0.3
"""The nats come as close as this to what was drawn, in the logarithm."""

ROUNDS = 4
TRIES = 3

SCALED = {
    "coulomb_friction": ("force",), "quadratic_drag": ("coefficient",), "appendage": ("mass",),
    "clearance": ("stiffness",), "hysteresis": ("stiffness", "yield_force"),
    "stiffness_drift": ("rate",), "sensor_gain": ("gain",), "sensor_delay": ("delay",),
    "base_compliance": ("stiffness", "damping"),
}  # fmt: skip
"""The parameters in which each effect is proportional, for small ones, to its strength."""


def draw_one(
    rng: np.random.Generator, combination: Combination, rehearsal: Rehearsal
) -> Concealed | None:
    """Draw one effect that leaves a calibration few nats."""
    likelihood = Likelihood(rehearsal)
    taken = Left(frame(likelihood, rehearsal.healthy))
    for _ in range(TRIES):
        tried = draw(rng, *combination[0], rehearsal.rig, rehearsal.scale)
        wanted = log_uniform(rng, *LEFT_NATS)
        # a weak effect acts on the healthy motion, so its strength is known before it is run
        weak = columns(likelihood, tried, rehearsal.healthy)
        left = nats(taken.of(weak))
        if left > (1 - ABSORBED) * nats(weak):
            continue
        found = _set(likelihood, taken, scaled(tried, np.sqrt(wanted / left)), wanted)
        if found is not None:
            return found
    return None


def _set(likelihood: Likelihood, taken: Left, tried: Mechanism, wanted: float) -> Concealed | None:
    """Return the mechanism with the strength that leaves the nats wanted, if there is one."""
    rehearsal = likelihood.rehearsal
    for _ in range(ROUNDS):
        runs = rehearsal.moved([tried])
        if not rehearsal.physical(runs):
            return None
        whole, left = weighed(likelihood, taken, tried, runs)
        share = 1 - left / whole
        if abs(np.log(left / wanted)) < NEAR and left > LEFT_NATS[0] and share > ABSORBED:
            found = (("left_nats", left), ("absorbed_share", share))
            return Concealed((tried,), rehearsal.effect([tried], runs), found)
        tried = scaled(tried, np.clip(np.sqrt(wanted / left), 0.1, 10.0))
    return None


def scaled(m: Mechanism, by: float) -> Mechanism:
    """Return a mechanism whose effect, if it is weak, is larger by a factor."""
    parameters, factor = dict(m.parameters), float(by)
    for name in SCALED[m.name]:
        if name == "gain":
            parameters[name] = 1 + (parameters[name] - 1) * factor
        else:
            parameters[name] *= factor if m.name != "base_compliance" else 1 / factor
    return replace(m, parameters=tuple(parameters.items()))


def weighed(
    likelihood: Likelihood, taken: Left, m: Mechanism, runs: Sequence[Run]
) -> tuple[float, float]:
    """Return the nats of an effect's change, and of what a calibration leaves of it."""
    whole = change(likelihood, [m], runs)
    if m.name == "base_compliance":
        r, chain = likelihood.rehearsal, likelihood.rehearsal.chain
        return nats(whole), evidence(r.rig, build(r.rig, m), r.tests, chain.fine, chain.noise)
    return nats(whole), nats(taken.of(whole))
