"""Where something is missing: evidence for a latent force entering at one place at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twin.diagnosis.fitting import log_likelihood
from twin.diagnosis.plant import place_vector
from twin.diagnosis.scene import Scene

LEVELS = (1e-3, 3e-3, 1e-2, 3e-2, 0.1)
"""RMS of the latent force that are tried, as shares of the inertia forces."""


def locate(scene: Scene, levels: Sequence[float] = LEVELS) -> dict[str, float]:
    """Return for every place how much a latent force there raises the log likelihood.

    White force noise enters at one place at a time (a storey: a pair), at its best level.
    """
    bench, fit0 = scene.bench, scene.fit
    model = bench.model
    floors = [c for c in model.coordinates if c.startswith("floor")]
    places = [c.replace("floor", "storey") for c in floors] + list(model.coordinates)
    plants = [row[0] for row in bench._plants([fit0.hypothesis])]
    out = {}
    reference = None
    for place in [None, *places]:
        values = []
        for level in levels if place else (0.0,):
            gains = []
            try:
                for trial, plant in zip(bench.trials, plants, strict=True):
                    scale = float(np.max(bench.force_scale(trial, plant)))
                    inner = plant.plant.model
                    latent = level * scale * place_vector(inner, place) if place else None
                    gains.append(bench.gain(trial, plant, 1e-5, latent))
            except np.linalg.LinAlgError:
                values.append(-np.inf)
                continue
            rows = bench.innovations([fit0.hypothesis], gains, fit0.starts)
            values.append(log_likelihood([row[0] for row in rows]))
        if place is None:
            reference = values[0]
        else:
            gained = max(values) - float(reference or 0.0)
            out[place] = gained if np.isfinite(gained) else 0.0
    return out
