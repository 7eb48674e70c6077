"""The weakest effect that an ideal test would name: the likelihood ratio of the true model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import ndtri

from experiments.concealed.chain import Chain
from experiments.concealed.columns import change, frame
from experiments.concealed.likelihood import Left, Likelihood, nats
from experiments.concealed.mechanisms import Mechanism, places
from experiments.concealed.plans import Test, draw_plan
from experiments.concealed.rehearsal import Rehearsal
from experiments.concealed.rig import TWO_STOREY, Array, Rig

CANDIDATES = len(places(TWO_STOREY.storeys))
"""Mechanisms and places that the test tells apart: 41."""

FALSE_ALARM = 0.01
FOUND = 0.9

GAP, RATIO = 0.3, 0.02
"""A play's gap as a share of the middle recording's peak drift; an appendage's damping ratio."""

CLOSE, ROUNDS, FARTHEST = 0.02, 12, 30.0
"""A severity is solved for until its nats are so close, in the logarithm; step of the search."""


@dataclass(frozen=True)
class Pair:
    """A mechanism at a place, and what its severity is.

    Attributes:
        name: of the mechanism.
        place: storey, floor or channel.
        severity: in words.
        unit: of the severity.
        shown: the severity is multiplied by this before it is shown in that unit.
    """

    name: str
    place: str
    severity: str
    unit: str
    shown: float = 1.0

    @property
    def title(self) -> str:
        """Return "coulomb_friction storey2"."""
        return f"{self.name} {self.place}"


PAIRS = (
    Pair("coulomb_friction", "storey2", "force", "mN", 1e3),
    Pair("cubic_stiffness", "storey1", "stiffness", "kN/m^3", 1e-3),
    Pair("quadratic_stiffness", "storey1", "stiffness", "N/m^2"),
    Pair("quadratic_drag", "floor2", "coefficient", "N s^2/m^2"),
    Pair("stiffness_drift", "storey1", "rate", "%/min", 6e3),
    Pair("appendage", "floor1", "mass", "g", 1e3),
    Pair("sensor_delay", "acc_floor2", "delay", "us", 1e6),
    Pair("sensor_highpass", "acc_floor1", "corner", "mHz", 1e3),
    Pair("sensor_gain", "acc_floor1", "gain - 1", "%", 1e2),
    Pair("clearance", "storey1", "stiffness that the play takes", "N/m"),
)
"""One of each kind that a severity alone can set."""


def needed_nats(candidates: int = CANDIDATES, alarm: float = FALSE_ALARM) -> float:
    """Return the mean log likelihood ratio that an ideal test needs to find an effect [nats].

    Of noise alone, the ratio of one candidate beats ln(candidates / alarm) with a probability of
    at most alarm / candidates (Markov's inequality). Of the effect it is normal, mean L, variance
    2 L, and beats that in nine of ten cases if L - 1.2816 sqrt(2 L) is that much.
    """
    half = float(ndtri(FOUND)) / np.sqrt(2)
    return float((half + np.sqrt(half**2 + np.log(candidates / alarm))) ** 2)


