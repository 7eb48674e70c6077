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
from twin.diagnosis.evidence import probabilities
from twin.diagnosis.fitting import Fit, fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.pictures import force_pictures
from twin.diagnosis.plant import laws_of
from twin.diagnosis.predict import ahead, from_rest, noise_floors, nrmse, strength_of
from twin.diagnosis.prepare import Prepared, prepare
from twin.diagnosis.refining import refined
from twin.diagnosis.result import Diagnosis, Errors, Finding, Fits, Trace, Verdict
from twin.diagnosis.rig import free_runs, heights_of, twin_with
from twin.diagnosis.search import Found, search
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
        seed: of the draws for the noise floor.
        tell: is told each step.

    Raises:
        RecordingError: recordings that cannot be used (``prepare``).
        ModelError: a model that cannot be.
    """
    clock = _Clock(tell)
    clock("reading the model")
    ready = prepare(twin, train, test, added_mass)
    base = base_hypothesis(ready.train.model, tolerance, damping_tolerance)
    found = search(ready.train, base, heights_of(ready.twin), tell=clock)
    clock("judging the explanations")
    findings, alternatives = _findings(found)
    verdict = _verdict(findings)
    calibrated = _calibrated(found, verdict)
    detection = detect(found.bench, found.nothing)
    clock("simulating the recordings")
    shown = _Shown(ready, found, calibrated, seed)
    fits, fits_ahead, traces = shown.fits()
    notes = ready.notes + _notes(findings, found.bench) + shown.notes()
    clock("drawing the missing force")
    places = _places(found, findings)
    pictures = force_pictures(found.bench, found.nothing, places, findings)
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
        next_experiment=None,
        notes=notes,
        seconds=time.perf_counter() - clock.began,
        steps=dict(clock.steps),
    )


def _findings(found: Found) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings in the order of what each explains, and what else could be the first."""
    best = found.best
    count = len(best.hypothesis.found)
    out, alternatives = [], []
    if found.named is not None:
        chances = probabilities([best, found.named])
        law = Finding(best.hypothesis.found[0], _std(best, 0), chances[0])
        for number, mechanism in enumerate(found.named.hypothesis.found):
            delta = float(found.named.bic - best.bic)
            alternatives.append(Finding(mechanism, _std(found.named, number), chances[1], delta))
        return (law,), tuple(alternatives)
    strengths = strength_of(found.bench, best.hypothesis, best.slack)
    for number in range(count):
        stage = found.stages[number]
        chances = probabilities(stage.fits)
        mine = best.hypothesis.found[number]
        if number in strengths:
            mine = mine.with_values({"rms": strengths[number]})
        out.append((_explained(found, number), Finding(mine, _std(best, number), chances[0])))
        for other, chance in zip(stage.fits[1:], chances[1:], strict=True):
            if len(other.hypothesis.found) == number + 1:
                delta = float(other.bic - stage.fits[0].bic)
                mechanism = other.hypothesis.found[number]
                alternatives.append(Finding(mechanism, _std(other, number), chance, delta))
    out.sort(key=lambda pair: -pair[0])
    alternatives.sort(key=lambda f: -f.probability)
    return tuple(f for _, f in out), tuple(alternatives)


def _explained(found: Found, number: int) -> float:
    """Return what is lost without one of the findings, the others kept as they are."""
    if len(found.best.hypothesis.found) == 1:
        return 1.0
    rest = tuple(m for i, m in enumerate(found.best.hypothesis.found) if i != number)
    hypothesis = replace(found.best.hypothesis, found=rest)
    without = refined(found.bench, [hypothesis], found.nothing.slack, rounds=2)
    return without.bic - found.best.bic


def _std(best: Fit, number: int) -> dict[str, float]:
    """Return the standard deviations of a found mechanism's parameters, in their units."""
    index = len(best.hypothesis.base) + number
    mechanism = best.hypothesis.mechanisms[index]
    out = {}
    for unknown, std in zip(best.unknowns, best.std, strict=True):
        if unknown.index == index:
            value = abs(mechanism.values[unknown.name])
            out[unknown.name] = float(std * value if unknown.log else std)
    return out


def _verdict(findings: Sequence[Finding]) -> Verdict:
    return findings[0].mechanism.verdict if findings else "consistent"


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


class _Shown:
    """The three twins on all recordings: free runs in MuJoCo, and two seconds ahead."""

    def __init__(self, ready: Prepared, found: Found, calibrated: Fit, seed: int) -> None:
        self.found, self.calibrated, self.seed = found, calibrated, seed
        self.benches = {
            "train": found.bench,
            "test": replace(ready.test, between=found.bench.between),
        }
        bare = replace(found.nothing.hypothesis, base=(), tolerance=())
        self.hypotheses: dict[str, tuple[Hypothesis, float]] = {
            "nominal": (bare, found.nothing.slack),
            "calibrated": (calibrated.hypothesis, calibrated.slack),
            "explained": (found.best.hypothesis, found.best.slack),
        }
        self.approximate = any(law.approximate for law in laws_of(found.best.hypothesis.found))
        self.in_mujoco: dict[str, float] = {}
        self.twins = {
            name: twin_with(ready.twin, h.mechanisms) for name, (h, _) in self.hypotheses.items()
        }

    def notes(self) -> tuple[str, ...]:
        """Say where the MuJoCo model only comes near the law that was fitted."""
        if not self.approximate:
            return ()
        reached = ", ".join(f"{v:.3g} ({role})" for role, v in self.in_mujoco.items())
        return (
            "the free runs of the explained twin are those of the fitted law; the MJCF's native "
            f"elements, which only come near it, reach an error of {reached}",
        )

    def fits(self) -> tuple[Fits, Fits, tuple[Trace, ...]]:
        """Return free-run errors, two-second errors, and every recording beside its runs."""
        free: dict[str, Errors] = {}
        near: dict[str, Errors] = {}
        traces: list[Trace] = []
        for role, bench in self.benches.items():
            runs = {name: free_runs(twin, bench) for name, twin in self.twins.items()}
            if self.approximate:
                self.in_mujoco[role] = _finite(nrmse(bench.trials, runs["explained"]))
                runs["explained"] = from_rest(bench, *self.hypotheses["explained"])
            windows = {n: ahead(bench, h, s) for n, (h, s) in self.hypotheses.items()}
            floors = noise_floors(bench, *self.hypotheses["explained"], seed=self.seed)
            free[role] = _errors(bench, runs, floors[0])
            near[role] = _errors(bench, windows, floors[1])
            for number, trial in enumerate(bench.trials):
                traces.append(
                    Trace(
                        trial.name,
                        role,  # type: ignore[arg-type]
                        trial.sampling_hz,
                        trial.inputs,
                        trial.outputs,
                        trial.u,
                        trial.y,
                        runs["nominal"][number],
                        runs["calibrated"][number],
                        runs["explained"][number],
                        windows["explained"][number],
                    )
                )
        return Fits(free["train"], free["test"]), Fits(near["train"], near["test"]), tuple(traces)


def _errors(bench: Bench, outputs: Mapping[str, Sequence[Array]], floor: float) -> Errors:
    each = {name: _finite(nrmse(bench.trials, values)) for name, values in outputs.items()}
    return Errors(each["nominal"], each["calibrated"], each["explained"], floor)


def _finite(value: float) -> float:
    """A motion that diverges is off by more than anything else: JSON has no infinity."""
    return value if np.isfinite(value) else 1e6
