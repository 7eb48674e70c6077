"""The three twins beside the recordings: free runs in MuJoCo, and two seconds ahead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.estimator import Estimator, foreseeing, without_disturbances
from twin.diagnosis.fitting import Fit
from twin.diagnosis.plant import laws_of
from twin.diagnosis.predict import ahead, from_rest, noise_floors, nrmse
from twin.diagnosis.prepare import Prepared
from twin.diagnosis.result import Errors, Fits, Trace
from twin.diagnosis.rig import free_runs, twin_with
from twin.diagnosis.search import Found

Array = NDArray[np.float64]

FORESEEN = (
    "what was found does not help to foresee two seconds ahead: that is left to the calibrated twin"
)

TOO_STRONG = (
    "{}: so much stronger than any recording that the law was fitted to that its forecast two "
    "seconds ahead is left to the calibrated twin"
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
        estimator = foreseeing(found.bench, found.best, calibrated)
        self.estimators = {
            "nominal": Estimator(bare, found.nothing.slack),
            "calibrated": Estimator(calibrated.hypothesis, calibrated.slack),
            "explained": estimator,
        }
        self.explained = found.best.hypothesis
        if not without_disturbances(self.explained).found:
            self.explained = replace(self.explained, base=estimator.hypothesis.base)
        self.approximate = any(law.approximate for law in laws_of(found.best.hypothesis.found))
        self.in_mujoco: dict[str, float] = {}
        shown = {name: e.hypothesis for name, e in self.estimators.items()} | {
            "explained": self.explained
        }
        self.twins = {name: twin_with(ready.twin, h.mechanisms) for name, h in shown.items()}

    def notes(self) -> tuple[str, ...]:
        """Say what else the errors are of than of the explained twin in MuJoCo."""
        same = self.estimators["explained"] == self.estimators["calibrated"]
        other = self.calibrated.hypothesis != self.found.best.hypothesis
        said: tuple[str, ...] = (FORESEEN,) if same and other else ()
        trials = [trial for bench in self.benches.values() for trial in bench.trials]
        if beyond := [t.name for t in trials if not self.estimators["explained"].covers(t)]:
            said += (TOO_STRONG.format(", ".join(beyond)),)
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
            same = self.estimators["calibrated"].hypothesis == self.explained
            calibrated = runs["explained"] if same else free_runs(self.twins["calibrated"], bench)
            runs["calibrated"] = list(calibrated)
            if self.approximate:
                self.in_mujoco[role] = _finite(nrmse(bench.trials, runs["explained"]))
                runs["explained"] = from_rest(bench, self.explained, self.found.best.slack)
            windows = self._windows(bench)
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

    def _windows(self, bench: Bench) -> dict[str, list[Array]]:
        """Return the outputs two seconds ahead.

        Where the explained twin's estimator does not cover a recording, the calibrated one's.
        """
        # often two twins are one
        each = {e: ahead(bench, e.hypothesis, e.slack) for e in set(self.estimators.values())}
        out = {name: each[estimator] for name, estimator in self.estimators.items()}
        covered = [self.estimators["explained"].covers(trial) for trial in bench.trials]
        pairs = zip(covered, out["explained"], out["calibrated"], strict=True)
        out["explained"] = [own if covers else left for covers, own, left in pairs]
        return out


def _errors(bench: Bench, outputs: Mapping[str, Sequence[Array]], floor: float) -> Errors:
    each = {name: _finite(nrmse(bench.trials, values)) for name, values in outputs.items()}
    return Errors(each["nominal"], each["calibrated"], each["explained"], _finite(floor))


def _finite(value: float) -> float:
    """A motion that diverges is off by more than anything else: JSON has no infinity."""
    return value if np.isfinite(value) else 1e6
