"""What a fitted hypothesis predicts: free runs, two seconds ahead, and what noise alone does.

A free run starts from the estimated state before the first sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.arrays import rms_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.large_motion import along_pass
from twin.diagnosis.measured import Measured
from twin.diagnosis.problem import Problem
from twin.diagnosis.straight import prefiltered
from twin.estimation.averages import averages_at
from twin.estimation.kalman import Gains, gains, open_loop
from twin.estimation.law_averages import LawAverages
from twin.estimation.model import Assembly, Trial
from twin.estimation.passing import Run, run
from twin.estimation.sensitivities import plants_of
from twin.estimation.start import estimated_start, root_of
from twin.estimation.system import Noise, Sampled
from twin.mechanisms.mechanism import ChannelFault, Mechanism
from twin.model.geometry import PASSES

Array = NDArray[np.float64]

WINDOW_S = 2.0
"""Length of the windows of a prediction ahead [s]."""

HOPELESS = 1e6
"""Error that stands for a motion that diverges: JSON has no infinity."""


@dataclass(frozen=True)
class Predictor:
    """A hypothesis at certain values beside one recording.

    Attributes:
        mechanisms: with their values.
        names: of the outputs.
        here: the model at the values.
        trial: the recording, faults in its samples taken back.
        plant: the sampled system.
        noise: levels of this recording.
        gain: of the predictor.
        averages: what the laws do on the average of the motion.
        problem: the estimation problem.
    """

    mechanisms: tuple[Mechanism, ...]
    names: tuple[str, ...]
    here: Assembly
    trial: Trial
    plant: Sampled
    noise: Noise
    gain: Gains
    averages: LawAverages
    problem: Problem

    @property
    def inputs(self) -> Array:
        """The measured inputs, (samples, r)."""
        return self.trial.u[:, : len(self.problem.model.inputs)]

    @cached_property
    def followed(self) -> Run:
        """The predictor's pass from the prior's mean."""
        return run(self.here, self.trial, self.plant, self.gain, averages=self.averages)

    @cached_property
    def start(self) -> Array:
        """The estimated state before the first sample, (n,)."""
        start = estimated_start(self.here, self.trial, self.plant, self.noise, self.averages)
        return start.state

    def free(self, u: Array | None = None) -> Array:
        """Return the free run, with other inputs where given, (samples, m)."""
        return self._open(0, len(self.trial.y), self.start, None, u)

    def from_rest(self, part: slice = slice(None)) -> Array:
        """Return the simulation from rest, of a part of the recording or all, (samples, m).

        The time that laws are told begins with the part.
        """
        first, last, _ = part.indices(len(self.trial.y))
        return self._open(first, last, 0 * self.start, None, None, begin_s=0.0)

    def ahead(self, u: Array | None = None, offsets: Array | None = None) -> Array:
        """Return windows of two seconds from the states estimated before them, (samples, m).

        Args:
            u: other inputs, (samples, r).
            offsets: added to the state at each sample, (samples, n).
        """
        length = max(round(WINDOW_S / self.trial.step_s), 1)
        out = np.empty_like(self.trial.y)
        for first in range(0, len(out), length):
            x = self.followed.x[first] if first else self.start
            if offsets is not None and first:
                x = x + offsets[first]
            last = min(first + length, len(out))
            out[first:last] = self._open(first, last, x, self.followed.z[first], u)
        return out

    def _open(
        self, first: int, last: int, x: Array, z: Array | None, u: Array | None,
        begin_s: float | None = None,
    ) -> Array:  # fmt: skip
        """Return the outputs of a simulation over a part of the recording.

        What large motion adds is that of the simulated motion itself.
        """
        begin_s = first * self.trial.step_s if begin_s is None else begin_s
        more = 0.0 if u is None else (u - self.inputs)[first:last]
        own, r = self.trial, len(self.problem.model.inputs)
        driving, lines = own.u[first:last, :r] + more, own.between[first:last, :r] + more
        geometry, n = self.problem.geometry, self.problem.pseudo_forces
        forces, readings = np.zeros((last - first, n)), np.zeros((last - first, own.y.shape[1]))
        for _ in range(1 + (PASSES if n else 0)):
            piece = replace(own, u=np.hstack([driving, forces]), y=0 * readings,
                            blows=own.blows and own.blows.of_part(first, last),
                            between=np.hstack([lines, prefiltered(forces)]))  # fmt: skip
            passed = run(self.here, piece, self.plant, open_loop(self.gain), x0=x, z0=z,
                         begin_s=begin_s)  # fmt: skip
            q, v = (x[:, :n] for x in passed.moved())
            if geometry is None or not np.all(np.isfinite([q, v])):
                break
            found = along_pass(geometry, passed, passed.x, piece.u, self.problem.model)
            forces, readings = found.forces, found.readings
        missed = 0.0 if own.missed is None else own.missed[first:last]
        return self._recorded(readings - passed.e + missed)

    def _recorded(self, predicted: Array) -> Array:
        """Return outputs as the instruments show them that are at fault in their samples."""
        columns = dict(zip(self.names, predicted.T, strict=True))
        for fault in self.mechanisms:
            if not isinstance(fault, ChannelFault) or not set(fault.channels) <= set(columns):
                continue
            if fault.in_samples or fault.limit() is not None:
                columns = fault.distort(columns, 1 / self.trial.step_s)
        return np.column_stack([columns[name] for name in self.names])


def predictors(
    hypothesis: Hypothesis, z: Array, known: Sequence[LawAverages] | None = None
) -> list[Predictor]:
    """Return a hypothesis beside each of its recordings.

    Args:
        hypothesis: the model.
        z: its values, (p,).
        known: averages of its laws, as the fit ended with them; found anew without.
    """
    here = hypothesis.assemble(z)
    plants = plants_of(here, hypothesis)
    names = hypothesis.problem.model.outputs
    out = []
    for t, trial in enumerate(here.trials):
        plant, noise = plants[here.which[t]], here.noises[t]
        everything = (*hypothesis.at(z), *hypothesis.problem.known_at(z))
        averages = known[t] if known else averages_at(hypothesis, here, plants, t)
        gain = gains(averages.filtering(plant), averages.beginning(noise),
                     equivalent=averages.equivalent, missing=trial.missing)  # fmt: skip
        out.append(Predictor(everything, names, here, trial, plant, noise, gain, averages,
                             hypothesis.problem))  # fmt: skip
    return out


def placed(fitted: Hypothesis, z: Array, problem: Problem) -> tuple[Hypothesis, Array]:
    """Return a fitted hypothesis beside other recordings.

    The noise of their instruments is what their own samples show, but no more than it was in the
    recordings of the fit, in their unit or as a share of what they read: a floor that is read off
    samples holds whatever else is as fast. The process noise is that of the fit.

    Args:
        fitted: on the training recordings.
        z: values of its unknowns, (p,).
        problem: of the same model, with the recordings to predict.
    """
    known = {u.name: float(v) for u, v in zip(fitted.unknowns, z, strict=True)}
    own = fitted.problem
    there = replace(own, recordings=problem.recordings, scale=problem.scale)
    here = replace(fitted, problem=there, begun=())
    process = [v for name, v in known.items() if name.startswith("process noise")]
    most = _most_noise(fitted, z, there)
    values = np.zeros(len(here.unknowns))
    for i, unknown in enumerate(here.unknowns):
        if unknown.name in most:
            above = np.log(most[unknown.name]) - unknown.mean
            values[i] = min(above / unknown.deviation, 0.0)
        elif unknown.name.startswith("process noise"):
            values[i] = float(np.mean(process))
        else:
            values[i] = known.get(unknown.name, 0.0)
    return here, values


def _most_noise(fitted: Hypothesis, z: Array, there: Problem) -> dict[str, float]:
    """Return the most that each channel's noise can be in other recordings, by its name."""
    own = fitted.problem
    levels = {u.name: u.value(float(v)) for u, v in zip(fitted.unknowns, z, strict=True)}
    seen = [(r.name, _readings(own, r)) for r in own.recordings]
    out = dict[str, float]()
    for recording in there.recordings:
        for channel, reading in _readings(there, recording).items():
            found = [
                level * max(1.0, reading / readings[channel])
                for name, readings in seen
                if (level := levels.get(f"noise of {channel} in {name}")) and readings[channel]
            ]
            if found:
                out[f"noise of {channel} in {recording.name}"] = max(found)
    return out


