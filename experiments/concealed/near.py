"""Effects whose law is nearly that of a name of the vocabulary: as strong as those of ``single``.

The nearest name explains most of the missing force, and not all of it.
"""

from __future__ import annotations

import numpy as np

from .concealed import Concealed
from .mechanisms import NEAREST, Mechanism
from .nearest import explained_share, port_of
from .plans import log_uniform
from .rehearsal import Rehearsal
from .rig import Rig
from .strengths import Motion, of_spring
from .tables import Combination

VISIBLE = 3.0
"""The effect changes the outputs of some training recording by at least this many times noise."""

NEARLY = 0.5
"""Share of the missing force that the nearest name explains at best, at least."""

TRIES = 60


def draw_one(
    rng: np.random.Generator, combination: Combination, rehearsal: Rehearsal
) -> Concealed | None:
    """Draw one effect that changes the recordings by some times their noise."""
    for _ in range(TRIES):
        effect = draw(rng, *combination[0], rehearsal.rig, rehearsal.scale)
        runs = rehearsal.moved([effect])
        shift = rehearsal.effect([effect], runs)
        if not rehearsal.physical(runs) or shift < VISIBLE * rehearsal.chain.noise:
            continue
        whole = [(drive, *run) for drive, run in zip(rehearsal.drives, runs, strict=True)]
        port = port_of(rehearsal.rig, effect, rehearsal.tests, whole)
        if explained_share(effect, port) > NEARLY:
            return Concealed((effect,), shift)
    return None


def draw(rng: np.random.Generator, name: str, place: str, rig: Rig, motion: Motion) -> Mechanism:
    """Draw the strength of an effect: that of its nearest name, and what sets it apart from it."""
    i = int(place[-1]) - 1
    nearest = NEAREST[name]
    values, _ = of_spring(rng, nearest, rig.stiffnesses[i], motion.drift[i], motion.largest[i], 0.0)
    if nearest == "coulomb_friction":
        values = _rubbing(rng, name, values["force"], motion.drift[i], rig.modes[0][0])
    elif name == "damped_bumper":  # a blow at a tenth of a metre per second is 10 to 60 % harder
        values["damping"] = rng.uniform(1.0, 6.0)
    elif name == "hertz_bumper":  # as hard as the linear one where the storey turns back
        values["stiffness"] /= np.sqrt(max(motion.largest[i] - abs(values["gap"]), 1e-4))
    elif name == "power_spring":  # as hard as the cubic one at the middle drift
        values = {"stiffness": values["stiffness"] * motion.drift[i] ** 0.3, "exponent": 1.7}
    elif name == "iwan_slip":  # evenly spread yields, or many that yield early
        values["exponent"] = float(rng.choice([1.0, 2.0, 3.0]))
    return Mechanism(name, place, tuple((k, float(v)) for k, v in values.items()))


def _rubbing(
    rng: np.random.Generator, name: str, force: float, drift: float, omega: float
) -> dict[str, float]:
    """Return the parameters of a friction law.

    Args:
        rng: draws.
        name: of the law.
        force: of dry friction [N].
        drift: middle of the recordings' largest drifts [m].
        omega: lowest natural frequency [rad/s].
    """
    if name == "smooth_friction":
        return {"force": force, "velocity": log_uniform(rng, 5e-5, 1e-3)}
    bend = drift * log_uniform(rng, 0.002, 0.01)  # of the bristles
    if name == "dahl_friction":
        return {"stiffness": force / bend, "force": force}
    fall = {
        "breakaway": force * rng.uniform(1.2, 1.8),
        "velocity": omega * drift * log_uniform(rng, 0.02, 0.2),
    }
    if name == "stribeck_friction":
        return {"force": force, **fall}
    # LuGre's bristles damp by a share of the friction at the rate at which they turn over
    turning = omega * np.sqrt(2 * drift * bend)
    damping = force / turning * rng.uniform(0.05, 0.3)
    return {"stiffness": force / bend, "damping": damping, "force": force, **fall}
