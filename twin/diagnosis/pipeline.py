"""The whole diagnosis from top to bottom: prepare, search, judge, predict, say what to do next."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis import drawing
from twin.diagnosis.beginning import attempted
from twin.diagnosis.between import choose, filter_in_words, in_words, motion_in_words
from twin.diagnosis.by_simulation import loosened, search_by_simulation
from twin.diagnosis.comparison import compare
from twin.diagnosis.detection import detect
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.exported import base_mechanisms
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.known import shifts
from twin.diagnosis.next_test import next_test
from twin.diagnosis.offer import offer
from twin.diagnosis.pictures import force_pictures
from twin.diagnosis.predict import predictors
from twin.diagnosis.prepare import DAMPING_TOLERANCE, UNKNOWN, Prepared, hidden_in_words, prepare
from twin.diagnosis.problem import Problem
from twin.diagnosis.read_off import ReadOff
from twin.diagnosis.result import Diagnosis, Finding
from twin.diagnosis.round_numbers import has_round_numbers
from twin.diagnosis.search import Found, search
from twin.diagnosis.valleys import Score
from twin.diagnosis.verdict import Judgement, judge
from twin.diagnosis.wrong_samples import without_wrong
from twin.estimation.fit import fit
from twin.mechanisms.mass import Mass
from twin.mechanisms.sensor_spikes import PASSES
from twin.mechanisms.stiffness import Stiffness
from twin.model import Twin
from twin.recording import Recording

Array = NDArray[np.float64]

LOOSE = 50.0
"""How much wider tolerances are for the best twin without new physics: half of what is there."""


@dataclass
class _Clock:
    """Tells what is being done and for how long, and keeps how long each step took."""

    tell: Callable[[str], None]
    steps: dict[str, float] = field(default_factory=dict)
    began: float = field(default_factory=time.perf_counter)
    current: str = ""
    since: float = 0.0

    def __call__(self, step: str) -> None:
        self.stop()
        self.current, self.since = step, time.perf_counter()
        self.tell(f"{step} ({self.seconds:.0f} s)")

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self.began

    def stop(self) -> None:
        if self.current:
            spent = time.perf_counter() - self.since
            self.steps[self.current] = self.steps.get(self.current, 0.0) + spent
        self.current = ""


def diagnose(
    twin: Twin,
    train: Sequence[Recording],
    test: Sequence[Recording],
    tolerance: float | None = None,
    damping_tolerance: float | None = None,
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
    unknown: bool = False,
    seed: int = 0,
    tell: Callable[[str], None] = lambda message: None,
) -> Diagnosis:
    """Say where recordings and twin differ, what physics was left out, and give the twin with it.

    Args:
        twin: the model as it stands.
        train: recordings to explain.
        test: recordings on which the result is shown; nothing before that reads them.
        tolerance: prior deviation of masses and stiffnesses about the model's, as a share; where
            nothing is said the recordings tell it, from 1 % on.
        damping_tolerance: the same for the dampings; 10 %.
        added_mass: source of a recording -> place -> mass bolted on for it [kg].
        unknown: the model's numbers are not known: any of them may be off by a factor of three.
        seed: of the draws for the noise floor.
        tell: is told each step.

    Raises:
        RecordingError: recordings that cannot be used (``prepare``).
        ModelError: a model that cannot be.
    """
    clock = _Clock(tell)
    clock("reading the model")
    least = UNKNOWN if unknown else 0.0
    loose = max(DAMPING_TOLERANCE if damping_tolerance is None else damping_tolerance, least)
    if unknown:
        tolerance = max(tolerance or 0.0, UNKNOWN)
    ready = prepare(twin, train, test, tolerance, loose, added_mass)
    if tolerance is None and ready.shaken:
        clock("asking how well the numbers are known")
        ready = _as_known(ready, prepare(twin, train, test, UNKNOWN, UNKNOWN, added_mass))
    clock("calibrating the twin")
    if ready.simulated:
        found = search_by_simulation(
            ready.train, ready.test, offer(ready.train, ready.kinds), clock
        )
    else:
        problem, start = choose(ready.train, ready.known)
        found = search(problem, offer(problem, ready.kinds), clock, start)
        found, faults = _without_wrong(found, ready.kinds, clock)
        seen = tuple(hidden_in_words(fault) for fault in faults)
        ready = replace(ready, faults=(*ready.faults, *faults), notes=(*ready.notes, *seen))
    problem = found.best.hypothesis.problem
    clock("judging the explanations")
    beside = predictors(found.best.hypothesis, found.best.fit.z, found.best.fit.averages)
    judged = judge(found, beside, ready.faults)
    calibrated = loosened(found.nothing, UNKNOWN) if ready.simulated else _calibrated(found)
    detection = detect(found.nothing)
    clock("predicting the recordings")
    compared = compare(ready, found.nothing, calibrated, found.best, seed)
    clock("drawing the missing force")
    scores = found.screened[0] if found.screened else ()
    where = _where(scores, problem)
    guilty = [f.location for f in judged.findings if f.location in problem.model.ports]
    ranked = sorted(where, key=lambda place: -where[place])
    pictures = force_pictures(found.best, found.motion, [*guilty, *ranked], judged.findings)
    clock.stop()
    return Diagnosis(
        judged.verdict,
        judged.findings,
        judged.alternatives,
        _calibration(calibrated),
        compared.fit.stating(found.stated),
        compared.fit_ahead,
        where,
        detection,
        tuple((*s.candidate.label, s.gain) for s in scores),
        pictures,
        compared.traces,
        compared.twins["nominal"],
        compared.twins["calibrated"],
        compared.twins["explained"],
        next_experiment=next_test(found, ready.twin.source, seed),
        negligible=judged.negligible,
        notes=_notes(ready, found.best, judged) + compared.notes,
        seconds=clock.seconds,
        steps=dict(clock.steps),
    )


def _without_wrong(
    found: Found, kinds: Mapping[str, str], clock: Callable[[str], None]
) -> tuple[Found, tuple[ReadOff, ...]]:
    """Return what is found without samples that are wrong beside it, if that is likelier."""
    faults: tuple[ReadOff, ...] = ()
    while True:
        hypothesis, fitted = found.best.hypothesis, found.best.fit
        read, spent = list[ReadOff](), 0.0
        for _ in range(PASSES):
            problem, more, cost = without_wrong(hypothesis, fitted.z, fitted.averages)
            other = replace(hypothesis, problem=problem)
            again = attempted(other, fitted.z, near=fitted.averages) if more else None
            if again is None:
                break
            hypothesis, fitted = other, again
            read, spent = [*read, *more], spent + cost
        if not read:
            return found, faults
        clock("leaving out samples that are wrong beside what was found")
        problem, start = choose(hypothesis.problem)
        anew = search(problem, offer(problem, kinds), clock, start)
        if anew.best.log_odds - spent <= found.best.log_odds:
            return found, faults
        found, faults = anew, (*faults, *read)


def _as_known(ready: Prepared, anything: Prepared) -> Prepared:
    """Return a shaken structure as its recordings show that it is known, the user saying nothing.

    Args:
        ready: with numbers that are known well.
        anything: with numbers that may be anything.
    """
    if not has_round_numbers(anything.train):
        return ready
    note = (
        "natural frequencies of the model are off by more than one local effect explains: its "
        "numbers are taken as unknown; --tolerance says it otherwise"
    )
    return replace(anything, notes=(*anything.notes, note))


def _calibrated(found: Found) -> Explanation:
    """Return the best twin without new physics: its own parameters, freed from tolerances."""
    if all(m.verdict == "parameter" for m in found.best.hypothesis.mechanisms):
        return found.best
    own = found.nothing.hypothesis.problem
    free = Hypothesis(
        replace(own, tolerance=min(LOOSE * own.tolerance, UNKNOWN),
                damping_tolerance=min(LOOSE * own.damping_tolerance, UNKNOWN))
    )  # fmt: skip
    z = found.nothing.fit.z.copy()
    pairs = zip(own.base_unknowns, free.problem.base_unknowns, strict=True)
    z[: len(own.base_unknowns)] *= [before.deviation / after.deviation for before, after in pairs]
    loose = fit(free, z)
    return Explanation(free, loose, loose.log_evidence)


def _calibration(calibrated: Explanation) -> tuple[Finding, ...]:
    """Return the deviations of the calibrated twin's parameters from the nominal ones."""
    problem = calibrated.hypothesis.problem
    spread = calibrated.fit.deviations
    out = []
    for mechanism in base_mechanisms(problem, calibrated.fit.z):
        known = {}
        if isinstance(mechanism, Stiffness | Mass):
            known["change"] = spread[f"{mechanism.name} {mechanism.place}"]
        out.append(Finding(mechanism, known, 1.0))
    return tuple(out)