def _readings(problem: Problem, recording: Measured) -> dict[str, float]:
    """Return the RMS of every channel of a recording."""
    table = np.hstack([recording.u, recording.y])
    names = (*problem.model.inputs, *problem.model.outputs)
    return dict(zip(names, rms_of(table).tolist(), strict=True))


def nrmse(measured: Sequence[Array], predicted: Sequence[Array]) -> float:
    """Return RMS of the residual over RMS of the output, over all channels and recordings.

    Samples that are left out (NaN) do not count; a motion that diverges is off by ``HOPELESS``.
    """
    error = sum(float(np.nansum((y - p) ** 2)) for y, p in zip(measured, predicted, strict=True))
    power = sum(float(np.nansum(y**2)) for y in measured)
    finite = all(np.all(np.isfinite(p)) for p in predicted)
    return min(float(np.sqrt(error / power)), HOPELESS) if finite else HOPELESS


def noise_floors(beside: Sequence[Predictor], seed: int = 0) -> tuple[float, float]:
    """Return the NRMSE that a perfect model would reach: free run, and two seconds ahead.

    The measured force is not the true one: another draw of its noise on top of it shows what that
    does to the motion, with the motion's own sensitivity; in windows the uncertainty of the state
    comes on top. The outputs' noise is added.
    """
    rng = np.random.default_rng(seed)
    free = near = power = 0.0
    for predictor in beside:
        y, u = predictor.trial.y, predictor.inputs
        noise = float(np.sum(predictor.noise.output**2)) * len(y)
        shaken = u + rng.standard_normal(u.shape) * predictor.noise.held[: u.shape[1]]
        blur = (
            rng.standard_normal((len(y), len(predictor.plant.A)))
            @ root_of(predictor.gain.predicted).T
        )
        free += float(np.sum((predictor.free() - predictor.free(shaken)) ** 2)) + noise
        near += float(np.sum((predictor.ahead() - predictor.ahead(shaken, blur)) ** 2)) + noise
        power += float(np.nansum(y**2))
    found = np.nan_to_num(np.sqrt(np.array([free, near]) / power), nan=HOPELESS, posinf=HOPELESS)
    return float(min(found[0], HOPELESS)), float(min(found[1], HOPELESS))
