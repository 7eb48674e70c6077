"""Small systems with laws for the tests of the estimation room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from twin.estimation.laws import Law
from twin.estimation.low_pass import LowPass
from twin.estimation.model import Assembly, Trial, Unknown
from twin.estimation.system import Noise, System, transition

RATE_HZ = 64.0


def cubic(d, v, z, t, k):
    return k * d**3


def friction(d, v, z, t, force, width):
    return force * np.tanh(v / width)


def bumper(d, v, z, t, k, gap):
    return k * np.maximum(d - gap, 0.0)


def slip(d, v, z, t, k, limit):
    return z


def slipped(z, part, before, after, k, limit):
    return min(max(z + k * (after - before), -limit), limit)


def sliding(d, v, z, t, first, second, one, other):
    return z


def slid(z, part, before, after, first, second, one, other):
    k, limit = (first, one) if part == 0 else (second, other)
    return min(max(z + k * (after - before), -limit), limit)


CUBIC, FRICTION, BUMPER = Law(cubic, None, 1), Law(friction, None, 2), Law(bumper, None, 2)
SLIP, SLIDERS = Law(slip, slipped, 2), Law(sliding, slid, 4, 2)
NUMBERS = {
    CUBIC: [4e5], FRICTION: [0.6, 4e-3], BUMPER: [900.0, 6e-3], SLIP: [300.0, 0.8],
    SLIDERS: [200.0, 100.0, 0.2, 0.6],
}  # fmt: skip
"""Of laws on a mass of 1 kg with 400 N/m that swings by about a centimetre."""


def two_masses(
    k=400.0, ports=((1.0, 0.0),), process=True, latent=None, damping=(0.5, 0.6)
) -> System:
    """Return two masses in a row, force on both, acceleration of both, laws at the ports."""
    M = np.diag([1.0, 0.8])
    K = np.array([[k + 300.0, -300.0], [-300.0, 300.0]])
    R = np.array([[sum(damping), -damping[1]], [-damping[1], damping[1]]])
    lower = -np.linalg.solve(M, np.hstack([K, R]))
    A = np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), lower])
    inverse = np.linalg.inv(M)
    rows = np.array(ports, float).reshape(len(ports), 2)

    def entry(force):
        return np.vstack([np.zeros((2, force.shape[1])), inverse @ force]), inverse @ force

    B, D = entry(np.eye(2)[:, :1])
    W, V = entry(np.eye(2) if process else np.eye(2)[:, :1])
    E, F = entry(-rows.T)
    still = np.zeros_like(rows)
    system = System(A, B, lower, D, E, F, np.hstack([rows, still]), np.hstack([still, rows]),
                    W, V, np.zeros((4, 0)))  # fmt: skip
    return system if latent is None else driven(system, entry(-rows.T[:, :1]), *latent)


def driven(system: System, through, rms: float, rate: float) -> System:
    """Return the system with one latent force, an Ornstein-Uhlenbeck process."""
    tall = lambda m: np.vstack([m, np.zeros((1, m.shape[1]))])  # noqa: E731
    wide = lambda m: np.hstack([m, np.zeros((len(m), 1))])  # noqa: E731
    A = np.block([[system.A, through[0]], [np.zeros((1, 4)), np.array([[-rate]])]])
    G = np.vstack([np.zeros((4, 1)), [[rms * np.sqrt(2 * rate)]]])
    return System(A, tall(system.B), np.hstack([system.C, through[1]]), system.D, tall(system.E),
                  system.F, wide(system.drift), wide(system.rate), tall(system.W), system.V,
                  G)  # fmt: skip


@dataclass(frozen=True)
class TwoMasses:
    """The two masses with laws and noise as a ``Model``: k, laws' numbers, and noise levels."""

    trials: tuple[Trial, ...]
    laws: tuple[Law, ...] = ()
    ports: tuple[tuple[float, float], ...] = ()
    steps: int = 2
    latent: bool = False
    loose: float = 0.1
    low_pass: LowPass | None = None
    yielding: float = 0.0
    errors: bool = False

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        out = [Unknown("stiffness", np.log(400.0), self.loose, True)]
        for j, law in enumerate(self.laws):
            for q, value in enumerate(NUMBERS[law]):
                out.append(Unknown(f"law {j} number {q}", np.log(value), 0.3, True, "law"))
        if self.latent:
            out.append(Unknown("latent force", np.log(0.05), 0.5, True))
        for t in range(len(self.trials)):
            out.append(Unknown(f"output noise {t}", np.log(0.05), 0.5, True, "noise", t, True))
            out.append(Unknown(f"input noise {t}", np.log(0.02), 0.5, True, "noise", t, True))
        if self.errors:
            out.append(Unknown("error", np.log(0.1), 1.0, True, "error", level=True))
        return tuple(out)

    def assemble(self, z):
        values = [u.value(float(x)) for u, x in zip(self.unknowns, z, strict=True)]
        at = 1
        numbers = np.zeros((len(self.laws), 4))
        for j, law in enumerate(self.laws):
            numbers[j, : law.count] = values[at : at + law.count]
            at += law.count
        latent = None
        if self.latent:
            latent, at = (values[at], 20.0), at + 1
        system = two_masses(values[0], self.ports, latent=latent)
        start = np.diag([1e-4, 1e-4, 4e-2, 4e-2, 1.0][: len(system.A)])
        noises = tuple(
            Noise(np.array([values[at + 2 * t + 1], 0.01]), np.full(2, values[at + 2 * t]), start)
            for t in range(len(self.trials))
        )
        scales = np.tile([5.0, 0.01, 0.2, self.yielding], (len(self.laws), 1))
        return Assembly((system,), (0,) * len(self.trials), noises, self.laws, numbers, scales,
                        self.steps, np.zeros(1, bool), self.trials,
                        low_pass=self.low_pass,
                        errors=(values[-1],) * len(self.laws) * self.errors)  # fmt: skip

    blurred = False

    def blur(self, forces, system):
        raise AssertionError("nothing is blurred")