def _where(scores: Sequence[Score], problem: Problem) -> dict[str, float]:
    """Return the greatest gain that the screening promised at each port."""
    out: dict[str, float] = {}
    for score in scores:
        place = score.candidate.label[1]
        if place in problem.model.ports:
            out[place] = max(out.get(place, 0.0), score.gain)
    return out


def _notes(ready: Prepared, best: Explanation, judged: Judgement) -> tuple[str, ...]:
    problem = best.hypothesis.problem
    lacking = [f"{f.mechanism.name}: {f.mechanism.mjcf}" for f in judged.findings
               if f.mechanism.mjcf]  # fmt: skip
    drawn = () if problem.told else (drawing.in_words(problem),)
    inputs = (in_words(problem), *motion_in_words(problem), *filter_in_words(best.hypothesis))
    return (*ready.notes, *inputs, *drawn, *_shifted(best), *lacking, *judged.notes)


def _shifted(best: Explanation) -> tuple[str, ...]:
    """Say which values of what the model holds the recordings put elsewhere."""
    problem = best.hypothesis.problem
    last = len(problem.base_unknowns)
    own = slice(last - len(problem.of_known), last)
    std = np.sqrt(np.maximum(np.diag(best.fit.covariance), 0.0))
    return shifts(problem.known, problem.of_known, best.fit.z[own], std[own])
