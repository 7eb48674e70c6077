"""``mujoco.sysid`` on a case: the model's masses, stiffnesses and dampings fitted.

``sysid_peer.py`` says what a careful user has to do. It knows parameters of the model and no
physics that the model lacks: what it can say is which of them is farthest from the model's, in
tolerances of 0.4 % (dampings 10 %), and that it says if it is farther than three. One recording
of every floor that was driven is fitted, from rest to ``SECONDS``, for the time's sake.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import sysid_peer

from twin.diagnosis.beginning import start_of
from twin.diagnosis.exported import in_mujoco, including
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import nrmse, placed, predictors
from twin.diagnosis.prepare import Prepared
from twin.diagnosis.problem import Measured, Problem
from twin.estimation.fit import fit

TOLERANCE, DAMPING_TOLERANCE = 0.15, 1.0
"""Wide: without a word for what is missing, its parameters have to take it up."""
SECONDS, MOST = 8.0, 40
FAR = 3.0
LOST = 1e3
"""NRMSE of a motion that diverges."""


def farthest(usual: Problem, changes: Sequence[sysid_peer.Change]) -> dict[str, str] | None:
    """Return the parameter that left its usual tolerance by most, as mechanism and place."""
    std = {u.name: u.tolerance * u.unit for u in sysid_peer.unknowns(usual)}
    off = [abs(c.change) / std[f"{c.name} {c.place}"] for c in changes]
    most = int(np.argmax(off))
    first = changes[most]
    return {"mechanism": first.name, "location": first.place} if off[most] > FAR else None


def ones_of_each_drive(problem: Problem) -> list[Measured]:
    """Return the beginning of one recording of every combination of inputs that was driven."""
    count = round(SECONDS * problem.sampling_hz)
    kept: dict[tuple[bool, ...], Measured] = {}
    for r in problem.recordings:
        kept.setdefault(tuple(r.driven.tolist()), replace(r, u=r.u[:count], y=r.y[:count]))
    return list(kept.values())


def ahead(ready: Prepared, changes: Sequence[sysid_peer.Change]) -> float:
    """Return the NRMSE two seconds ahead, from states that our predictor estimates.

    Its noise levels are those that make the changed model likeliest.
    """
    changed = replace(ready.train, known=(*ready.train.known, *changes))
    hypothesis = Hypothesis(changed)
    noisy = np.array([unknown.role == "noise" for unknown in hypothesis.unknowns])
    found = fit(hypothesis, start_of(hypothesis), free=noisy)
    beside = predictors(*placed(hypothesis, found.z, ready.test))
    return nrmse([r.y for r in ready.test.recordings], [one.ahead() for one in beside])


def job(ready: Prepared) -> dict[str, Any]:
    usual, recordings = ready.train, ready.test.recordings
    wide = replace(usual, tolerance=TOLERANCE, damping_tolerance=DAMPING_TOLERANCE)
    begin = time.process_time()
    changes, notes = sysid_peer.calibrated(ready.twin, wide, ones_of_each_drive(wide), MOST)
    seconds = time.process_time() - begin
    changed = including(ready.twin, changes)
    runs = [in_mujoco(changed, ready.test, recording) for recording in recordings]
    free = nrmse([recording.y for recording in recordings], runs)
    return {
        "free": free if free < LOST else None,
        "ahead": ahead(ready, changes),
        "at_bound": notes["at_bound"],
        "iterations": notes["iterations"],
        "says": farthest(usual, changes),
        "seconds": round(seconds, 2),
    }
