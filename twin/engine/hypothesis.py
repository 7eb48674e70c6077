"""A hypothesis: the twin, mechanisms at ports, and what no law explains, as one state-space model.

    M q'' + R q' + K q = B u - sum_j p_j (f_j(d_j, v_j, z_j, t) + g_j(t)) + n,    d_j = p_j^T q
    y = Cd q + Cv q' + Ca q'' + Cu u + v

with g_j the discrepancy at the port of each law (a latent force), n process noise, v noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_lyapunov

from twin.engine.problem import Problem
from twin.engine.scales import Scales
from twin.estimation.laws import MOST_NUMBERS
from twin.estimation.laws import Law as Compiled
from twin.estimation.likelihood import Assembly, Trial, Unknown
from twin.estimation.system import Noise, System
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

SMOOTH_STEPS, CORNER_STEPS = 2, 4
"""Parts of a sample for laws that are smooth, and for those with corners: the midpoint rule's
phase error, (w h)^2 / 12, is below 1e-4 of the law's force at a tenth of the sampling rate."""

START_WIDTH = 3.0
"""Deviation of the state before the first sample, in RMS values of the nominal motion."""

DISCREPANCY_SHARE, DISCREPANCY_DEVIATION = 0.01, 2.0
"""Prior of a law's discrepancy: a hundredth of the forces at its port, give or take a factor of
seven."""


