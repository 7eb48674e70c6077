"""What the LQG design trades: weights of the regulator, covariances of the estimator."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from twin.errors import ControlError


def _not_negative(owner: object) -> None:
    for item in fields(owner):  # type: ignore[arg-type]
        value = getattr(owner, item.name)
        if not (math.isfinite(value) and value >= 0):
            raise ControlError(
                f"{type(owner).__name__}: {item.name} must not be negative, not {value}"
            )


@dataclass(frozen=True)
class Weights:
    """Weights of the squares in the regulator's cost, floors relative to the ground.

    Attributes:
        displacement: of each floor [1/m^2].
        velocity: of each floor [s^2/m^2]; it weighs high modes more than low ones.
        angle: of the pendulum [1/rad^2].
        angular_rate: of the pendulum [s^2/rad^2].
        torque: of the motor [1/(N m)^2].

    Raises:
        ControlError: a weight is negative, that of the torque zero, or nothing is weighed.
    """

    displacement: float = 1.0
    velocity: float = 0.1
    angle: float = 0.0
    angular_rate: float = 0.0
    torque: float = 0.005

    def __post_init__(self) -> None:
        _not_negative(self)
        if self.torque == 0 or self.displacement + self.velocity == 0:
            raise ControlError("Weights: the torque and the floors' motion need a weight")


@dataclass(frozen=True)
class Covariances:
    """Standard deviations of what the estimator reckons with, white from sample to sample.

    Attributes:
        disturbance: unknown forces on each floor, and on a free ground [N]; they stand for the
            errors of the model, too, and decide how much the estimator trusts it.
        torque: error of the motor's torque [N m].
        known_input: error of the known input [N or m/s^2].
        acceleration: of the accelerometers [m/s^2].
        angle: of the encoder [rad].

    Raises:
        ControlError: one is negative, or there is no noise on a measurement.
    """

    disturbance: float = 0.02
    torque: float = 1e-3
    known_input: float = 1e-3
    acceleration: float = 0.02
    angle: float = 1e-3

    def __post_init__(self) -> None:
        _not_negative(self)
        if self.acceleration == 0 or self.angle == 0 or self.disturbance + self.torque == 0:
            raise ControlError("Covariances: measurements and disturbances need one above zero")
