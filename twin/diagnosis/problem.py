"""The estimation problem: a nominal twin, recordings of it, and how well both are known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.arrays import rms_of
from twin.diagnosis.known import OfKnown, unknowns_of, valued
from twin.diagnosis.measured import NOISE_DEVIATION, Load, Measured
from twin.diagnosis.modal_damping import following, modes_of
from twin.diagnosis.parameters import TELLABLE, stiffnesses_of
from twin.diagnosis.scales import Scales
from twin.diagnosis.straight import HoldError, above, noise_gain, spectrum
from twin.diagnosis.trials import hold_errors, trial_of
from twin.estimation.low_pass import LowPass
from twin.estimation.model import Trial, Unknown
from twin.mechanisms.mechanism import Mechanism
from twin.model.geometry import Geometry
from twin.model.linear import LinearModel
from twin.model.port import Body
from twin.model.shaken import with_inertia

Array = NDArray[np.float64]
Between = Literal["band_limited", "linear", "held"]

PROCESS_SHARE, PROCESS_DEVIATION = 1e-3, 2.0
"""Prior of the process noise: a thousandth of the inertia forces, give or take a factor of seven;
a linear structure and its analyser agree to about that."""

LINEAR_PHASE = LowPass(1.0)
"""What an analyser is taken for to begin with: half of the amplitude is left at half the rate."""

VAGUE = 0.5
"""Prior deviation of stiffnesses beyond which modes that no sample shows are not simulated: a
quarter in frequency, so that after a period they are a quarter of one off."""


@dataclass(frozen=True)
class Problem:
    """What is known before any hypothesis.

    Attributes:
        model: the nominal twin, its inputs and outputs those of the recordings.
        recordings: of one sampling rate.
        sampling_hz: samples per second.
        tolerance: prior deviation of stiffnesses and masses, as a share.
        damping_tolerance: the same of modal damping ratios.
        between: what each input does between samples, (r,).
        scale: RMS of the modal displacements of each recording, (recordings, n); the state before
            the first sample is taken as of that size.
        known: mechanisms that the model itself holds, part of every hypothesis: their values are
            as uncertain as dampings, and no more exact a law than any.
        known_scales: of force, displacement and rate at their ports.
        low_pass: the analyser's filter, through which outputs show laws that are simulated: those
            that jump, or stir modes above half the sampling rate; None where they follow motion.
        told: whether the user says the tolerance; if not, it is found from the recordings.
        kinematics: of the model, where large motion would be seen in the recordings.
        large: whether it is seen: the structure moves as its model does when it moves far.
        folding: the structure by which it is judged what outputs miss of aliased inputs
            (``aliased``); the nominal one without.
    """

    model: LinearModel
    recordings: tuple[Measured, ...]
    sampling_hz: float
    tolerance: float
    damping_tolerance: float
    between: tuple[Between, ...]
    scale: Array
    known: tuple[Mechanism, ...] = ()
    known_scales: Scales | None = None
    low_pass: LowPass | None = LINEAR_PHASE
    told: bool = True
    kinematics: Geometry | None = None
    large: bool = True
    folding: LinearModel | None = field(default=None, compare=False)

    @property
    def step_s(self) -> float:
        """Sampling interval [s]."""
        return 1 / self.sampling_hz

    @property
    def geometry(self) -> Geometry | None:
        """What large motion adds, if it is seen."""
        return self.kinematics if self.large else None

    @property
    def samples(self) -> int:
        """Samples of all recordings."""
        return sum(len(r.y) for r in self.recordings)

    @property
    def held(self) -> NDArray[np.bool_]:
        """Which inputs are held from sample to sample, (r,)."""
        return np.array([kind == "held" for kind in self.between])

    @property
    def cornered(self) -> NDArray[np.bool_]:
        """Which inputs have corners at the samples: all but band-limited ones, (r,)."""
        return np.array([kind != "band_limited" for kind in self.between])

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """The recordings as the likelihood sees them."""
        return tuple(trial_of(self, recording) for recording in self.recordings)

    @cached_property
    def hold_errors(self) -> Mapping[Load, HoldError]:
        """What straight lines between samples miss of the nominal twin, with each load."""
        return hold_errors(self, self.model)

    @cached_property
    def spectra(self) -> tuple[NDArray[np.complex128], ...]:
        """Spectra of the smooth inputs of each recording, (., r)."""
        smooth = (np.where(self.cornered, 0.0, recording.u) for recording in self.recordings)
        return tuple(spectrum(u) for u in smooth)

    @property
    def pseudo_forces(self) -> int:
        """How many inputs stand for large motion: one for each coordinate, or none."""
        return 0 if self.geometry is None else len(self.model.coordinates)

    @cached_property
    def feedthrough(self) -> Array:
        """What the inputs do to the outputs at once, (m, r)."""
        model = self.model
        return np.asarray(model.Cu + model.Ca @ np.linalg.solve(model.M, model.B))

    @cached_property
    def readings(self) -> Mapping[str, float]:
        """RMS of every channel over all recordings, by name."""
        levels = rms_of(np.vstack([np.hstack([r.u, r.y]) for r in self.recordings]))
        names = (*self.model.inputs, *self.model.outputs)
        return dict(zip(names, levels.tolist(), strict=True))

    @cached_property
    def frequencies(self) -> Array:
        """Natural frequencies of the nominal coordinates [Hz], (n,)."""
        values = np.linalg.eigvals(np.linalg.solve(self.model.M, self.model.K))
        return np.asarray(np.sqrt(np.maximum(np.sort(values.real), 0)) / (2 * np.pi))

    @cached_property
    def stiffnesses(self) -> tuple[tuple[str, Array, float], ...]:
        """Ports whose stiffness is a parameter: name, row (n,), stiffness seen there [N/m]."""
        return stiffnesses_of(self.model)

    @cached_property
    def masses(self) -> tuple[tuple[str, Body], ...]:
        """Bodies whose mass is a parameter, their moment of inertia in proportion to it."""
        least = TELLABLE * np.linalg.norm(self.model.M)
        return tuple((n, b) for n, b in self.model.bodies.items()
                     if b.mass * np.linalg.norm(b.translation) ** 2 > least)  # fmt: skip

    @cached_property
    def dampings(self) -> tuple[tuple[int, float], ...]:
        """Modes below half the sampling rate whose damping is a parameter: index, R there."""
        w = 2 * np.pi * self.frequencies
        inside = self.frequencies < 0.5 * self.sampling_hz
        least = 2e-3 * w * np.diag(self.model.M)
        return tuple(
            (int(i), float(max(self.model.R[i, i], least[i], 1e-12)))
            for i in np.flatnonzero(inside)
        )

    @cached_property
    def base_unknowns(self) -> tuple[Unknown, ...]:
        """Stiffnesses, masses and dampings of the twin, positive by construction, and its laws'."""
        loose = self.damping_tolerance
        return (
            *(Unknown(f"stiffness {n}", np.log(k), self.tolerance, True)
              for n, _, k in self.stiffnesses),
            *(Unknown(f"mass {n}", np.log(b.mass), self.tolerance, True) for n, b in self.masses),
            *(Unknown(f"damping of mode {i + 1}", np.log(r), loose, True)
              for i, r in self.dampings),
            *(own.unknown for own in self.of_known),
        )  # fmt: skip

    @cached_property
    def of_known(self) -> tuple[OfKnown, ...]:
        """Values of what the model holds, the last of the base unknowns."""
        return unknowns_of(self.known, self.damping_tolerance, self.known_scales)

    def known_at(self, z: Array) -> tuple[Mechanism, ...]:
        """Return what the model holds at values z of the unknowns, base first, (p,)."""
        count = len(self.base_unknowns)
        return valued(self.known, self.of_known, z[count - len(self.of_known) : count])

    @cached_property
    def noise_gain(self) -> Array | None:
        """By what noise stirs each coordinate more than it does in steps, (n,)."""
        return None if np.all(self.cornered) else noise_gain(self.model, self.step_s)

    @cached_property
    def calmed(self) -> bool:
        """Whether modes above half the sampling rate are stepped with more damping than theirs."""
        return not np.all(self.cornered) and bool(np.any(above(self.model, self.step_s)))

    @property
    def rings(self) -> bool:
        """Whether there are such modes, and known well enough that laws are simulated with them."""
        return self.calmed and self.tolerance < VAGUE

    def folds(self, harmonics: int) -> bool:
        """Return whether so many harmonics of what the samples show reach half their rate.

        They are folded then, less what the analyser's filter takes of them: a law that makes them
        is simulated, where the twin is known well enough.
        """
        half = self.sampling_hz / 2
        shown = self.frequencies[self.frequencies < half]
        return self.tolerance < VAGUE and bool(np.any(harmonics * shown > half))

    def base(self, z: Array) -> LinearModel:
        """Return the twin at values z of its base unknowns, (base unknowns,)."""
        key = np.asarray(z, float).tobytes()
        if key not in self._latest:
            self._latest.clear()
            self._latest[key] = self._base(z)
        return self._latest[key]

    @cached_property
    def _nominal_modes(self) -> tuple[Array, Array]:
        return modes_of(self.model.M, self.model.K)

    @cached_property
    def _latest(self) -> dict[bytes, LinearModel]:
        return {}

    def _base(self, z: Array) -> LinearModel:
        K, M = self.model.K.copy(), self.model.M.copy()
        springs = len(self.stiffnesses)
        for x, (_, row, k) in zip(z, self.stiffnesses, strict=False):
            K += k * np.expm1(self.tolerance * x) * np.outer(row, row)
        for x, (_, body) in zip(z[springs:], self.masses, strict=False):
            rows = body.translation
            M += np.expm1(self.tolerance * x) * (body.mass * rows.T @ rows + body.spin)
        R = self.damping(M, K, z)
        return self._with_inertia(replace(self.model, M=M, K=K, R=R), z)

    def damping(self, M: Array, K: Array, z: Array) -> Array:
        """Return the damping matrix at values z of the base unknowns, (n, n).

        Args:
            M: mass matrix of the twin there, (n, n).
            K: its stiffness matrix, (n, n).
            z: the values.
        """
        D = np.array(self.model.R)
        at = len(self.stiffnesses) + len(self.masses)
        for index, r in self.dampings:
            D[index, index] += r * np.expm1(self.damping_tolerance * z[at])
            at += 1
        return following(self.model.M, self._nominal_modes, M, K, D)

    def _with_inertia(self, model: LinearModel, z: Array) -> LinearModel:
        """Return the model with the inertia forces of a shaken base that its masses have."""
        shares = np.expm1(self.tolerance * z[len(self.stiffnesses) :][: len(self.masses)])
        bodies = [body for _, body in self.masses]
        return with_inertia(model, list(zip(bodies, shares.tolist(), strict=True)))

    @cached_property
    def noise_unknowns(self) -> tuple[Unknown, ...]:
        """Noise levels of outputs, inputs and process, of each recording."""
        out = []
        for t, r in enumerate(self.recordings):
            for name, level in zip(self.model.outputs, self.output_levels[t], strict=True):
                out.append(Unknown(f"noise of {name} in {r.name}", float(np.log(level)),
                                   NOISE_DEVIATION, True, "noise", t, True))  # fmt: skip
            for i in np.flatnonzero(r.driven).tolist():
                level = max(r.input_noise[i], 1e-5 * self.input_readings[t, i])
                out.append(Unknown(f"noise of {self.model.inputs[i]} in {r.name}", np.log(level),
                                   r.input_deviation, True, "noise", t, True))  # fmt: skip
            out.append(Unknown(f"process noise in {r.name}", float(np.log(self.process_levels[t])),
                               PROCESS_DEVIATION, True, "noise", t, True))  # fmt: skip
        return tuple(out)

    @cached_property
    def input_readings(self) -> Array:
        """RMS of what was read of each input in each recording, (recordings, r)."""
        return np.array([rms_of(r.u) for r in self.recordings])

    @cached_property
    def output_levels(self) -> Array:
        """Prior means of the outputs' noise, (recordings, m)."""
        least = [1e-5 * rms_of(r.y) + 1e-15 for r in self.recordings]
        return np.maximum([r.output_noise for r in self.recordings], least)

    @cached_property
    def process_levels(self) -> Array:
        """Prior means of the process noise: forces on modal coordinates, (recordings,)."""
        w2 = np.maximum(np.diag(self.model.K), (2 * np.pi / 10) ** 2)
        forces = np.sqrt(np.mean((self.scale * w2) ** 2, axis=1))
        return np.asarray(PROCESS_SHARE * np.maximum(forces, 1e-12))
