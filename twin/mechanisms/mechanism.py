"""The abstract families of mechanisms: what a structure may have that its model has not.

A mechanism has a place and parameters. It says twice what it does, once as an edit of the MuJoCo
model (``apply``) and once as mathematics (``edit``, ``force``, ``distort``), so that estimators can
work with it without a simulation; a test holds the two together. A place is a port: a named row p
on the model's coordinates q. With a port's motion d, its rate v and the time t, the equation of
motion of a structure with mechanisms is

    M q'' + R q' + K q + sum_j p_j f_j(d_j, v_j, z_j, t) = B u,     d_j = p_j^T q,

where structural changes edit M, R, K and may add coordinates, and laws add forces f_j. Channel
faults leave the motion alone and change what is recorded of it. Parameter values may be arrays.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Literal, Self, TypeVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError, available
from twin.estimation.laws import Law as Compiled
from twin.mechanisms.instrument import Instrument
from twin.mechanisms.surroundings import Surroundings as Surroundings
from twin.mechanisms.units import of_port
from twin.model.linear import LinearModel
from twin.parameter import Parameter
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]
Verdict = Literal["parameter", "missing_physics", "measurement", "unexplained"]
On = Literal["drift", "motion", "body", "base", "channel", "channels", "actuator"]
"""What a mechanism can sit on: a relative motion, an absolute one, a body, channels, ..."""

INPUTS = frozenset({"force", "torque"})
OUTPUTS = frozenset({"acc", "vel", "disp", "angle", "rate", "angacc", "strain", "voltage", "other"})
"""Quantities of channels: what is applied, what is measured."""

MOTOR_OF = {"pendulum": "torque_pendulum"}
"""The actuator of a place that does not bear the actuator's own name."""

Model = TypeVar("Model", LinearModel, SecondOrderModel)


