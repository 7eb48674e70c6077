"""What a diagnosis says, and what its pictures are drawn from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.errors_of_runs import Fits
from twin.mechanisms.mechanism import Mechanism
from twin.model import Twin
from twin.presentable import Presentable

Array = NDArray[np.float64]
Verdict = Literal["consistent", "parameter", "missing_physics", "measurement", "unexplained"]


@dataclass(frozen=True)
class Finding:
    """A mechanism that explains a part of the mismatch.

    Attributes:
        mechanism: with its place and fitted values.
        std: standard deviation of every parameter; NaN where the data do not give one.
        probability: that it is this mechanism at this place and not one of the alternatives.
        delta_log_evidence: log odds over the best explanation [nat] (alternatives only).
        explained, unexplained: share of the missing force at its place that it accounts for, and
            that is left to the discrepancy there and to forces that stand for the law's form; None
            where no force is missing.
        gain: log odds over having nothing in its place [nat], where they are known.
    """

    mechanism: Mechanism
    std: Mapping[str, float]
    probability: float
    delta_log_evidence: float = 0.0
    explained: float | None = None
    unexplained: float | None = None
    gain: float | None = None

    @property
    def location(self) -> str:
        """Where it is."""
        return self.mechanism.place

    @property
    def delta_bic(self) -> float:
        """The same odds as a difference of BIC: above that of the best explanation."""
        return -2 * self.delta_log_evidence


@dataclass(frozen=True)
class Trace:
    """One recording beside the simulations of it.

    Attributes:
        name, role, sampling_hz: of the recording: its file, "train" or "test", samples per second.
        inputs, outputs: names of the channels; force: measured inputs, (samples, inputs).
        measured, nominal, calibrated, explained: outputs, (samples, outputs); free runs.
        explained_ahead: two seconds ahead from the state before each window, (samples, outputs).
    """

    name: str
    role: Literal["train", "test"]
    sampling_hz: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    force: Array
    measured: Array
    nominal: Array
    calibrated: Array
    explained: Array
    explained_ahead: Array


@dataclass(frozen=True)
class Detection:
    """How far an output channel's one-step errors by the calibrated twin are from noise.

    Attributes:
        channel, p_value: name; of its errors being white, by the test of Ljung and Box (1978).
        excess: RMS of the errors over the noise of the channel.
        born_s: when the error first leaves the noise in each training recording [s], or NaN.
        frequency_hz: where its spectrum stands out most [Hz].
        level: RMS output and excess of each training recording, (recordings, 2).
    """

    channel: str
    p_value: float
    excess: float
    born_s: tuple[float, ...]
    frequency_hz: float
    level: Array


@dataclass(frozen=True)
class ForcePicture:
    """The force that is missing at one place against the motion there.

    Attributes:
        place, drift, rate: a port, its estimated drift [m] and rate [m/s], (samples,).
        latent: estimated missing force [N], (samples,).
        law_drift: grid of drifts [m], (grid,); law, law_std: the law's force there at zero rate and
            its deviation [N], (grid,), or None.
        cycle: drift, force of the explained law along a piece of the motion, (samples, 2), or None.
        unit: of the motion, "m" or "rad"; the force is then in N or in N m.
        law_rate: grid of rates that ``law`` and ``law_std`` are over instead, (grid,), or None.
        piece: time, missing force, the law's and its deviation for a while, (samples, 4), or None.
    """

    place: str
    drift: Array
    rate: Array
    latent: Array
    law_drift: Array
    law: Array | None = None
    law_std: Array | None = None
    cycle: Array | None = None
    unit: str = "m"
    law_rate: Array | None = None
    piece: Array | None = None


@dataclass(frozen=True)
class NextExperiment:
    """The test that separates two explanations best.

    Attributes:
        separates: the two, as "mechanism at place".
        command: of ``twin test``, ready to run.
        reason: in one sentence.
        expected_log_odds: expected evidence in favour of whichever is true.
        options: all tests that were compared, best first: (description, expected log odds).
    """

    separates: tuple[str, str]
    command: str
    reason: str
    expected_log_odds: float
    options: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, repr=False)
class Diagnosis(Presentable):
    """What the recordings say of the twin.

    Attributes:
        verdict: what kind of mismatch there is.
        findings: what was left out, the largest share of the mismatch first.
        alternatives: other explanations of the first finding, the most probable first.
        calibration: deviations of masses, stiffnesses and dampings that stayed within tolerance.
        fit: free runs over whole recordings.
        fit_ahead: windows of two seconds from the state estimated before.
        where: the most that the screening promises of a mechanism at each port [nat].
        detection: one an output channel.
        screening: all candidates: mechanism, place, promised gain in log likelihood.
        force: pictures of the missing force, the located place first.
        traces: every recording beside its simulations.
        nominal, calibrated, explained: the three twins.
        channel_faults: faults among the findings, which the twins do not hold.
        next_experiment: what would separate the explanations, where they tie.
        negligible: mechanisms of the explanation whose effect is smaller than what is left.
        notes: what the reader should know (resampling, what MJCF cannot hold, ...).
        seconds, steps: that it took, and those of each step.
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    alternatives: tuple[Finding, ...]
    calibration: tuple[Finding, ...]
    fit: Fits
    fit_ahead: Fits
    where: Mapping[str, float]
    detection: tuple[Detection, ...]
    screening: tuple[tuple[str, str, float], ...]
    force: tuple[ForcePicture, ...]
    traces: tuple[Trace, ...]
    nominal: Twin
    calibrated: Twin
    explained: Twin
    next_experiment: NextExperiment | None = None
    negligible: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    steps: Mapping[str, float] = field(default_factory=dict)

    def _title(self) -> str:
        return f"diagnosis of {Path(self.nominal.source).name}: {self.verdict.replace('_', ' ')}"

    def _rows(self) -> Iterator[tuple[str, str]]:
        for finding in self.findings:
            mechanism = finding.mechanism
            values = ", ".join(f"{name} {value:.4g}" for name, value in mechanism.values.items())
            what = f"{mechanism.name} at {mechanism.place}"
            yield what, f"probability {finding.probability:.3g}: {values}"
        test = self.fit.test
        after = f"{100 * test.explained:.3g} % after"
        after += f", {100 * test.stated:.3g} % stated beforehand" if test.stated is not None else ""
        yield "unseen recordings", f"error {100 * test.calibrated:.3g} % of RMS before, {after}"
        for note in self.notes:
            yield "note", note

    @property
    def place(self) -> str | None:
        """Where the first finding is."""
        return self.findings[0].location if self.findings else None


