"""``mujoco.sysid`` on a case: the model's masses, stiffnesses and dampings fitted.

``sysid_peer.py`` says what a careful user has to do. It knows parameters of the model and no
physics that the model lacks: what it can say is which of them is farthest from the model's, in
tolerances of 0.4 % (dampings 10 %), and that it says if it is farther than three. One recording
of every floor that was driven is fitted, from rest to ``SECONDS``, for the time's sake.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import sysid_peer

from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.predict import ahead, nrmse
from twin.diagnosis.prepare import Prepared
from twin.diagnosis.rig import free_runs, twin_with
from twin.diagnosis.trials import Trial
from twin.mechanisms.mechanism import StructuralChange

TOLERANCE, DAMPING_TOLERANCE = 0.15, 1.0
"""Wide: without a word for what is missing, its parameters have to take it up."""
SECONDS, MOST = 8.0, 40
FAR = 3.0


def farthest(bench: Bench, changes: list[StructuralChange]) -> dict[str, str] | None:
    """Return the parameter that left its tolerance by most, as mechanism and place."""
    usual = base_hypothesis(bench.model)
    std = {(m.name, m.place): s for m, s in zip(usual.base, usual.tolerance, strict=True)}
    off = {(c.name, c.place): abs(c.values["change"]) / std[c.name, c.place] for c in changes}
    name, place = max(off, key=lambda key: off[key])
    return {"mechanism": name, "location": place} if off[name, place] > FAR else None


def shortened(trial: Trial) -> Trial:
    count = min(trial.samples, round(SECONDS * trial.sampling_hz))
    return replace(trial, u=trial.u[:count], y=trial.y[:count])


def job(ready: Prepared) -> dict[str, Any]:
    trials: dict[tuple[bool, ...], Trial] = {}
    for trial in ready.train.trials:
        trials.setdefault(tuple((trial.u != 0).any(axis=0)), shortened(trial))
    bench: Bench = replace(ready.train, trials=tuple(trials.values()))
    begin = time.process_time()
    changes, notes = sysid_peer.calibrated(
        ready.twin, bench, TOLERANCE, DAMPING_TOLERANCE, MOST
    )  # fmt: skip
    seconds = time.process_time() - begin
    base = base_hypothesis(bench.model, TOLERANCE, DAMPING_TOLERANCE)
    fitted = replace(base, base=tuple(changes), tolerance=base.tolerance[: len(changes)])
    free = free_runs(twin_with(ready.twin, changes), ready.test, workers=1)
    finite = nrmse(ready.test.trials, free)
    slack = 0.02
    return {
        "free": finite if finite < 1e3 else None,
        "ahead": nrmse(ready.test.trials, ahead(ready.test, fitted, slack)),
        "at_bound": notes["at_bound"],
        "iterations": notes["iterations"],
        "says": farthest(bench, changes),
        "seconds": round(seconds, 2),
    }
