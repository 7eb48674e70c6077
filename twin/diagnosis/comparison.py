"""The three twins beside the recordings: nominal, calibrated and explained."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.arrays import strongest
from twin.diagnosis.errors_of_runs import Errors, Fits
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.exported import in_mujoco, twin_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.large_motion import along_its_motion
from twin.diagnosis.predict import Predictor, noise_floors, nrmse, placed, predictors
from twin.diagnosis.prepare import Prepared
from twin.diagnosis.result import Trace
from twin.model import Twin
from twin.model.self_check import NOTED

Array = NDArray[np.float64]

NO_HELP = (
    "two seconds ahead the extended twin predicts the training recordings no better than the "
    "calibrated one, so the prediction two seconds ahead is the calibrated twin's"
)


PLAYED = 5e5
"""Steps of MuJoCo at most in which a recording's motion of the exported twin is played: half a
minute with friction. It shows whether the file moves as predicted; long recordings and slow
structures that slip would take ten times as long as all else."""

END = 64
"""Samples that are played beyond a part: what is resampled to its end rings there."""


@dataclass(frozen=True)
class Comparison:
    """What the twins predict.

    Attributes:
        fit, fit_ahead: errors of free runs and two seconds ahead.
        traces: every recording beside its predictions.
        twins: "nominal", "calibrated", "explained" in MuJoCo.
        notes: where MuJoCo's motion of the exported twin is another one.
    """

    fit: Fits
    fit_ahead: Fits
    traces: tuple[Trace, ...]
    twins: Mapping[str, Twin]
    notes: tuple[str, ...]


def compare(
    ready: Prepared, nothing: Explanation, calibrated: Explanation, best: Explanation, seed: int
) -> Comparison:
    """Lay the three twins beside all recordings.

    Two seconds ahead, what does not help on the training recordings does not predict.

    Args:
        ready: the recordings.
        nothing: the calibrated twin within its tolerances.
        calibrated: the best twin without new physics.
        best: the best explanation.
        seed: of the draws for the noise floors.
    """
    base = len(nothing.hypothesis.problem.base_unknowns)
    nominal = np.concatenate([np.zeros(base), nothing.fit.z[base:]])
    models: dict[str, tuple[Hypothesis, Array]] = {
        "nominal": (nothing.hypothesis, nominal),
        "calibrated": (calibrated.hypothesis, calibrated.fit.z),
        "explained": (best.hypothesis, best.fit.z),
    }
    twins = {name: twin_of(ready.twin, *model) for name, model in models.items()}
    fit, ahead, traces, notes = {}, {}, [], []
    helps = True
    for role, problem in (("train", ready.train), ("test", ready.test)):
        beside: dict[str, list[Predictor]] = {}
        for name, (hypothesis, z) in models.items():
            if role == "test":
                hypothesis, z = placed(hypothesis, z, problem)
                if hypothesis.problem.geometry is not None:
                    moved = along_its_motion(hypothesis, z)
                    hypothesis = replace(hypothesis, problem=moved)
            beside[name] = predictors(hypothesis, z)
        runs = {name: [s.free() for s in each] for name, each in beside.items()}
        windows = {name: [s.ahead() for s in each] for name, each in beside.items()}
        measured = [r.y for r in problem.recordings]
        if role == "train":
            here = {name: nrmse(measured, windows[name]) for name in ("calibrated", "explained")}
            helps = here["explained"] <= here["calibrated"]
            notes += [] if helps else [NO_HELP]
        if not helps:
            windows["explained"] = windows["calibrated"]
        floors = noise_floors(beside["explained"], seed)
        fit[role] = _errors(measured, runs, floors[0])
        ahead[role] = _errors(measured, windows, floors[1])
        for number, recording in enumerate(problem.recordings):
            traces.append(
                Trace(
                    recording.name, role, problem.sampling_hz,  # type: ignore[arg-type]
                    problem.model.inputs, problem.model.outputs, recording.u, recording.y,
                    runs["nominal"][number], runs["calibrated"][number], runs["explained"][number],
                    windows["explained"][number],
                )
            )  # fmt: skip
        if role == "test":
            notes += _in_mujoco(twins["explained"], beside["explained"], best, ready)
    return Comparison(
        Fits(fit["train"], fit["test"]), Fits(ahead["train"], ahead["test"]), tuple(traces),
        twins, tuple(notes),
    )  # fmt: skip


def _errors(
    measured: Sequence[Array], outputs: Mapping[str, Sequence[Array]], floor: float
) -> Errors:
    each = {name: nrmse(measured, values) for name, values in outputs.items()}
    return Errors(each["nominal"], each["calibrated"], each["explained"], floor)


def _in_mujoco(
    twin: Twin, beside: Sequence[Predictor], best: Explanation, ready: Prepared
) -> list[str]:
    """Simulate the exported twin from rest and say where its motion is another than predicted."""
    problem = best.hypothesis.problem
    longest = round(PLAYED * twin.compile().opt.timestep * problem.sampling_hz)
    out, own, noise, measured = [], [], [], []
    for predictor, recording in zip(beside, ready.test.recordings, strict=True):
        part = strongest(recording.u, longest)
        played = recording.part(slice(part.start, part.stop + END))
        out.append(in_mujoco(twin, problem, played)[:longest])
        own.append(predictor.from_rest(part))
        noise.append(np.broadcast_to(predictor.noise.output, out[-1].shape))
        measured.append(recording.y[part])
    cut = any(len(m) < len(r.y) for m, r in zip(measured, ready.test.recordings, strict=True))
    where = f"over the {longest / problem.sampling_hz:.3g} s of the strongest inputs " * cut
    difference = nrmse(out, own) if all(np.all(np.isfinite(o)) for o in out) else np.inf
    level = nrmse(measured, [y - n for y, n in zip(measured, noise, strict=True)])
    if difference <= NOTED * level:
        return []
    there = nrmse(measured, out)
    return [
        f"from rest MuJoCo's motion of the exported twin {where}differs from the predicted one by "
        f"{difference:.3g} of RMS; its error on the test recordings is {there:.3g}, that of the "
        f"engine's own equations {nrmse(measured, own):.3g}"
    ]
