"""The predictor's pass over one recording.

Where an output is more uncertain than its noise, by variances B, the innovations' covariance S
there is S + B, and the predictor believes it less, by S (S + B)^-1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.estimation.kalman import EquivalentLinear, Gains
from twin.estimation.laws import addresses
from twin.estimation.model import Assembly, Trial
from twin.estimation.sensitivities import (
    Slopes,
    gain_matrices,
    no_slopes,
    numbers_of,
    predicting,
    read_matrix,
    simulation_matrix,
    step_matrix,
)
from twin.estimation.simulated import filtered, simulate
from twin.estimation.stepping import predict
from twin.estimation.system import Sampled, System

Array = NDArray[np.float64]

SHARP = 1e-3
"""Share of an output's innovation variance below which another variance changes nothing: 0.05 % of
its weight."""


@dataclass(frozen=True)
class LawAverages:
    """What laws do on the average of one recording's motion; of a linear model nothing.

    Attributes:
        equivalent: what they add to the linear system, for the gains.
        blur: variances of the outputs beside their noise's, (samples, m).
        slopes: k and c of each law's k d + c v, (l, 2); none where they are not known.
        start: state from which laws are simulated, (n,); rest without.
    """

    equivalent: EquivalentLinear | None = None
    blur: Array | None = None
    slopes: Array | None = None
    start: Array | None = None

    def tangent(self, system: System) -> Array:
        """Return what the laws do on the average, as forces of a system's state, (l, n)."""
        if self.slopes is None:
            return np.zeros_like(system.drift)
        return np.asarray(self.slopes[:, :1] * system.drift + self.slopes[:, 1:] * system.rate)


@dataclass(frozen=True)
class Run:
    """The predictor's pass over one recording.

    Attributes:
        e: innovations, (samples, m); zero where nothing was measured.
        de: their derivatives, (samples, m, p); p = 0 without.
        x: states before each sample, (samples, n).
        z: memories of the laws, (samples, l).
        f: forces of the laws at the samples, (samples, l).
        gains: of the predictor.
        sampled: the sampled system.
        averages: what the laws do on the average of the motion.
    """

    e: Array
    de: Array
    x: Array
    z: Array
    f: Array
    gains: Gains
    sampled: Sampled
    averages: LawAverages


def run(
    assembly: Assembly,
    trial: Trial,
    plant: Sampled,
    gain: Gains,
    slopes: Slopes | None = None,
    x0: Array | None = None,
    z0: Array | None = None,
    begin_s: float = 0.0,
    dx0: Array | None = None,
    averages: LawAverages | None = None,
) -> Run:
    """Step the predictor over one recording.

    Args:
        assembly: for laws and numbers.
        trial: the recording.
        plant: its sampled system.
        gain: gains of the predictor.
        slopes: derivatives with respect to p unknowns; without, only the first state changes.
        x0: state before the first sample, (n,), or rest.
        z0: memories of the laws before it, (l,), or zero.
        begin_s: time of the first sample [s].
        dx0: derivatives of the first state, (n, p).
        averages: what the laws do on the average of the motion; they blur nothing without.
    """
    laws, numbers = len(assembly.laws), numbers_of(assembly)
    averages = averages or LawAverages()
    n, (samples, m) = len(plant.A), trial.y.shape
    d = slopes or no_slopes(plant, gain, numbers, 0 if dx0 is None else dx0.shape[1])
    p = len(d.order)
    e, de = np.empty((samples, m)), np.empty((samples, m, p))
    x, z, f = np.empty((samples, n)), np.empty((samples, laws)), np.empty((samples, laws))
    c = np.ascontiguousarray
    first = np.zeros(n) if x0 is None else c(x0, dtype=float)
    dfirst = np.zeros((n, p)) if dx0 is None else c(dx0[:, d.order])
    memories = np.zeros(laws) if z0 is None else c(z0, dtype=float)
    ramps = (~assembly.held).astype(float)
    own, u, between, du = predicting(plant), trial.u, trial.between, np.zeros((0, 0, 0))
    codes, dnumbers = addresses(assembly.laws), d.numbers
    if plant.driven is not None:
        told = p if dx0 is not None else d.numbers.shape[2]
        begun = averages.start if x0 is None and averages.start is not None else first
        more, du = _simulated(
            codes, numbers, plant, trial, begun, memories, begin_s, ramps, assembly.scales,
            d.simulated, d.numbers, dfirst[:, :told], z,
        )  # fmt: skip
        f[:], none = more[:, :laws], 0 * more[:, laws:]
        u, between = np.hstack([u, more[:, :laws], none]), np.hstack([between, more])
        ramps = np.concatenate([ramps, np.zeros(more.shape[1])])
        codes, numbers, dnumbers = codes[:0], numbers[:0], dnumbers[:0]
        memories, z_out, f_out = memories[:0], z[:, :0].copy(), f[:, :0].copy()
    else:
        z_out, f_out = z, f
    predict(
        codes, step_matrix(own), read_matrix(own),
        np.vstack([own.system.drift, own.system.rate]), numbers,
        gain_matrices(gain), _trust(gain, averages.blur), c(u), c(between), du, c(trial.y),
        first, memories, begin_s, own.steps, trial.step_s, ramps, c(assembly.scales),
        d.step, d.read, d.gain, dnumbers, dfirst, d.order, e, de, x, z_out, f_out,
    )  # fmt: skip
    return Run(e, de, x, z, f, gain, plant, averages)


def _simulated(
    codes: NDArray[np.int64], numbers: Array, plant: Sampled, trial: Trial, x0: Array, z0: Array,
    begin_s: float, ramps: Array, scales: Array, dstep: Array, dnumbers: Array, dx0: Array,
    z: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Return the filtered forces of the simulated laws as inputs, (samples, 3 l), and derivatives.

    The memories before each sample are filled in.
    """
    assert plant.driven is not None
    samples, laws, p = len(trial.y), len(numbers), dx0.shape[1]
    weights, c = plant.driven.weights, np.ascontiguousarray
    parts = samples * plant.steps + weights.shape[1]
    f, df = np.empty((parts, laws)), np.empty((parts, laws, p))
    ports = np.vstack([plant.system.drift, plant.system.rate])
    simulate(codes, simulation_matrix(plant), ports, numbers, c(trial.between), x0, z0, begin_s,
             plant.steps, trial.step_s, ramps, c(scales), dstep, dnumbers, c(dx0), f, df,
             z)  # fmt: skip
    out, dout = np.empty((samples, 3 * laws)), np.empty((samples, 3 * laws, p))
    filtered(f, df, weights, plant.steps, out, dout)
    return out, dout if p else np.zeros((0, 0, 0))


def _trust(gain: Gains, blur: Array | None) -> Array:
    """Return S (S + B)^-1 of every sample, (samples, m, m); none where nothing is blurred."""
    if blur is None:
        return np.zeros((0, 0, 0))
    S = gain.innovation[np.minimum(np.arange(len(blur)), len(gain.innovation) - 1)]
    m = S.shape[1]
    trust = np.broadcast_to(np.eye(m), S.shape).copy()
    hit = np.flatnonzero(np.any(blur > SHARP * np.diagonal(S, axis1=1, axis2=2), axis=1))
    wide = S[hit].copy()
    wide[:, range(m), range(m)] += blur[hit]
    trust[hit] = np.linalg.solve(wide, S[hit]).swapaxes(1, 2)
    return trust


def open_loop(gain: Gains) -> Gains:
    """Return gains that listen to nothing: the predictor is then a simulation."""
    return Gains(0 * gain.state[-1:], 0 * gain.held[-1:], gain.innovation, gain.predicted)
