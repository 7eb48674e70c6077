"""A recording's metric, in which its noise has unit variance, and what effects change in it.

The changes of the outputs go through the one-step predictor of the nominal twin: what is left are
the changes of its innovations, which are white (Kalman 1960).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from twin.errors import ModelError, TwinError
from twin.estimation.kalman import gains
from twin.estimation.laws import memory_along
from twin.estimation.system import Noise, System, sampled
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange
from twin.model.linear import LinearModel
from twin.model.transfer import transfer
from twin.rehearsal.responses import driven_by, force_response, motion, response

Array = NDArray[np.float64]

PROCESS = 1e-3
"""RMS of the process noise that a diagnosis grants beforehand, as a share of the elastic forces: a
linear structure and its analyser agree to about that."""

LEAST_NOISE = 1e-6
"""Share of a channel's RMS that is taken as its noise at least: that of a converter of 20 bits."""


@dataclass(frozen=True)
class Trial:
    """A nominal recording of the plan.

    Attributes:
        u: inputs, (samples, r); zero where the recording has none.
        y: outputs, (samples, m).
        input_noise, output_noise: standard deviations, (r,), (m,).
        rate_hz: samples per second.
    """

    u: Array
    y: Array
    input_noise: Array
    output_noise: Array
    rate_hz: float


