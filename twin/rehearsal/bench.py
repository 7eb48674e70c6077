"""The plan's recordings with nothing concealed, and what they say of every place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.band import USED_BAND
from twin.diagnosis.drawing import LEAST
from twin.diagnosis.prepare import DAMPING_TOLERANCE
from twin.errors import TwinError
from twin.mechanisms.mechanism import Surroundings
from twin.model import Twin
from twin.model.linear import LinearModel
from twin.recording import Recording
from twin.rehearsal.effects import Effect, effects_of, every_place
from twin.rehearsal.plan import SHARE, Noise, Plan
from twin.rehearsal.recordings import INPUTS, recorded
from twin.rehearsal.responses import motion
from twin.rehearsal.sensitivity import Known
from twin.rehearsal.whitening import Trial

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Bench:
    """A twin and the plan's training recordings of it.

    Attributes:
        twin: the structure, its ground released where a force drives it.
        plan: what is done.
        model: its linear equations with the plan's inputs and outputs.
        recordings: training recordings.
        kinds: channel -> quantity.
    """

    twin: Twin
    plan: Plan
    model: LinearModel
    recordings: tuple[Recording, ...]
    kinds: Mapping[str, str]

    @classmethod
    def of(cls, twin: Twin, plan: Plan, seed: int) -> Bench:
        """Carry the plan out with nothing concealed.

        Raises:
            TwinError: the twin has no such place or sensor, or noise is told of no channel.
        """
        every = recorded(twin, plan, seed)
        inputs = tuple(sorted({name for r in every for name in r.inputs}))
        outputs = tuple(
            n for n in every[0].outputs if n not in inputs and all(n in r.names for r in every)
        )
        if not outputs:
            raise TwinError("sensors: no output channel that all recordings have")
        if "force_ground" in inputs and twin.clamped:
            twin = twin.released()
        rate = min(r.sampling_hz for r in every)
        model = twin.linear(inputs, outputs, rate / USED_BAND)
        kinds = {c.name: c.kind for r in every for c in r.channels if c.name in inputs + outputs}
        train = [r for r, t in zip(every, plan.recordings, strict=True) if t.use == "train"]
        return cls(twin, plan, model, tuple(train), kinds)

    @property
    def known(self) -> Known:
        """How well the drawing is known."""
        return Known(self.plan.tolerance or LEAST, self.plan.damping_tolerance or DAMPING_TOLERANCE)

    @cached_property
    def trials(self) -> tuple[Trial, ...]:
        """The training recordings with their noise."""
        return tuple(self._trial(r) for r in self.recordings)

    def _trial(self, recording: Recording) -> Trial:
        u = _matrix(recording, self.model.inputs)
        y = _matrix(recording, self.model.outputs) - self.model.rest
        names = (self.model.inputs, self.model.outputs)
        noises = [
            np.array([self._noise(n, x) for n, x in zip(those, table.T, strict=True)])
            for those, table in zip(names, (u, y), strict=True)
        ]
        return Trial(u, y, noises[0], noises[1], recording.sampling_hz)

    def _noise(self, name: str, values: Array) -> float:
        """Return a channel's standard deviation of noise, in its unit."""
        kind = self.kinds.get(name, "other")
        usual = Noise(0.0 if kind in INPUTS or name in self.model.inputs else SHARE)
        noise = self.plan.noise.get(name, self.plan.noise.get(kind, usual))
        return float(np.hypot(noise.share * np.sqrt(np.mean(values**2)), noise.std))

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Everything that the plan conceals."""
        return self._effects(self.plan)

    @cached_property
    def others(self) -> tuple[Effect, ...]:
        """Everything else that a diagnosis weighs: what is concealed may be taken for it."""
        own = {effect.label for effect in self.effects}
        every = self._effects(replace(self.plan, mechanisms=None, places=None))
        return tuple(effect for effect in every if effect.label not in own)

    def _effects(self, plan: Plan) -> tuple[Effect, ...]:
        there = every_place(plan, self.model, self.kinds)
        places = dict.fromkeys(place for names in there.values() for place in names)
        return effects_of(plan, self.model, self.kinds, {p: self.around(p) for p in places})

    @cached_property
    def _motions(self) -> list[tuple[Array, Array]]:
        return [motion(self.model, t.u, t.rate_hz) for t in self.trials]

    @cached_property
    def _compliance(self) -> Array:
        return np.asarray(np.linalg.pinv(self.model.K), float)

    @cached_property
    def _frequencies(self) -> Array:
        """Natural frequencies of what a spring holds [Hz]."""
        w2 = np.linalg.eigvals(np.linalg.solve(self.model.M, self.model.K)).real
        held = w2[w2 > 1e-6 * np.max(w2, initial=0.0)]
        return np.asarray(np.sqrt(np.sort(held)) / (2 * np.pi), float)

    def around(self, place: str) -> Surroundings:
        """Return the scales at a place while the plan is carried out."""
        model, row = self.model, np.zeros(len(self.model.coordinates))
        hz = self._frequencies
        slowest = 2 * np.pi * float(hz[0] if len(hz) else 1.0)
        base = place in model.places("base")
        total = sum(body.mass for body in model.bodies.values())
        mass, height = total, 1.0
        if base:
            axis = model.base[model.base_axis(place)]
            total = axis.mass
            row, mass = axis.row / axis.mass, max(axis.fixed_mass, 0.02 * total)
        elif place in model.ports:
            row, height = model.port(place), model.port_of(place).height
            mass = 1 / float(row @ np.linalg.solve(model.M, row))
        elif place in model.bodies:
            rows = model.bodies[place].translation
            row = rows[int(np.argmax(np.linalg.norm(rows, axis=1)))]
        if place in model.bodies:
            mass = model.bodies[place].mass
        seen = 0.0 if base else float(row @ self._compliance @ row)
        stiffness = 1 / seen if seen > 0 else slowest**2 * max(mass, total if base else 0.0)
        readings = [r.column(place) for r in self.recordings if place in r.names]
        return Surroundings(
            stiffness=stiffness,
            damping=2 * 0.01 * stiffness / slowest,
            mass=mass,
            mass_above=total,
            height=height,
            drift=np.concatenate([q @ row for q, _ in self._motions]),
            rate=np.concatenate([v @ row for _, v in self._motions]),
            reading=np.concatenate(readings) if readings else np.zeros(1),
            natural_frequencies=tuple(float(f) for f in hz),
            duration_s=max(r.duration_s for r in self.recordings),
            sampling_hz=min(r.sampling_hz for r in self.recordings),
        )


def _matrix(recording: Recording, names: Sequence[str]) -> Array:
    """Return channels as columns, (samples, names), zero where the recording has none."""
    zero = np.zeros(recording.samples)
    return np.column_stack([recording.column(n) if n in recording.names else zero for n in names])