@dataclass(frozen=True)
class Mechanism(ABC):
    """One piece of physics at one place.

    Attributes:
        place: a port ("storey1", "column3", "floor2.rz"), a body or a site, the base ("ground",
            "ground.y"), a channel, or "channel_a+channel_b".
    """

    name: ClassVar[str]
    verdict: ClassVar[Verdict]
    on: ClassVar[On]
    parameters: ClassVar[Mapping[str, Parameter]]
    reference: ClassVar[str]
    mjcf: ClassVar[str] = ""
    """What the exported MJCF cannot hold of it, or empty."""
    generic: ClassVar[bool] = False
    """True for what stands for no physics of its own and is tried only when nothing else fits."""
    also_named: ClassVar[str] = ""
    """The mechanism that it is by another name: at its places, that one is not looked for."""
    stage: ClassVar[int] = 1
    """Mechanisms of a lower stage edit first: masses and the base before what depends on them."""
    valleys: ClassVar[int] = 1
    """How many of its first guesses are worth following."""
    shifts_resonance: ClassVar[bool] = False
    """True where its own natural frequency changes with its strength."""
    prior: ClassVar[Mapping[str, tuple[float, float]]] = {}
    """What is known of a parameter beforehand: mean and standard deviation."""
    shares: ClassVar[Mapping[str, tuple[str, float, float]]] = {}
    """Parameters known as a share of another one: that one, and the share's mean and deviation."""
    port_unit: ClassVar[str] = "m"
    """The unit of the port's motion that the parameters' units are written for."""
    fields_of: ClassVar[Mapping[str, str]] = {}
    """The field that holds a parameter, where the parameter's name is that of a method."""

    place: str

    def priors(self) -> Mapping[str, tuple[float, float]]:
        """Return mean and deviation of parameters known beforehand, of logarithms where scaled."""
        return self.prior

    @classmethod
    def units(cls, port_unit: str) -> dict[str, str]:
        """Return each parameter's unit at a port whose motion is in "m" or in "rad"."""
        return {n: of_port(p.unit, cls.port_unit, port_unit) for n, p in cls.parameters.items()}

    @property
    def values(self) -> dict[str, float]:
        """The parameters' values by name."""
        return {name: getattr(self, self.fields_of.get(name, name)) for name in self.parameters}

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Return the mechanism with other parameter values (floats or arrays)."""
        return replace(self, **{self.fields_of.get(n, n): v for n, v in values.items()})

    def forms(self) -> tuple[Self, ...]:
        """Return it in every form that it may have with the same parameters."""
        return (self,)

    def scaled(self, factor: float) -> Self:
        """Return it so many times as strong: of a family that says nothing, its first parameter."""
        return self._times(factor, next(iter(self.parameters)))

    def _times(self, factor: float, *names: str) -> Self:
        return self.with_values({name: factor * self.values[name] for name in names})

    def as_json(self) -> dict[str, Any]:
        """Return name, place and all fields as plain types; ``mechanisms.from_json`` reads it."""
        names = {field: name for name, field in self.fields_of.items()}
        values = {names.get(f.name, f.name): getattr(self, f.name) for f in fields(self)}
        plain = {name: float(value) for name, value in values.items() if name != "place"}
        return {"mechanism": self.name, "location": self.place, "values": plain}

    @classmethod
    @abstractmethod
    def starts(cls, place: str, around: Surroundings) -> tuple[Self, ...]:
        """Return first guesses at a place: only where a fit starts, never what decides."""

    def apply(self, spec: mujoco.MjSpec) -> None:  # noqa: B027 - channel faults edit nothing
        """Edit the MuJoCo model.

        Raises:
            ModelError: the model has no such place; the message lists those it has.
        """


@dataclass(frozen=True)
class StructuralChange(Mechanism):
    """A linear change of the structure: an edit of M, R, K that may add coordinates."""

    @abstractmethod
    def edit(self, model: Model) -> Model:
        """Return the linear model with the change.

        Raises:
            ModelError: the model has no such place.
        """

    def light(self, frequencies: Sequence[float]) -> tuple[Self, ...]:
        """Return it tuned to frequencies [Hz]; none where it has no resonance of its own."""
        return ()


@dataclass(frozen=True)
class Law(Mechanism):
    """A force against a port's motion that is not linear in it.

    Attributes of the class:
        memory: how many internal states the law has.
        abrupt: True where the force has corners, so that an integration needs finer steps.
        jumps: True where the force itself jumps, which an analyser's filter shows as far from it.
        elastic: True where the force is a function of the displacement alone.
        at_times: True where there is none over a range of displacements, its error neither.
        harmonics: up to which a motion of one frequency makes its force, but for its corners.
    """

    memory: ClassVar[int] = 0
    resolved_by: ClassVar[str] = ""
    """Parameter that is no property of the structure: how sharply an estimate resolves a corner."""
    abrupt: ClassVar[bool] = False
    jumps: ClassVar[bool] = False
    elastic: ClassVar[bool] = False
    at_times: ClassVar[bool] = False
    harmonics: ClassVar[int] = 3
    law: ClassVar[Callable[..., Any]]
    """f(drift, rate, sum of the memory, time, *numbers), for numbers and arrays that broadcast."""
    flow: ClassVar[Callable[..., Any] | None] = None
    """z(memory, which, before, after, *numbers): one internal state after a change of drift."""

    @property
    def numbers(self) -> tuple[Any, ...]:
        """Every field but the place, in order: the law's last arguments."""
        return tuple(getattr(self, f.name) for f in fields(self) if f.name != "place")

    def parted(self) -> tuple[Self, float]:
        """Return the law without the stiffness that it takes over, and that [N/m], negative."""
        taken = sum(self.values[name] for name in self.shares)
        return self.with_values(dict.fromkeys(self.shares, 0.0)), -taken

    @property
    def compiled(self) -> Compiled:
        """The law as the predictor steps it."""
        return Compiled(type(self).law, type(self).flow, len(self.numbers), max(self.memory, 1))

    def force(self, drift: Array, rate: Array, memory: Array, time: Array | float) -> Array:
        """Return the force that opposes positive drift [N], with the sum of the internal states."""
        return np.asarray(type(self).law(drift, rate, memory, time, *self.numbers))

    def includes(self, other: Mechanism) -> bool:
        """Return whether another mechanism only corrects the form of this one."""
        return False

    def remember(self, memory: Array, before: Array, after: Array) -> Array:
        """Return the internal states, (memory, ...), after the drift has changed."""
        flow: Any = type(self).flow
        return np.array([flow(z, i, before, after, *self.numbers) for i, z in enumerate(memory)])


