"""The plant: a frame with its pendulum at full nonlinearity, and what the truth may differ by."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin import compiling
from twin.contract import names_in
from twin.control.absorber import GROUND, PENDULUM, SHAKE_TABLE, DesignModel
from twin.control.perturbation import Perturbation
from twin.errors import ControlError, available
from twin.linearise import linearise
from twin.model import Twin
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]

TORQUE = "torque_pendulum"
ANGLE = "angle_pendulum"


@dataclass(frozen=True)
class Plant:
    """A rig under control.

    Attributes:
        twin: the frame with its pendulum; clamped or not is decided by what excites it.
        known_input: "force_floor1", "force_ground" (the bolts of the ground are undone) or
            "acc_ground" (on a shake table).
        delay: whole samples between reading and acting.
        torque_limit: of the motor [N m].
        perturbation: how the truth differs from the model file.

    Raises:
        ControlError: the model lacks the pendulum's names, the message says which and what it
            has; the delay or the torque limit cannot be.
    """

    twin: Twin
    known_input: str = "force_ground"
    delay: int = 1
    torque_limit: float = 0.5
    perturbation: Perturbation = field(default_factory=Perturbation)

    def __post_init__(self) -> None:
        have = names_in(compiling.as_written(self.twin.mjcf, self.twin.source))
        lacks = [
            f"{kind} {name}"
            for kind, name in (("actuator", TORQUE), ("sensor", ANGLE))
            if name not in have[kind]
        ]
        if lacks:
            raise ControlError(
                f"{self.twin.source}: no absorber to control, it lacks {' and '.join(lacks)}; it "
                f"has actuators {available(have['actuator'])}; sensors {available(have['sensor'])}"
            )
        choices = [f"force_{floor}" for floor in self.twin.floors]
        if self._has_suspension:
            choices.append("force_ground")
        choices.append(SHAKE_TABLE)
        if self.known_input not in choices:
            raise ControlError(
                f"{self.twin.source}: cannot be excited by '{self.known_input}'; there is "
                f"{available(choices)}"
            )
        if self.delay < 0:
            raise ControlError(f"the delay must not be negative, not {self.delay}")
        if not self.torque_limit > 0:
            raise ControlError(f"the motor's limit must be positive, not {self.torque_limit:g} N m")

    @property
    def rig(self) -> Twin:
        """The twin with its ground as the excitation needs it."""
        return self.twin.released() if self.known_input == "force_ground" else self.twin

    def perturbed(self, perturbation: Perturbation, extra_delay: int = 0) -> Plant:
        """Return the plant with another truth, its computation later by ``extra_delay`` samples."""
        return replace(self, perturbation=perturbation, delay=self.delay + extra_delay)

    def compile(self) -> mujoco.MjModel:
        """Return the model to simulate: its actuators integrate (``twin.compiling``)."""
        table = ("x",) if self.known_input == SHAKE_TABLE else ()
        rig = self.rig
        model = compiling.driven(rig.mjcf, rig.source, rig.clamped, table, rig.mechanisms)
        self.perturbation.apply(model)
        return model

    def linear(self) -> DesignModel:
        """Return the linearised truth: what a controller would believe that knows everything."""
        rig = self.rig
        if self.known_input == SHAKE_TABLE and self._has_suspension:
            rig = rig.released()
        model = rig.compile()
        self.perturbation.apply(model)
        return DesignModel.of(linearise(model).second_order(), self.known_input)

    @property
    def _has_suspension(self) -> bool:
        return GROUND in compiling.joints(self.twin.mjcf, self.twin.source)


def frame_frequencies(model: SecondOrderModel, count: int = 2) -> tuple[float, ...]:
    """Return the first natural frequencies of the frame [Hz], as many as it has, at most ``count``.

    Left out are the mode in which the pendulum swings and, on a free ground, the one in which
    everything moves on the suspension: those that store most of their energy there.
    """
    modes = model.undamped_modes()
    shapes = np.real(modes.mode_shape)
    total = np.einsum("ir,ij,jr->r", shapes, model.K, shapes)
    pendulum = model.coordinates.index(PENDULUM)
    together = np.array([float(name != PENDULUM) for name in model.coordinates])
    leave = {int(np.argmax(model.K[pendulum, pendulum] * shapes[pendulum] ** 2 / total))}
    if GROUND in model.coordinates:
        ground = shapes[model.coordinates.index(GROUND)]
        suspension = (together @ model.K @ together) * ground**2 / total
        suspension[list(leave)] = 0
        leave.add(int(np.argmax(suspension)))
    kept = [f for mode, f in enumerate(modes.natural_freq) if mode not in leave]
    return tuple(float(f) for f in kept[:count])