@dataclass(frozen=True)
class Hypothesis:
    """A twin with mechanisms; it is a ``Model`` of the likelihood.

    Attributes:
        problem: the estimation problem.
        mechanisms: with the values about which their priors lie.
        priors: of each mechanism's parameters: name -> (mean, deviation), of the logarithm where
            its scale is "log".
        scales: of force, displacement and rate at each law's port, by place.
    """

    problem: Problem
    mechanisms: tuple[Mechanism, ...] = ()
    priors: tuple[dict[str, tuple[float, float]], ...] = ()
    scales: Scales | None = None

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """The laws among the mechanisms."""
        return tuple(m for m in self.mechanisms if isinstance(m, Law))

    @cached_property
    def ports(self) -> tuple[str, ...]:
        """Ports of the laws, each once: there stands a discrepancy."""
        return tuple(dict.fromkeys(law.place for law in self.laws))

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The recordings."""
        return self.problem.trials

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Base, mechanisms, discrepancies, noise levels, in this order."""
        out = list(self.problem.base_unknowns)
        for mechanism, priors in zip(self.mechanisms, self.priors, strict=True):
            role: Any = "law" if isinstance(mechanism, Law) else "system"
            for name, parameter in mechanism.parameters.items():
                mean, deviation = priors[name]
                title = f"{mechanism.name} {mechanism.place} {name}"
                out.append(Unknown(title, mean, deviation, parameter.scale == "log", role))
        for port in self.ports:
            assert self.scales is not None
            level = DISCREPANCY_SHARE * self.scales.at(port)[0]
            out.append(Unknown(f"discrepancy {port}", float(np.log(level)),
                               DISCREPANCY_DEVIATION, True))  # fmt: skip
            out.append(Unknown(f"discrepancy {port} frequency", float(np.log(self.middle_hz)),
                               1.0, True))  # fmt: skip
        return (*out, *self.problem.noise_unknowns)

    @cached_property
    def middle_hz(self) -> float:
        """Geometric mean of the natural frequencies in the band [Hz]."""
        inside = self.problem.frequencies
        inside = inside[(inside > 0) & (inside < self.problem.sampling_hz / 2)]
        return float(np.exp(np.mean(np.log(inside)))) if len(inside) else 1.0

    def at(self, z: Array) -> tuple[Mechanism, ...]:
        """Return the mechanisms at values z of all unknowns, (p,)."""
        index = len(self.problem.base_unknowns)
        out = []
        for mechanism in self.mechanisms:
            values = {}
            for name in mechanism.parameters:
                values[name] = self.unknowns[index].value(float(z[index]))
                index += 1
            out.append(mechanism.with_values(values))
        return tuple(out)

    def assemble(self, z: Array) -> Assembly:
        """Return systems, noise levels and laws at values z, (p,)."""
        problem = self.problem
        values = [u.value(float(x)) for u, x in zip(self.unknowns, z, strict=True)]
        base = problem.base(z[: len(problem.base_unknowns)])
        mechanisms = self.at(z)
        at = len(problem.base_unknowns) + sum(len(m.parameters) for m in self.mechanisms)
        latent = []
        for port in self.ports:
            latent.append((port, values[at], values[at + 1]))
            at += 2
        groups: dict[tuple[tuple[str, float], ...], int] = {}
        systems: list[System] = []
        which = []
        for recording in problem.recordings:
            key = tuple(sorted(recording.added_mass.items()))
            if key not in groups:
                groups[key] = len(systems)
                systems.append(self._system(self._heavier(base, recording.added_mass),
                                            mechanisms, latent))  # fmt: skip
            which.append(groups[key])
        noises = []
        n = len(problem.model.coordinates)
        for t, recording in enumerate(problem.recordings):
            m = len(problem.model.outputs)
            output = np.array(values[at : at + m])
            at += m
            moving = np.any(recording.u, axis=0)
            input_noise = np.zeros(len(moving))
            input_noise[moving] = values[at : at + int(moving.sum())]
            at += int(moving.sum())
            system = systems[which[t]]
            process = np.full(system.W.shape[1] - len(moving), values[at])
            at += 1
            noises.append(Noise(np.concatenate([input_noise, process]), output,
                                self._start(t, system, n)))  # fmt: skip
        laws = tuple(m for m in mechanisms if isinstance(m, Law))
        numbers = np.zeros((len(laws), MOST_NUMBERS))
        scales = np.ones((len(laws), 3))
        for j, law in enumerate(laws):
            assert self.scales is not None
            numbers[j, : len(law.numbers)] = law.numbers
            scales[j] = self.scales.at(law.place)
        steps = 1
        if laws:
            steps = CORNER_STEPS if any(law.abrupt for law in laws) else SMOOTH_STEPS
        compiled = tuple(Compiled(type(law).law, type(law).flow, len(law.numbers)) for law in laws)
        return Assembly(tuple(systems), tuple(which), tuple(noises), compiled, numbers, scales,
                        steps, problem.held)  # fmt: skip

    def _heavier(self, model: LinearModel, added: Any) -> LinearModel:
        for name, mass in added.items():
            rows = model.bodies[name].translation
            model = model.adding(M=mass * rows.T @ rows)
        return model

    def _start(self, trial: int, system: System, n: int) -> Array:
        """Return the covariance of the state before the first sample."""
        size = len(system.A)
        own = len(self.problem.scale[trial])
        rms = np.zeros(size)
        q = START_WIDTH * self.problem.scale[trial] + 1e-12
        w = (
            2
            * np.pi
            * np.maximum(np.sqrt(np.abs(np.diag(self.problem.model.K))) / (2 * np.pi), 0.1)
        )
        total = self._coordinates
        rms[:own] = q
        rms[total : total + own] = q * w
        # what hangs on the structure or gives way under it moves at most like the rest
        rms[own:total] = np.max(q)
        rms[total + own : 2 * total] = np.max(q * w)
        out = np.diag(rms**2)
        if size > 2 * total:
            # latent states are stationary
            A, G = system.A[2 * total :, 2 * total :], system.G[2 * total :]
            out[2 * total :, 2 * total :] = solve_continuous_lyapunov(A, -G @ G.T)
        return out

    @cached_property
    def _coordinates(self) -> int:
        model = self.problem.model
        for mechanism in sorted(self.mechanisms, key=lambda m: m.stage):
            if isinstance(mechanism, StructuralChange):
                model = mechanism.edit(model)
        return len(model.coordinates)

    def _system(
        self, model: LinearModel, mechanisms: Sequence[Mechanism],
        latent: Sequence[tuple[str, float, float]],
    ) -> System:  # fmt: skip
        for mechanism in sorted(mechanisms, key=lambda m: m.stage):
            if isinstance(mechanism, StructuralChange):
                model = mechanism.edit(model)
        laws = [m for m in mechanisms if isinstance(m, Law)]
        n = len(model.coordinates)
        lower = -np.linalg.solve(model.M, np.hstack([model.K, model.R]))
        inverse = np.linalg.inv(model.M)
        zero = np.zeros((n, n))
        A = np.vstack([np.hstack([zero, np.eye(n)]), lower])
        C = np.hstack([model.Cd, model.Cv]) + model.Ca @ lower

        def entry(force: Array) -> tuple[Array, Array]:
            """Return what forces on the coordinates do to states and outputs, columns (n, k)."""
            acceleration = inverse @ force
            return np.vstack([0 * acceleration, acceleration]), model.Ca @ acceleration

        B, D = entry(model.B)
        rows = np.array([model.port(law.place) for law in laws]).reshape(len(laws), n)
        E, F = entry(-rows.T)
        disturb, through = entry(np.eye(n))
        W, V = np.hstack([B, disturb]), np.hstack([D + model.Cu, through])
        system = System(
            A, B, C, D + model.Cu, E, F, np.hstack([rows, 0 * rows]), np.hstack([0 * rows, rows]),
            W, V, np.zeros((2 * n, 0)),
        )  # fmt: skip
        for port, rms, frequency in latent:
            rate = 2 * np.pi * frequency
            force, read = entry(-model.port(port)[:, None])
            system = _driven(system, force, read, np.array([[-rate]]),
                             np.array([rms * np.sqrt(2 * rate)]), np.ones(1))  # fmt: skip
        for mechanism in mechanisms:
            if isinstance(mechanism, Disturbance):
                block, drive, shape = mechanism.shaping()
                force, read = self._disturbance(model, mechanism, entry)
                system = _driven(system, force, read, block, drive, shape)
        for mechanism in mechanisms:
            if isinstance(mechanism, ChannelFault):
                system = _through_instrument(system, model, mechanism)
        return system

    @staticmethod
    def _disturbance(model: LinearModel, mechanism: Disturbance, entry: Any) -> tuple[Array, Array]:
        place = mechanism.place
        if place in model.places("base"):
            axis = place.rpartition(".")[2] if "." in place else next(iter(model.base))
            base = model.base[axis]
            force, read = entry(-base.row[:, None])
            return force, read + base.acc[:, None]
        force, read = entry(model.port(place)[:, None])
        return force, read

    def blur(self, trial: int, forces: Array, system: System) -> Array | None:
        """Return variances by which outputs are uncertain because a law jumps, (samples, m).

        An analyser's filter smears a jump over its neighbours: by how much is what the force at the
        samples differs from its own band-limited version.
        """
        if not any(law.abrupt for law in self.laws):
            return None
        from twin.engine.blurring import smear

        return smear(forces) ** 2 @ (system.F**2).T


def _driven(
    system: System, force: Array, read: Array, block: Array, drive: Array, shape: Array
) -> System:
    """Return the system with a force that white noise makes through a filter."""
    n, k = len(system.A), len(block)

    def tall(m: Array) -> Array:
        return np.vstack([m, np.zeros((k, m.shape[1]))])

    def wide(m: Array) -> Array:
        return np.hstack([m, np.zeros((m.shape[0], k))])

    into = np.zeros((n, k))
    into[: len(force)] = force @ shape[None]
    A = np.block([[system.A, into], [np.zeros((k, n)), block]])
    C = np.hstack([system.C, read @ shape[None]])
    column = np.concatenate([np.zeros(n), drive])[:, None]
    return System(
        A, tall(system.B), C, system.D, tall(system.E), system.F, wide(system.drift),
        wide(system.rate), tall(system.W), system.V, np.hstack([tall(system.G), column]),
    )  # fmt: skip


def _through_instrument(system: System, model: LinearModel, fault: ChannelFault) -> System:
    raise NotImplementedError
