"""What a likelihood needs to know of a model: recordings, unknowns, and what these make of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from twin.estimation.blows import Blows
from twin.estimation.laws import Law
from twin.estimation.low_pass import LowPass, interpolated
from twin.estimation.ringing import Ringing
from twin.estimation.system import Noise, System

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Trial:
    """One recording as the likelihood sees it.

    Attributes:
        u: inputs at the samples, (samples, r).
        between: inputs as they drive the states in between, (samples, r).
        y: outputs, (samples, m); NaN where there is none.
        step_s: sampling interval [s].
        smooth: inputs that are band-limited between samples, (r,); none without.
        blur: variances of the outputs beside their noise's, (samples, m), if there are any.
        blows: that are in the smooth inputs, if there are any; laws are simulated with them.
        missed: what smooth inputs do to the outputs beyond their lines, (samples, m), if they do;
            it is not in ``y``.
    """

    u: Array
    between: Array
    y: Array
    step_s: float
    smooth: NDArray[np.bool_] | None = None
    blur: Array | None = None
    missed: Array | None = None
    blows: Blows | None = None

    @cached_property
    def rest(self) -> Array:
        """The inputs without what the analyser shows of blows, (samples, r)."""
        if self.blows is None or not self.blows.each:
            return self.u
        return self._beside(self.blows.shown())

    def _beside(self, shown: Array) -> Array:
        out = self.u.copy()
        out[:, : shown.shape[1]] -= shown
        return out

    def until(self, samples: int) -> Trial:
        """Return the first samples alone; with laws that are simulated blows are cut as well."""
        first = slice(samples)
        return replace(
            self, u=self.u[first], between=self.between[first], y=self.y[first],
            blur=None if self.blur is None else self.blur[first],
            missed=None if self.missed is None else self.missed[first],
            blows=self.blows and self.blows.of_part(0, len(self.y[first])),
        )  # fmt: skip

    def finely(self, held: NDArray[np.bool_], steps: int) -> Array:
        """Return the inputs where each part of a sample begins, (samples steps, r).

        Args:
            held: inputs that are held from sample to sample, (r,).
            steps: parts of a sample.
        """
        key = (steps, *held.tolist())
        if key not in self._fine:
            points = np.arange(len(self.u) * steps) / steps
            lines = [np.interp(points, np.arange(len(self.u)), x) for x in self.between.T]
            fine = np.column_stack(lines)
            fine[:, held] = np.repeat(self.between[:, held], steps, axis=0)
            if self.smooth is not None:
                pushes, rest = np.zeros_like(fine), self.u
                if self.blows is not None and self.blows.each:
                    found, shown = self.blows.finely(steps)
                    pushes = np.pad(found, ((0, 0), (0, fine.shape[1] - found.shape[1])))
                    rest = self._beside(shown)
                fine[:, self.smooth] = (interpolated(rest, steps) + pushes)[:, self.smooth]
            self._fine[key] = fine
        return self._fine[key]

    @cached_property
    def _fine(self) -> dict[tuple[int, ...], Array]:
        return {}

    @cached_property
    def missing(self) -> NDArray[np.bool_] | None:
        """Which outputs are missing, to the last gap, (samples, m); None where there is no gap.

        What is missing at the end is none: nothing is predicted after it.
        """
        missing = np.isnan(self.y)
        measured = np.flatnonzero(~missing.all(axis=1))
        gaps = np.flatnonzero(missing[: measured[-1] + 1 if len(measured) else 0].any(axis=1))
        return missing[: gaps[-1] + 1] if len(gaps) else None

    @cached_property
    def begins_without(self) -> NDArray[np.bool_] | None:
        """The same, of the gap that the recording begins with alone."""
        missing = self.missing
        if missing is None or not missing[0].any():
            return None
        whole = np.flatnonzero(~missing.any(axis=1))
        return missing[: whole[0]] if len(whole) else missing


@dataclass(frozen=True)
class Assembly:
    """A model at certain values of its unknowns.

    Attributes:
        systems: the distinct linear systems (recordings with added masses have their own).
        which: index into ``systems`` for each trial.
        noises: noise levels of each trial.
        laws: the laws at the systems' ports, in order.
        numbers: of the laws, (l, MOST_NUMBERS).
        scales: of force, displacement and rate at each law's port, (l, 3).
        steps: parts of a sample in which the laws are stepped.
        held: inputs that are held from sample to sample, (r,).
        trials: the recordings, in whose samples a fault may have been taken back.
        blurs: variances of each recording's outputs beside their noise's, (samples, m), where they
            are known and no law says.
        kicks: by sample, how much less certain each recording's state is before it, (n, n), the
            same.
        errors: share of its force by which each law is off while it acts, (l,), 0 of those that
            have another discrepancy; none where all have.
        low_pass: that the forces of the laws, simulated, pass before they are seen; None where the
            laws follow the estimated motion, and are seen as they are.
        own: the systems as they are simulated, with modes above half the sampling rate that ring
            as they do; none where there are none, or nothing is simulated.
        ringing: what these modes do to the outputs.
        begun: of each recording, a state of the structure before its first sample that laws may
            begin near, displacements, then rates; None, or none, where nothing is known of it.
    """

    systems: tuple[System, ...]
    which: tuple[int, ...]
    noises: tuple[Noise, ...]
    laws: tuple[Law, ...]
    numbers: Array
    scales: Array
    steps: int
    held: NDArray[np.bool_]
    trials: tuple[Trial, ...]
    blurs: tuple[Array | None, ...] = ()
    kicks: tuple[Mapping[int, Array], ...] = ()
    errors: tuple[float, ...] = ()
    low_pass: LowPass | None = None
    own: tuple[System, ...] = ()
    ringing: Ringing | None = None
    begun: tuple[Array | None, ...] = ()

    def near(self, index: int, system: System) -> Array | None:
        """Return the state of a system that laws may begin near in a recording, (n,), if known.

        Coordinates that the structure did not have then, and filters, are at rest.
        """
        known = self.begun[index] if self.begun else None
        if known is None:
            return None
        count, out = len(known) // 2, np.zeros(len(system.A))
        out[:count] = known[:count]
        out[system.coordinates : system.coordinates + count] = known[count:]
        return out


@dataclass(frozen=True)
class Unknown:
    """A number that is estimated; its prior is normal, of its logarithm where it is positive.

    Attributes:
        name: what it is.
        mean, deviation: of the prior (of the logarithm where ``log``).
        log: whether it is estimated through its logarithm.
        role: what it changes: the system, the noise levels alone, the laws' numbers alone, the
            samples themselves (a fault that is taken back in them), or how far laws are off.
        trial: the one recording that it belongs to, or None.
        level: whether it is the standard deviation of a noise or of a latent force, and ``log``.
    """

    name: str
    mean: float
    deviation: float
    log: bool = False
    role: Literal["system", "noise", "law", "samples", "error"] = "system"
    trial: int | None = None
    level: bool = False

    def value(self, z: float) -> float:
        """Return the value that lies z prior deviations above the prior's mean."""
        linear = self.mean + self.deviation * z
        return float(np.exp(linear)) if self.log else float(linear)


class Model(Protocol):
    """What a likelihood needs of a model."""

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """What is estimated."""

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The recordings."""

    def assemble(self, z: Array) -> Assembly:
        """Return the model at values z [prior deviations from the prior's mean], (p,)."""

    @property
    def blurred(self) -> bool:
        """Whether a law makes outputs uncertain beside their noise."""

    def blur(self, forces: Array, system: System) -> Array:
        """Return variances by which outputs are uncertain because of the laws, (samples, m).

        Args:
            forces: of the laws at the samples, (samples, l).
            system: how they enter the outputs.
        """