class Whitener:
    """The one-step predictor of a nominal twin for one recording.

    Args:
        model: linear equations of the twin.
        trial: the recording, nothing concealed.

    Raises:
        TwinError: its outputs cannot tell where the structure is.
    """

    def __init__(self, model: LinearModel, trial: Trial) -> None:
        self.model, self.trial = model, trial
        self.nominal = response(model, trial.u, trial.rate_hz)
        self.q, self.v = motion(model, trial.u, trial.rate_hz)
        least = LEAST_NOISE * np.sqrt(np.mean(trial.y**2, axis=0)) + 1e-30
        self.output = np.hypot(trial.output_noise, least)
        self.process = PROCESS * float(np.sqrt(np.mean((self.q @ model.K) ** 2)))
        n, m, r = len(model.coordinates), len(model.outputs), len(model.inputs)
        space = model.state_space()
        inverse = np.linalg.inv(model.M)
        W = np.hstack([space.B, np.vstack([np.zeros((n, n)), inverse])])
        V = np.hstack([space.D, model.Ca @ inverse])
        none = np.zeros((2 * n, 0))
        system = System(
            space.A, space.B, space.C, space.D, none, np.zeros((m, 0)), none[:n].T, none[:n].T,
            W, V, none,
        )  # fmt: skip
        held = np.concatenate([trial.input_noise, np.full(n, self.process)])
        states = np.concatenate([np.mean(self.q**2, axis=0), np.mean(self.v**2, axis=0)])
        plant = sampled(system, 1 / trial.rate_hz, 1, np.zeros(r, bool))
        try:
            gain = gains(plant, Noise(held, self.output, np.diag(states)))
        except (ValueError, np.linalg.LinAlgError):
            raise TwinError(
                "sensors: these cannot tell where the structure is, for no spring holds it; "
                "record a displacement, too"
            ) from None
        self._A, self._C = plant.whole, space.C
        self._K = plant.whole @ gain.state + plant.entry @ gain.held
        self._lower = np.linalg.cholesky(gain.innovation)

    def __call__(self, changes: Sequence[Array]) -> Array:
        """Return changes of the outputs, each (samples, m), in the metric, (samples m, c)."""
        y = np.stack(changes, axis=2)
        x = np.zeros((len(self._A), y.shape[2]))
        out = np.empty_like(y)
        last = len(self._K) - 1
        for k in range(len(y)):
            at = min(k, last)
            e = y[k] - self._C @ x
            out[k] = solve_triangular(self._lower[at], e, lower=True, check_finite=False)
            x = self._A @ x + self._K[at] @ e
        return out.reshape(-1, y.shape[2])

    def edited(self, model: LinearModel) -> Array:
        """Return the outputs of another model under the trial's inputs, (samples, m)."""
        return response(model, self.trial.u, self.trial.rate_hz)

    def change(self, mechanism: Mechanism) -> Array:
        """Return what a mechanism changes in the outputs beside what is predicted, (samples, m)."""
        if isinstance(mechanism, Law):
            force = self._force(mechanism)
            rate = self.trial.rate_hz
            return -force_response(self.model, mechanism.place, force, rate)
        if isinstance(mechanism, StructuralChange):
            try:
                return self.edited(mechanism.edit(self.model)) - self.nominal
            except (ModelError, ValueError, np.linalg.LinAlgError):
                return np.zeros_like(self.nominal)
        if isinstance(mechanism, ChannelFault):
            return self._fault(mechanism)
        return np.zeros_like(self.nominal)

    def _fault(self, fault: ChannelFault) -> Array:
        table = np.hstack([self.trial.u, self.trial.y])
        names = (*self.model.inputs, *self.model.outputs)
        columns = dict(zip(names, table.T, strict=True))
        faulty = fault.distort(columns, self.trial.rate_hz)
        moved = np.column_stack([faulty[n] - columns[n] for n in names])
        r = len(self.model.inputs)
        outputs = moved[:, r:]
        # a wrong input is not what acted: the prediction errs by as much as a motor's motion does
        sign = 1.0 if fault.of_motor else -1.0
        if np.any(moved[:, :r]):
            outputs = outputs + sign * response(self.model, moved[:, :r], self.trial.rate_hz)
        return outputs

    def _force(self, law: Law) -> Array:
        """Return a law's force along the nominal motion [N], (samples,)."""
        row = self.model.port(law.place)
        drift, rate = self.q @ row, self.v @ row
        memory = memory_along(law.compiled, np.array(law.numbers), drift)
        time = np.arange(len(drift)) / self.trial.rate_hz
        return np.broadcast_to(law.force(drift, rate, memory, time), drift.shape)

    def power(self, fault: Mechanism) -> Array:
        """Return the power of what a fault adds over that of the noise, (frequencies m,)."""
        white = self([self.change(fault)]).reshape(len(self.trial.u), -1)
        # of two parts at each frequency, real and imaginary, each has unit variance of noise
        return np.asarray(np.abs(np.fft.rfft(white, axis=0, norm="ortho")) ** 2).ravel()

    def spectrum(self, force: Disturbance) -> Array:
        """Return the power of a random force over that of the noise, (frequencies,)."""
        model, rate = self.model, self.trial.rate_hz
        s = np.asarray(2j * np.pi * np.fft.rfftfreq(len(self.trial.u), 1 / rate))
        every = np.hstack([model.B, np.eye(len(model.coordinates))])
        direct = np.hstack([model.Cu, np.zeros((len(model.outputs), len(model.coordinates)))])
        names = (*model.inputs, *model.coordinates)
        H = transfer(_with_inputs(model, names, every, direct), s)
        held = np.append(self.trial.input_noise, np.full(len(model.coordinates), self.process))
        noise = (H * held**2) @ np.conj(np.swapaxes(H, 1, 2)) + np.diag(self.output**2)
        A, b, c = force.shaping()
        inverse = np.linalg.inv(s[:, None, None] * np.eye(len(A)) - A)
        density = np.abs(inverse @ b @ c) ** 2
        G = transfer(driven_by(model, force.place), s)
        seen = np.linalg.solve(np.linalg.cholesky(noise), G)[:, :, 0]
        return np.asarray(rate * density * np.sum(np.abs(seen) ** 2, axis=1))


def _with_inputs(model: LinearModel, names: tuple[str, ...], B: Array, Cu: Array) -> LinearModel:
    return replace(model, inputs=names, B=B, Cu=Cu)
