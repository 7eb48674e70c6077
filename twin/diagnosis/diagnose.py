"""The whole diagnosis: calibrate, detect, locate, recognise, confirm, on one screen."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.base import DAMPING_TOLERANCE, TOLERANCE, base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.detection import detect
from twin.diagnosis.fitting import Fit, fit
from twin.diagnosis.judging import advice, felt_alike, findings_of, verdict_of
from twin.diagnosis.pictures import force_pictures
from twin.diagnosis.prepare import prepare
from twin.diagnosis.result import (
    Diagnosis,
    Finding,
    Verdict,
)
from twin.diagnosis.rig import heights_of, twin_with
from twin.diagnosis.search import Found, search
from twin.diagnosis.shown import Shown
from twin.diagnosis.start import identified
from twin.model import Twin
from twin.recording import Recording

Array = NDArray[np.float64]

LOOSE = 50.0
"""How much wider the tolerances are for the best twin without new physics."""


@dataclass
class _Clock:
    """Tells what is being done, and keeps how long each step took."""

    tell: Callable[[str], None]
    steps: dict[str, float] = field(default_factory=dict)
    began: float = field(default_factory=time.perf_counter)
    current: str = ""
    since: float = 0.0

    def __call__(self, step: str) -> None:
        self.stop()
        self.current, self.since = step, time.perf_counter()
        self.tell(step)

    def stop(self) -> None:
        if self.current:
            spent = time.perf_counter() - self.since
            self.steps[self.current] = self.steps.get(self.current, 0.0) + spent
        self.current = ""


def diagnose(
    twin: Twin,
    train: Sequence[Recording],
    test: Sequence[Recording],
    tolerance: float = TOLERANCE,
    damping_tolerance: float = DAMPING_TOLERANCE,
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
    unknown: bool = False,
    seed: int = 0,
    tell: Callable[[str], None] = lambda message: None,
) -> Diagnosis:
    """Say where recordings and twin differ, what physics was left out, and show the twin with it.

    Args:
        twin: the model as it stands.
        train: recordings to explain.
        test: recordings on which the result is shown; nothing before that reads them.
        tolerance: standard deviation of masses and stiffnesses about the model's, as a share.
        damping_tolerance: the same for the dampings.
        added_mass: source of a recording -> place -> mass bolted on for it [kg].
        unknown: the model's numbers are not known: masses, dampings and stiffnesses are first
            identified from the gentlest recording's spectra, and that twin is diagnosed.
        seed: of the draws for the noise floor.
        tell: is told each step.

    Raises:
        RecordingError: recordings that cannot be used (``prepare``).
        ModelError: a model that cannot be.
    """
    clock = _Clock(tell)
    clock("reading the model")
    ready = prepare(twin, train, test, added_mass)
    if unknown:
        clock("identifying the model's numbers")
        wide = base_hypothesis(ready.train.model, 1.0, 1.0)
        twin = twin_with(twin, identified(ready.train, wide).base)
        ready = prepare(twin, train, test, added_mass)
        tolerance, damping_tolerance = max(tolerance, 0.05), max(damping_tolerance, 0.5)
    base = base_hypothesis(ready.train.model, tolerance, damping_tolerance)
    found = search(ready.train, base, heights_of(ready.twin), tell=clock)
    clock("judging the explanations")
    findings, alternatives = findings_of(found)
    verdict = verdict_of(findings)
    calibrated = _calibrated(found, verdict)
    detection = detect(found.bench, found.nothing)
    clock("simulating the recordings")
    shown = Shown(ready, found, calibrated, seed)
    fits, fits_ahead, traces = shown.fits()
    notes = ready.notes + _notes(findings, found.bench) + felt_alike(findings, alternatives)
    notes += shown.notes()
    clock("drawing the missing force")
    places = _places(found, findings)
    # with the explained twin's own masses and stiffnesses: those of the calibrated one are bent
    straight = replace(found.best.hypothesis, found=())
    plain = replace(found.nothing, hypothesis=straight, unknowns=straight.unknowns())
    pictures = force_pictures(found.bench, plain, places, findings)
    clock.stop()
    stage = found.stages[0]
    return Diagnosis(
        verdict,
        findings,
        alternatives,
        _calibration(calibrated),
        fits,
        fits_ahead,
        dict(stage.where),
        detection,
        tuple((*c.label, c.gain) for c in stage.candidates),
        pictures,
        traces,
        shown.twins["nominal"],
        shown.twins["calibrated"],
        shown.twins["explained"],
        next_experiment=advice(found, ready.twin.source, seed),
        notes=notes,
        seconds=time.perf_counter() - clock.began,
        steps=dict(clock.steps),
    )


def _calibrated(found: Found, verdict: Verdict) -> Fit:
    """Return the best twin without new physics: its own parameters, freed from tolerances."""
    if verdict == "consistent":
        return found.best
    if verdict == "parameter" and all(
        f.verdict == "parameter" for f in found.best.hypothesis.found
    ):
        return found.best
    base = found.nothing.hypothesis
    loose = replace(base, tolerance=tuple(LOOSE * t for t in base.tolerance))
    return fit(found.bench, loose, found.nothing.slack, found.nothing.starts)


def _calibration(calibrated: Fit) -> tuple[Finding, ...]:
    """Return the base's deviations as findings of probability one."""
    out = []
    for index, mechanism in enumerate(calibrated.hypothesis.base):
        std = {
            u.name: float(s)
            for u, s in zip(calibrated.unknowns, calibrated.std, strict=True)
            if u.index == index
        }
        out.append(Finding(mechanism, std, 1.0))
    return tuple(out)


def _places(found: Found, findings: Sequence[Finding]) -> list[str]:
    """Return the storeys and floors to draw the missing force at, guilty ones first."""
    floors = [c for c in found.bench.model.coordinates if c.startswith("floor")]
    storeys = [c.replace("floor", "storey") for c in floors]
    guilty = [f.location for f in findings if f.location in (*storeys, *floors)]
    ranked = sorted(storeys, key=lambda s: -found.stages[0].where.get(s, 0.0))
    return list(dict.fromkeys([*guilty, *ranked]))


def _notes(findings: Sequence[Finding], bench: Bench) -> tuple[str, ...]:
    between = {
        "band_limited": "the forces are taken as band-limited between the samples",
        "linear": "the forces are taken as straight lines between the samples",
        "held": "the forces are taken as held from sample to sample",
    }[bench.between]
    lacking = [f"{f.mechanism.name}: {f.mechanism.mjcf}" for f in findings if f.mechanism.mjcf]
    return (between, *lacking)
