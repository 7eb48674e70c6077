"""The three twins beside the recordings: free runs in MuJoCo, and two seconds ahead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import laws_of
from twin.diagnosis.predict import ahead, from_rest, noise_floors, nrmse
from twin.diagnosis.prepare import Prepared
from twin.diagnosis.result import Errors, Fits, Trace
from twin.diagnosis.rig import free_runs, twin_with
from twin.diagnosis.search import Found
from twin.physics.mechanism import Disturbance

Array = NDArray[np.float64]


SOUND = 1.1
"""An explanation that misses two seconds ahead by less than this many times what noise alone does
foresees as well as can be."""

CLEARLY = 0.995
NOWHERE = 1.02
"""It foresees better than the calibrated twin where it misses less than ``CLEARLY`` of what that
one misses, over all training recordings, and in none of them more than ``NOWHERE`` times as much:
what is right on one kind of test only need not be so on the next."""

FORESEEN = (
    "what was found does not help to foresee two seconds ahead: that is left to the calibrated twin"
)


class Shown:
    """The three twins on all recordings: free runs in MuJoCo, and two seconds ahead."""

    def __init__(self, ready: Prepared, found: Found, calibrated: Fit, seed: int) -> None:
        self.found, self.calibrated, self.seed = found, calibrated, seed
        self.benches = {
            "train": found.bench,
            "test": replace(ready.test, between=found.bench.between),
        }
        bare = replace(found.nothing.hypothesis, base=(), tolerance=())
        foreseeing = _foreseeing(found.bench, found.best, calibrated)
        self.hypotheses: dict[str, tuple[Hypothesis, float]] = {
            "nominal": (bare, found.nothing.slack),
            "calibrated": (calibrated.hypothesis, calibrated.slack),
            "explained": foreseeing,
        }
        self.explained = found.best.hypothesis
        if not _without_disturbances(self.explained).found:
            self.explained = replace(self.explained, base=foreseeing[0].base)
        self.approximate = any(law.approximate for law in laws_of(found.best.hypothesis.found))
        self.in_mujoco: dict[str, float] = {}
        shown = {name: h for name, (h, _) in self.hypotheses.items()} | {
            "explained": self.explained
        }
        self.twins = {name: twin_with(ready.twin, h.mechanisms) for name, h in shown.items()}

    def notes(self) -> tuple[str, ...]:
        """Say what else the errors are of than of the explained twin in MuJoCo."""
        same = self.hypotheses["explained"] == self.hypotheses["calibrated"]
        said = (FORESEEN,) if self.explained.found and same else ()
        if not self.approximate:
            return said
        reached = ", ".join(f"{v:.3g} ({role})" for role, v in self.in_mujoco.items())
        return (
            *said,
            "the free runs of the explained twin are those of the fitted law; the MJCF's native "
            f"elements, which only come near it, reach an error of {reached}",
        )

    def fits(self) -> tuple[Fits, Fits, tuple[Trace, ...]]:
        """Return free-run errors, two-second errors, and every recording beside its runs."""
        free: dict[str, Errors] = {}
        near: dict[str, Errors] = {}
        traces: list[Trace] = []
        for role, bench in self.benches.items():
            runs = {n: free_runs(self.twins[n], bench) for n in ("nominal", "explained")}
            same = self.hypotheses["calibrated"][0] == self.explained
            calibrated = runs["explained"] if same else free_runs(self.twins["calibrated"], bench)
            runs["calibrated"] = list(calibrated)
            if self.approximate:
                self.in_mujoco[role] = _finite(nrmse(bench.trials, runs["explained"]))
                runs["explained"] = from_rest(bench, self.explained, self.found.best.slack)
            windows = {n: ahead(bench, h, s) for n, (h, s) in self.hypotheses.items()}
            floors = noise_floors(bench, self.explained, self.found.best.slack, seed=self.seed)
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


def _foreseeing(bench: Bench, best: Fit, calibrated: Fit) -> tuple[Hypothesis, float]:
    """Return the hypothesis and slack that foresee the training recordings best.

    A model that is right foresees best with the slack it was fitted with. Where it is not, a filter
    that listens more knows the state better; and what cannot be foreseen, as broad noise, is better
    left to the filter's slack. What foresees no better than the calibrated twin is left to that.
    """
    whole = best.hypothesis
    if not whole.found:
        return whole, best.slack

    def missed(hypothesis: Hypothesis, slack: float) -> Array:
        return _missed(bench, hypothesis, slack)

    options = [(missed(whole, best.slack), whole, best.slack)]
    power = np.array([float(np.sum(trial.y**2)) for trial in bench.trials])
    floor = noise_floors(bench, whole, best.slack, seed=0)[1]
    if np.sum(options[0][0]) > SOUND**2 * floor**2 * np.sum(power):
        laws = _without_disturbances(whole)
        tried = (whole,) if laws == whole else (whole, laws)
        options += [(missed(h, s), h, s) for h in tried for s in bench.slacks]
    least, hypothesis, slack = min(options, key=lambda option: float(np.sum(option[0])))
    other = missed(calibrated.hypothesis, calibrated.slack)
    if np.sum(least) < CLEARLY**2 * np.sum(other) and np.all(least < NOWHERE**2 * other):
        return hypothesis, slack
    return calibrated.hypothesis, calibrated.slack


def _missed(bench: Bench, hypothesis: Hypothesis, slack: float) -> Array:
    """Return the squared error two seconds ahead, summed over each trial, (trials,)."""
    try:
        foreseen = ahead(bench, hypothesis, slack)
    except np.linalg.LinAlgError:
        return np.full(len(bench.trials), np.inf)
    errors = [float(np.sum((t.y - y) ** 2)) for t, y in zip(bench.trials, foreseen, strict=True)]
    return np.nan_to_num(errors, nan=np.inf, posinf=np.inf)


def _without_disturbances(whole: Hypothesis) -> Hypothesis:
    return replace(whole, found=tuple(m for m in whole.found if not isinstance(m, Disturbance)))


def _floor(bench: Bench, best: Fit) -> float:
    """Return the error two seconds ahead that noise alone would leave."""
    return noise_floors(bench, best.hypothesis, best.slack, seed=0)[1]


def _errors(bench: Bench, outputs: Mapping[str, Sequence[Array]], floor: float) -> Errors:
    each = {name: _finite(nrmse(bench.trials, values)) for name, values in outputs.items()}
    return Errors(each["nominal"], each["calibrated"], each["explained"], floor)


def _finite(value: float) -> float:
    """A motion that diverges is off by more than anything else: JSON has no infinity."""
    return value if np.isfinite(value) else 1e6
