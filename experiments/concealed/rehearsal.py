"""The training tests run on a coarse grid while strengths are drawn: with and without effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .chain import Chain, at_sensor
from .mechanisms import Mechanism
from .motions import Run, motion
from .plans import FINE_HZ, Test
from .rig import Array, Rig
from .strengths import Motion

COARSE = 4
"""Strengths are set, and effects are judged, on a grid this much coarser."""

FARTHEST_M = 0.12
"""No drift goes beyond this: a storey of the frame is 0.3 m high."""


@dataclass(frozen=True)
class Rehearsal:
    """A rig, its training tests and how it moves in them with nothing concealed.

    Attributes:
        rig: as built.
        tests: the training recordings.
        chain: how they are measured.
        recorded: floors whose accelerometers are recorded, from 1.
        drives: what drives each test, on the coarse grid.
        healthy: how the rig moves.
        scale: how far that is.
    """

    rig: Rig
    tests: tuple[Test, ...]
    chain: Chain
    recorded: tuple[int, ...]
    drives: tuple[Array, ...]
    healthy: tuple[Run, ...]
    scale: Motion

    @classmethod
    def of(
        cls, rig: Rig, tests: tuple[Test, ...], chain: Chain, recorded: tuple[int, ...]
    ) -> Rehearsal:
        """Run the tests."""
        runs = [motion(rig, (), test, chain.fine, COARSE) for test in tests]
        healthy = tuple((seen, states) for _, seen, states in runs)
        scale = Motion.of(rig, list(healthy))
        return cls(rig, tests, chain, recorded, tuple(run[0] for run in runs), healthy, scale)

    def moved(self, effects: Sequence[Mechanism]) -> tuple[Run, ...]:
        """Return how the rig moves with effects built in."""
        runs = [motion(self.rig, effects, test, self.chain.fine, COARSE) for test in self.tests]
        return tuple((seen, states) for _, seen, states in runs)

    def given(self, effects: Sequence[Mechanism], runs: Sequence[Run]) -> list[Array]:
        """Return what the recorded sensors give, their faults included."""
        columns = np.array(self.recorded) - 1
        rate = FINE_HZ / COARSE
        return [at_sensor(seen, *effects, rate=rate)[:, columns] for seen, _ in runs]

    def effect(self, effects: Sequence[Mechanism], runs: Sequence[Run]) -> float:
        """Return the largest change of a recording's channels, as a share of their RMS."""
        inputs = [test.input for test in self.tests]
        gains = [abs(m["gain"] - 1) for m in effects if m.location in inputs]
        return max([*self.changes(effects, runs), *gains])

    def changes(self, effects: Sequence[Mechanism], runs: Sequence[Run]) -> list[float]:
        """Return the change of each recording's outputs, pooled over channels."""
        pairs = zip(self.given(effects, runs), self.given((), self.healthy), strict=True)
        with np.errstate(over="ignore", invalid="ignore"):  # of a run that is lost
            return [float(np.sqrt(np.sum((a - b) ** 2) / np.sum(b**2))) for a, b in pairs]

    def physical(self, runs: Sequence[Run]) -> bool:
        """Return whether no drift goes too far; a run that is lost does."""
        n = self.rig.storeys
        farthest = [np.abs(states[:, :n] @ self.rig.drifts.T).max() for _, states in runs]
        return bool(np.max(farthest) < FARTHEST_M)  # NaN fails