def as_json(diagnosis: Diagnosis, twin: str | None) -> dict[str, Any]:
    """Return the diagnosis by the contract.

    Args:
        diagnosis: what was found.
        twin: path of the explained MJCF, where it was written.
    """

    def entry(finding: Finding) -> dict[str, Any]:
        mechanism = finding.mechanism
        return {
            "mechanism": mechanism.name,
            "location": mechanism.place,
            "parameters": {
                name: {
                    "value": float(value),
                    "std": _plain(finding.std.get(name, float("nan"))),
                    "unit": mechanism.parameters[name].unit,
                }
                for name, value in mechanism.values.items()
            },
            "probability": float(np.clip(finding.probability, 0, 1)),
            "explained": finding.explained,
            "unexplained": finding.unexplained,
            "gain": finding.gain,
        }

    def errors(fits: Fits) -> dict[str, Any]:
        roles = {"train": fits.train, "test": fits.test}
        return {role: {k: float(v) for k, v in vars(e).items() if v is not None}
                for role, e in roles.items()}  # fmt: skip

    following = diagnosis.next_experiment
    return {
        "verdict": diagnosis.verdict,
        "findings": [entry(f) for f in diagnosis.findings],
        "alternatives": [
            entry(f)
            | {
                "delta_bic": float(f.delta_bic),
                "delta_log_evidence": float(f.delta_log_evidence),
            }
            for f in diagnosis.alternatives
        ],
        "negligible": [entry(f) for f in diagnosis.negligible],
        "calibration": [entry(f) for f in diagnosis.calibration],
        "fit": errors(diagnosis.fit),
        "fit_ahead": errors(diagnosis.fit_ahead),
        "where": {place: float(gain) for place, gain in diagnosis.where.items()},
        "detection": [
            {
                "channel": d.channel,
                "p_value": float(d.p_value),
                "excess": float(d.excess),
                "frequency_hz": _plain(d.frequency_hz),
                "born_s": [_plain(t) for t in d.born_s],
            }
            for d in diagnosis.detection
        ],
        "twin": twin,
        "next_experiment": None
        if following is None
        else {
            "separates": list(following.separates),
            "command": following.command,
            "reason": following.reason,
            "expected_log_odds": float(following.expected_log_odds),
            "options": [{"test": t, "expected_log_odds": float(g)} for t, g in following.options],
        },
        "notes": list(diagnosis.notes),
        "seconds": float(diagnosis.seconds),
        "steps": {name: float(s) for name, s in diagnosis.steps.items()},
    }


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
