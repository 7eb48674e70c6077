"""A hypothesis: the twin, mechanisms at ports, and what no law explains, as one state-space model.

    M q'' + R q' + K q = B u - sum_j p_j (f_j(d_j, v_j, z_j, t) + g_j(t)) + n,    d_j = p_j^T q
    y = Cd q + Cv q' + Ca q'' + Cu u + h + v

with g_j the discrepancy at the port of each law (a latent force), h that of a channel which sees a
law jump (an analyser's filter smears jumps, and no law is an exact jump), n process noise, v noise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.blurring import CUT_OFF, smear
from twin.diagnosis.discrepancy import Discrepancy, error_of, port_of, smeared_outputs, unknowns_at
from twin.diagnosis.mending import as_read
from twin.diagnosis.parts import parts_of, yielding
from twin.diagnosis.plant import structure_of
from twin.diagnosis.plants import Plants, in_each, plants_at, start_covariance
from twin.diagnosis.problem import Problem
from twin.diagnosis.scales import Scales
from twin.diagnosis.straight import ringing
from twin.diagnosis.unknowns import mechanism_at, unknowns_of
from twin.estimation.laws import MOST_NUMBERS
from twin.estimation.model import Assembly, Trial, Unknown
from twin.estimation.ringing import Ringing
from twin.estimation.system import Noise, System
from twin.mechanisms.mechanism import ChannelFault, Law, Mechanism

Array = NDArray[np.float64]

KEPT = 4
"""Plants that are kept: those of a point and of a step from it."""

RANGED = 1.0
"""Prior deviation of the logarithm of what an instrument adds to one recording over what it adds to
others: ranges of an amplifier are set to each, in steps of two to three."""


@dataclass(frozen=True)
class Hypothesis:
    """A twin with mechanisms; it is a ``Model`` of the likelihood.

    Attributes:
        problem: the estimation problem.
        mechanisms: with the values about which their priors lie.
        priors: of each mechanism's parameters: name -> (mean, deviation), of the logarithm where
            its scale is "log", of the share where it is known as one.
        scales: of force, displacement and rate at each law's port, by place.
        begun: of each recording, the state of the structure that laws may begin near, if known.
    """

    problem: Problem
    mechanisms: tuple[Mechanism, ...] = ()
    priors: tuple[dict[str, tuple[float, float]], ...] = ()
    scales: Scales | None = None
    begun: tuple[Array | None, ...] = field(default=(), compare=False)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """The laws among the mechanisms."""
        return tuple(m for m in self.mechanisms if isinstance(m, Law))

    @cached_property
    def ports(self) -> tuple[str, ...]:
        """Ports of laws, found or held by the model, each once: there stands a latent force."""
        laws = (law for law in self._every_law if not law.at_times)
        return tuple(dict.fromkeys(self.port_of(law.place) for law in laws))

    @cached_property
    def erring(self) -> tuple[str, ...]:
        """Ports where all laws act at times, and err only then: one discrepancy is at a port."""
        places = dict.fromkeys(self.port_of(law.place) for law in self._every_law)
        return tuple(place for place in places if place not in self.ports)

    def port_of(self, place: str) -> str:
        """Return the port where the discrepancy of laws at a port stands."""
        return port_of(place, self._every_law, self.problem.model)

    @cached_property
    def smeared(self) -> tuple[str, ...]:
        """Outputs that see the force of a law that jumps: there stands a discrepancy, too."""
        return smeared_outputs(self._every_law, self.problem.model)

    @property
    def _every_law(self) -> tuple[Law, ...]:
        return (*self.laws, *(m for m in self.problem.known if isinstance(m, Law)))

    @property
    def blurred(self) -> bool:
        """Whether a law has corners."""
        return any(law.abrupt for law in self._every_law)

    @property
    def jumps(self) -> bool:
        """Whether the force of a law jumps."""
        return any(law.jumps for law in self._every_law)

    @property
    def stirs(self) -> bool:
        """Whether samples do not show all that a law does: jumps, fast modes, harmonics.

        A law leans on modes above half the sampling rate, too: stepped with more damping than their
        own they would give way late, and a spring would damp.
        """
        most = max((law.harmonics for law in self._every_law), default=0)
        leans = bool(self._every_law) and self.problem.rings
        return self.jumps or leans or self.problem.folds(most)

    @property
    def simulated(self) -> bool:
        """Whether laws are simulated and seen through the analyser's filter."""
        return self.stirs and self.problem.low_pass is not None

    @property
    def doubted(self) -> tuple[str, ...]:
        """Ports and outputs where a discrepancy stands."""
        return (*self.ports, *self.smeared)

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The recordings."""
        return self.problem.trials

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Base, mechanisms, discrepancies, noise levels and what is ranged, in this order."""
        out = list(self.problem.base_unknowns)
        for mechanism, priors in zip(self.mechanisms, self.priors, strict=True):
            out += unknowns_of(mechanism, priors)
        for place in self.doubted:
            if place in self.smeared:
                size, quick = self.problem.readings[place], CUT_OFF * self.problem.sampling_hz / 2
            else:
                size, quick = self.around(place)[0], self.middle_hz
            out += unknowns_at(place, size, quick, place not in self.smeared)
        out += map(error_of, self.erring)
        ranged = [
            Unknown(f"{m.name} {m.place} in {r.name}", 0.0, RANGED, True, "system", t)
            for m in self._ranged
            for t, r in enumerate(self.problem.recordings)
        ]
        return (*out, *self.problem.noise_unknowns, *ranged)

    @property
    def _ranged(self) -> list[ChannelFault]:
        """What instruments add, where several recordings have each its own strength of it."""
        faults = [m for m in self.mechanisms if isinstance(m, ChannelFault) and m.ranged]
        return faults if len(self.problem.recordings) > 1 else []

    @cached_property
    def middle_hz(self) -> float:
        """Geometric mean of the natural frequencies in the band [Hz]."""
        inside = self.problem.frequencies
        inside = inside[(inside > 0) & (inside < self.problem.sampling_hz / 2)]
        return float(np.exp(np.mean(np.log(inside)))) if len(inside) else 1.0

    def at(self, z: Array) -> tuple[Mechanism, ...]:
        """Return the mechanisms at values z of all unknowns, (p,)."""
        values = self._values(z, len(self.problem.base_unknowns))
        return tuple(mechanism_at(mechanism, values) for mechanism in self.mechanisms)

    @cached_property
    def first_latent(self) -> int:
        """Where the unknowns of discrepancies begin."""
        return len(self.problem.base_unknowns) + sum(len(m.parameters) for m in self.mechanisms)

    def latent(self, z: Array) -> list[Discrepancy]:
        """Return the latent forces and readings at values z, (p,)."""
        return self._latent(self._values(z, self.first_latent))

    def _values(self, z: Array, first: int) -> Iterator[float]:
        """Return the values of the unknowns from one of them on, in SI units."""
        return (u.value(float(x)) for u, x in zip(self.unknowns[first:], z[first:], strict=True))

    def _latent(self, rest: Iterator[float]) -> list[Discrepancy]:
        """Take the latent forces and readings from values that begin with theirs."""
        return [Discrepancy(place, *islice(rest, 2 if place in self.smeared else 3))
                for place in self.doubted]  # fmt: skip

    def assemble(self, z: Array) -> Assembly:
        """Return systems, noise levels and laws at values z, (p,)."""
        problem = self.problem
        mechanisms = (*self.at(z), *problem.known_at(z))
        rest = self._values(z, self.first_latent)
        plants, starts = self._plants(z, self._latent(rest))
        shares = dict(zip(self.erring, islice(rest, len(self.erring)), strict=True))
        noises = []
        for t, (recording, start) in enumerate(zip(problem.recordings, starts, strict=True)):
            output = np.fromiter(islice(rest, len(problem.model.outputs)), float)
            moving = recording.driven
            input_noise = np.zeros(len(moving))
            told = np.fromiter(islice(rest, int(moving.sum())), float)
            # of what was read no more than all was noise: what more is missing is no instrument's
            input_noise[moving] = told / np.hypot(1.0, told / problem.input_readings[t, moving])
            system = plants.stepped[plants.which[t]].system
            process = np.full(system.W.shape[1] - len(moving), next(rest))
            noises.append(Noise(np.concatenate([input_noise, process]), output, start))
        laws = tuple(m for m in mechanisms if isinstance(m, Law))
        numbers = np.zeros((len(laws), MOST_NUMBERS))
        for row, law in zip(numbers, laws, strict=True):
            bare = law.parted()[0].numbers
            row[: len(bare)] = bare
        steps, scales = self._stepping
        return Assembly(
            tuple(plant.system for plant in plants.stepped), plants.which, tuple(noises),
            tuple(law.compiled for law in laws), numbers, scales, steps,
            np.concatenate([problem.held, np.zeros(problem.pseudo_forces, bool)]),
            self._trials(z, mechanisms),
            low_pass=problem.low_pass if self.simulated else None,
            own=tuple(plant.system for plant in plants.own),
            ringing=self._ringing if plants.own else None,
            errors=tuple(shares.get(self.port_of(law.place), 0.0) for law in laws),
            begun=self.begun,
        )  # fmt: skip

    @cached_property
    def _stepping(self) -> tuple[int, Array]:
        """Parts of a sample in which laws are stepped, and scales at their ports, (l, 4)."""
        problem, places = self.problem, [law.place for law in self._every_law]
        scales = np.array([(*self.around(place), 1.0) for place in places]).reshape(-1, 4)
        steps = parts_of(problem, scales[:, :3], self.simulated)
        if self.simulated:  # laws that follow the estimated motion are seen as it is at the samples
            scales[:, 3] = yielding(problem, places, problem.step_s / steps)
        return steps, scales

    def around(self, place: str) -> tuple[float, float, float]:
        """Return the scales of force, displacement and rate at a law's port."""
        known = self.problem.known_scales
        if known is not None and place in known.by_port:
            return known.at(place)
        assert self.scales is not None
        return self.scales.at(place)

    def _trials(self, z: Array, mechanisms: Sequence[Mechanism]) -> tuple[Trial, ...]:
        """Return the recordings, what is at fault in their samples taken back."""
        faults = [m for m in mechanisms if isinstance(m, ChannelFault)]
        if not (faults or self.problem.calmed):
            return self.problem.trials
        key = self._key(z, "system", "samples")
        if key not in self._seen:
            structure = None
            if self.problem.calmed:
                base = self.problem.base(z[: len(self.problem.base_unknowns)])
                structure = structure_of(base, mechanisms)
            if len(self._seen) >= KEPT:
                self._seen.clear()
            self._seen[key] = as_read(self.problem, faults, structure)
        return self._seen[key]

    @cached_property
    def _ringing(self) -> Ringing:
        """Modes above half the sampling rate as the laws drive them."""
        return ringing(self.problem.model, [f.place for f in self._every_law], self.problem.step_s)

    @cached_property
    def _kept(self) -> dict[tuple[float, ...], tuple[Plants, tuple[Array, ...]]]:
        return {}

    @cached_property
    def _seen(self) -> dict[tuple[float, ...], tuple[Trial, ...]]:
        return {}

    def _key(self, z: Array, *roles: str) -> tuple[float, ...]:
        """Return the values of the unknowns that have one of these roles."""
        return tuple(float(x) for x, u in zip(z, self.unknowns, strict=True) if u.role in roles)

    def _plants(self, z: Array, latent: Sequence[Discrepancy]) -> tuple[Plants, tuple[Array, ...]]:
        """Return the plants, and the covariance of each recording's first state.

        Steps in noise levels and in laws' numbers ask for the same ones again.
        """
        key = self._key(z, "system")
        if key in self._kept:
            return self._kept[key]
        base = z[: len(self.problem.base_unknowns)]
        every = (*self.at(z), *self.problem.known_at(z))
        several = in_each(every, self._ranged, RANGED * z, len(self.problem.recordings))
        plants = plants_at(self.problem, base, several, latent, self.simulated)
        of_each = [plants.stepped[k] for k in plants.which]
        starts = tuple(start_covariance(self.problem, t, own) for t, own in enumerate(of_each))
        if len(self._kept) >= KEPT:
            self._kept.clear()
        self._kept[key] = plants, starts
        return plants, starts

    def blur(self, forces: Array, system: System) -> Array:
        """Return variances by which outputs are uncertain because a law jumps, (samples, m).

        An analyser's filter smears a jump over its neighbours: by how much is what the force at the
        samples differs from its own band-limited version.
        """
        return np.asarray(smear(forces) ** 2 @ (system.F**2).T)