def assert_gradient(model, z, of_spread, rel=0.0):
    """The gradient is that of the likelihood to a share of its own spread, or of itself."""
    from twin.estimation.likelihood import evaluate

    here = evaluate(model, z)
    for i, unknown in enumerate(model.unknowns):
        step = np.zeros(len(z))
        step[i] = 1e-4
        a, b = (evaluate(model, z + s * step, derivatives=False) for s in (1, -1))
        change = (a.log_likelihood - b.log_likelihood) / 2e-4
        spread = np.sqrt(here.information[i, i])
        near = pytest.approx(change, rel=rel, abs=of_spread * spread)
        assert here.gradient[i] == near, unknown.name


def shaken(samples: int, seed: int, laws=(), ports=(), noise=(0.05, 0.02), missing=0.0) -> Trial:
    """Return a recording of the two masses by a fine integration of their laws."""
    from twin.estimation.kalman import gains, open_loop
    from twin.estimation.passing import run
    from twin.estimation.system import sampled

    rng = np.random.default_rng(seed)
    force = np.convolve(rng.normal(size=samples + 8), np.ones(9) / 3, "valid")[:, None] * 4
    numbers = np.zeros((len(laws), 4))
    for j, law in enumerate(laws):
        numbers[j, : law.count] = NUMBERS[law]
    model = TwoMasses((), tuple(laws), tuple(ports))
    here = model.assemble(np.zeros(len(model.unknowns)))
    system = here.systems[0]
    plant = sampled(system, 1 / RATE_HZ, 32, here.held)
    empty = Trial(force, force, np.full((samples, 2), np.nan), 1 / RATE_HZ)
    level = Noise(np.array([0.02, 0.01]), np.full(2, 0.05), np.eye(4))
    fine = run(here, empty, plant, open_loop(gains(plant, level)))
    y = fine.x @ system.C.T + force @ system.D.T + fine.f @ system.F.T
    y = y + noise[0] * rng.normal(size=y.shape)
    y[rng.random(y.shape) < missing] = np.nan
    u = force + noise[1] * rng.normal(size=force.shape)
    return Trial(u, u, y, 1 / RATE_HZ)


def rubbing(u, fine: int, force: float):
    """Two masses with dry friction between them at fine steps: readings (steps, 2) after u."""
    system = two_masses(ports=((-1.0, 1.0),), process=False)
    x, y = np.zeros(4), np.zeros((len(u), 2))
    step, push, _ = transition(
        system.A, np.column_stack([system.B, system.E]), 1 / (RATE_HZ * fine), 0
    )
    still = system.rate[0] @ push[:, 1]
    for k in range(len(u)):
        free = step @ x + push[:, 0] * u[k]
        # dry friction in one implicit step: it stops the motion or opposes it in full
        f = np.clip(-(system.rate[0] @ free) / still, -force, force)
        y[k] = system.C @ x + system.D[:, 0] * u[k] + system.F[:, 0] * f
        x = free + push[:, 1] * f
    return y
