"""EMPS diagnosed: what a slide with mass and viscous friction lacks, beside what is published.

The first half of the recording is explained, the second one shows how well. Both are brought to
50 Hz, two and a half times the bandwidth of the position loop (``emps.FORCE_HZ``): what the motor
and the screw do above it is in no model of a rigid slide.

    python -m experiments.emps_diagnosed --out emps
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np

from experiments.emps import FORCE_HZ, PUBLISHED, arguments
from twin.diagnosis.between import choose
from twin.diagnosis.exported import base_mechanisms
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.offer import offer
from twin.diagnosis.predict import nrmse, placed, predictors
from twin.diagnosis.prepare import UNKNOWN, Prepared, prepare
from twin.diagnosis.search import search
from twin.estimation.fit import fit
from twin.formats import read_recording
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.sensor_offset import SensorOffset
from twin.model import Twin
from twin.recording import Recording
from twin.signals.resampling import resample

RATE_HZ = 2.5 * FORCE_HZ
"""Of what is diagnosed."""

SLOW = 1e-3
"""Rate below which the published friction is smoothed [m/s]: a hundredth of the slide's."""


def halves(whole: Recording) -> tuple[Recording, Recording]:
    """Return the two halves of force and position, thinned out."""
    wanted = whole.select(["force", "position"])
    data = resample(wanted.data, wanted.sampling_hz, RATE_HZ)
    middle = len(data) // 2
    first, second = (
        Recording(RATE_HZ, wanted.channels, part, f"{name}_half.csv")
        for name, part in (("first", data[:middle]), ("second", data[middle:]))
    )
    return first, second


def diagnosed(whole: Recording) -> dict[str, Any]:
    """Return what was found in the first half, and errors on the second, published beside."""
    train, test = halves(whole)
    ready = prepare(Twin.load("drive"), [train], [test], UNKNOWN, UNKNOWN)
    problem, start = choose(ready.train, ready.known)
    best = search(problem, offer(problem, ready.kinds), start=start).best
    h, z = best.hypothesis, best.fit.z
    values = {f"{m.name} {m.place}": m.values for m in h.at(z)}
    values["slide"] = {"mass": 80.0, "viscous": 150.0}
    for change in base_mechanisms(h.problem, z):
        if isinstance(change, Mass):
            values["slide"]["mass"] += change.change
        elif isinstance(change, Damping):
            values["slide"]["viscous"] += change.change
    return {
        "published": PUBLISHED,
        "found": values,
        "deviations": best.fit.deviations,
        "error_on_the_second_half": {
            "found": error(ready, h, z),
            "published": error(ready, *published(h, z)),
        },
    }


def published(found: Hypothesis, z: np.ndarray) -> tuple[Hypothesis, np.ndarray]:
    """Return the published model as a hypothesis: its numbers held, noise levels fitted."""
    laws = (CoulombFriction("slide", PUBLISHED["coulomb"], SLOW),
            SensorOffset("force", PUBLISHED["offset"]))  # fmt: skip
    held = ({"force": (np.log(PUBLISHED["coulomb"]), 1.0), "regular_rate": (np.log(SLOW), 1.0)},
            {"offset": (PUBLISHED["offset"], 1.0)})  # fmt: skip
    h = replace(found, mechanisms=laws, priors=held)
    square = float(found.problem.model.port("slide")[0] ** 2)
    own = {"mass carriage": PUBLISHED["mass"], "damping of mode 1": PUBLISHED["viscous"] * square}
    known = {u.name: float(x) for u, x in zip(found.unknowns, z, strict=True)}
    values = np.zeros(len(h.unknowns))
    for i, u in enumerate(h.unknowns):
        if u.name in own:
            values[i] = (np.log(own[u.name]) - u.mean) / u.deviation
        elif u.role == "noise":
            values[i] = known[u.name]
    free = np.array([u.role == "noise" or u.name.startswith("discrepancy") for u in h.unknowns])
    return h, fit(h, values, free=free).z


def error(ready: Prepared, h: Hypothesis, z: np.ndarray) -> dict[str, float]:
    """Return NRMSE of the free run and two seconds ahead on the second half."""
    beside = predictors(*placed(h, z, replace(ready.test, between=h.problem.between)))
    measured = [predictor.trial.y for predictor in beside]
    return {
        "free_run": nrmse(measured, [predictor.free() for predictor in beside]),
        "ahead": nrmse(measured, [predictor.ahead() for predictor in beside]),
    }


def main() -> None:
    """Run from the command line."""
    given = arguments(__doc__)
    found = diagnosed(read_recording(given.data))
    text = json.dumps(found, indent=1, default=float) + "\n"
    (given.out / "emps_diagnosed.json").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