@dataclass(frozen=True)
class Bench:
    """A rig as built, its tests and its chain, with nothing concealed yet."""

    rig: Rig
    plan: tuple[Test, ...]
    chain: Chain

    @classmethod
    def draw(
        cls, rng: np.random.Generator, noise: float, length: float = 1.0, seconds: float = 0.0
    ) -> Bench:
        """Draw all of it as a campaign of concealed cases does.

        Args:
            rng: draws.
            noise: standard deviation, as a share of each channel's RMS.
            length: of the recordings, as a share of what was drawn.
            seconds: length of them all [s], instead; 0 leaves it.
        """
        rig = TWO_STOREY.scattered(rng)
        plan = draw_plan(rng, rig.storeys)
        chain = replace(Chain.draw(rng), noise=noise)
        lengths = [seconds or round(4 * test.duration_s * length) / 4 for test in plan]
        tests = zip(plan, lengths, strict=True)
        return cls(rig, tuple(replace(t, duration_s=s) for t, s in tests), chain)

    @cached_property
    def rehearsal(self) -> Rehearsal:
        """The training recordings on the coarse grid."""
        training = tuple(test for test in self.plan if test.name.startswith("train"))
        recorded = tuple(range(1, self.rig.storeys + 1))
        return Rehearsal.of(self.rig, training, self.chain, recorded)

    @cached_property
    def likelihood(self) -> Likelihood:
        """The space in which the noise of outputs and measured force has unit variance."""
        return Likelihood(self.rehearsal)

    @cached_property
    def taken(self) -> Left:
        """What free masses, stiffnesses and dampings take up.

        Dashpots between the floors and the ground are free, too: a test is not told that the
        frame's damping acts in its storeys only, or that it is modal.
        """
        own = frame(self.likelihood, self.rehearsal.healthy)
        return Left([*own, *map(self._dashpot, range(1, self.rig.storeys))])

    def _dashpot(self, floor: int) -> Array:
        """Return what a dashpot between a floor, from 0, and the ground does to the outputs."""
        n, outputs = self.rig.storeys, []
        for i, (_, states) in enumerate(self.rehearsal.healthy):
            force = -np.outer(states[:, n + floor], np.eye(n)[floor])
            outputs.append(self.likelihood.response(i, force))
        return self.likelihood.whitened(outputs)

    def effect(self, pair: Pair, severity: float) -> Mechanism:
        """Return the mechanism with a severity [SI units]."""
        parameters = {"gain": 1 + severity} if pair.name == "sensor_gain" else {}
        if pair.name == "clearance":
            parameters["gap"] = GAP * float(self.rehearsal.scale.drift[int(pair.place[-1]) - 1])
        if pair.name == "appendage":  # midway, in the logarithm, between the frame's two modes
            omega = self.rig.modes[0]
            parameters["frequency"] = float(np.sqrt(omega[0] * omega[1]) / (2 * np.pi))
            parameters["damping_ratio"] = RATIO
        if pair.name != "sensor_gain":
            parameters[_SEVERITY.get(pair.name, pair.severity)] = severity
        return Mechanism(pair.name, pair.place, tuple(parameters.items()))

    def left(self, pair: Pair, severity: float) -> float:
        """Return the nats by which the true model is likelier than the best frame without it."""
        effect = self.effect(pair, severity)
        # a sensor's fault leaves the motion alone
        runs = self.rehearsal.healthy if effect.in_sensor else self.rehearsal.moved([effect])
        return nats(self.taken.of(change(self.likelihood, [effect], runs)))

    def limit(self, pair: Pair, wanted: float = 0.0, start: float = 0.0) -> float:
        """Return the severity at which the true model is so much likelier.

        Args:
            pair: mechanism and place.
            wanted: the nats; 0 for those that an ideal test needs.
            start: a severity to start from; 0 for a typical one.
        """
        wanted, severity = wanted or needed_nats(), start or self._typical(pair)
        power, before = 2.0, (0.0, 0.0)
        for _ in range(ROUNDS):
            point = np.log(severity), np.log(self.left(pair, severity) / wanted)
            if abs(point[1]) < CLOSE:
                break
            if before != (0.0, 0.0) and abs(point[0] - before[0]) > 1e-6:
                # weak effects go with the square; where they do not, the secant says how
                power = np.clip((point[1] - before[1]) / (point[0] - before[0]), 0.5, 4.0)
            before = point
            severity *= float(np.clip(np.exp(-point[1] / power), 1 / FARTHEST, FARTHEST))
        return severity

    def _typical(self, pair: Pair) -> float:
        """Return a severity to start the search from [SI units]."""
        if pair.name in _START:
            return _START[pair.name]
        scale, i = self.rehearsal.scale, int(pair.place[-1]) - 1
        k, d = self.rig.stiffnesses[i], scale.drift[i]
        power = {"coulomb_friction": 1, "clearance": 0, "quadratic_stiffness": -1}
        if pair.name == "quadratic_drag":
            return float(0.01 * self.rig.masses[i] / scale.velocity[i])
        return float(0.005 * k * d ** power.get(pair.name, -2))


_SEVERITY = {"clearance": "stiffness"}
_START = {
    "stiffness_drift": 1e-4, "appendage": 1e-3, "sensor_delay": 1e-4, "sensor_highpass": 0.01,
    "sensor_gain": 0.003,
}  # fmt: skip