@dataclass(frozen=True)
class Disturbance(Mechanism):
    """An unmeasured force (on the ground: an acceleration): white noise through a filter."""

    @abstractmethod
    def oscillator(self) -> tuple[float, float, float]:
        """Return frequency [Hz], bandwidth [Hz] and rms [N, or m/s^2 at the ground]."""

    @abstractmethod
    def shaping(self) -> tuple[Array, Array, Array]:
        """Return A (k, k), b (k,) and c (k,): s' = A s + b w, the force is c^T s."""


@dataclass(frozen=True)
class ChannelFault(Mechanism):
    """What an instrument does to its channel.

    It states what it does to whole histories (``distort``) and, where it can be undone, the inverse
    (``undo``). For an estimator it is a linear system from quantity to reading (``instrument``),
    taken back (``in_samples``), or samples to leave out (``spoiled``, ``noise``, ``found``).

    Attributes of the class:
        of_kinds: quantities of the channels that can have it (``twin.quantity``).
        of_motor: True for a motor's: ``distort`` turns what was commanded into what it delivers.
        in_samples: True where an estimator changes the samples by ``undo`` (``distort``).
        fitted: False where it is read off the samples and nothing of it is estimated.
        like_jumps: True where it cannot be told from a law that jumps by the samples alone.
        ranged: True where each recording has its own strength of what it adds.
    """

    ranged: ClassVar[bool] = False
    fitted: ClassVar[bool] = True
    like_jumps: ClassVar[bool] = False
    in_samples: ClassVar[bool] = False
    of_kinds: ClassVar[frozenset[str]] = OUTPUTS
    of_motor: ClassVar[bool] = False

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that are faulty."""
        if self.of_motor:
            return (MOTOR_OF.get(self.place, self.place),)
        return tuple(self.place.split("+"))

    @abstractmethod
    def distort(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels as the faulty instrument records them, each (samples,).

        Raises:
            ModelError: there is no such channel; the message lists those there are.
        """

    def instrument(self, rms: float) -> Instrument | None:
        """Return it as a linear system from quantities to readings of a known RMS, if it is."""
        return None

    def spoiled(self, reading: Array) -> NDArray[np.bool_]:
        """Return the samples that it hides, (samples,); they are left out, not explained."""
        return np.zeros(len(reading), bool)

    def noise(self) -> float:
        """Return the standard deviation of white noise that it adds to its channel."""
        return 0.0

    @classmethod
    def found(cls, place: str, reading: Array, rate_hz: float) -> Self | None:
        """Return the fault as a channel's samples, (samples,), show it, None where they do not."""
        return None

    def moment(self, time: Array) -> Array:
        """Return when the quantity was what is recorded at a time [s]."""
        return time

    def undo(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return the channels as a sound instrument would have recorded them."""
        return dict(columns)

    def limit(self) -> float | None:
        """Return the end of the channel's range, if it clips."""
        return None

    def exceeded(self, reading: Array) -> bool:
        """Return whether the channel's range does not end there in this recording."""
        return False

    def _change(
        self, columns: Mapping[str, Array], function: Callable[[Array], Array]
    ) -> dict[str, Array]:
        """Return the channels with a function applied to those that are faulty."""
        for channel in self.channels:
            if channel not in columns:
                raise ModelError(f"no channel '{channel}'; there are {available(columns)}")
        return {**columns, **{name: function(columns[name]) for name in self.channels}}
