"""Every number the paper prints, with its equation and the digits it is printed with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Printed:
    """A number as it stands in the paper.

    Attributes:
        equation: where it stands: "(47)", or "Sec. V" for a number in running text.
        symbol: what it is.
        text: its digits as printed, an exponent written as ``e``.
        unit: SI unit, empty for a dimensionless number.
    """

    equation: str
    symbol: str
    text: str
    unit: str = ""

    @property
    def value(self) -> float:
        """The number."""
        return float(self.text)

    @property
    def half_unit(self) -> float:
        """Half a unit of the last printed digit: the most that rounding can have changed it."""
        exponent = Decimal(self.text).as_tuple().exponent
        assert isinstance(exponent, int)
        return 0.5 * 10.0**exponent

    def met_by(self, value: float) -> bool:
        """True where ``value`` rounds to the printed digits."""
        return abs(value - self.value) <= self.half_unit * (1 + 1e-9)

    def cut_from(self, value: float) -> bool:
        """True where the printed digits are those of ``value`` with the rest cut off."""
        return 0 <= abs(value) - abs(self.value) < 2 * self.half_unit and value * self.value >= 0


def values(numbers: Sequence[Printed]) -> Array:
    """Return the printed numbers as an array, (len(numbers),)."""
    return np.array([number.value for number in numbers])


def half_units(numbers: Sequence[Printed]) -> Array:
    """Return half a unit of each number's last digit, (len(numbers),)."""
    return np.array([number.half_unit for number in numbers])


def symmetric(entries: Array) -> Array:
    """Return the symmetric (2, 2) matrix with the entries (11, 12, 22)."""
    return np.array([[entries[0], entries[1]], [entries[1], entries[2]]])


def upper(matrix: NDArray[Any]) -> NDArray[Any]:
    """Return the entries (11, 12, 22) of a (2, 2) matrix."""
    return np.array([matrix[0, 0], matrix[0, 1], matrix[1, 1]])


def _matrix(
    equation: str, symbol: str, texts: tuple[str, str, str], unit: str
) -> tuple[Printed, ...]:
    return tuple(
        Printed(equation, f"{symbol}_{index}", text, unit)
        for index, text in zip(("11", "12", "22"), texts, strict=True)
    )


FREQUENCY_RANGE = Printed("Sec. II", "range up to", "15", "Hz")
MASS = (Printed("(5)", "m_1", "0.65", "kg"), Printed("(5)", "m_2", "1.55", "kg"))
YOUNG_MODULUS = Printed("(7)", "E", "2.0e11", "N/m^2")
SECOND_MOMENT = Printed("(7)", "J", "2.917e-12", "m^4")
BEAM_LENGTH = Printed("(7)", "L", "300e-3", "m")

LUMPED_FREQUENCY = (Printed("(9)", "f_n,1", "1.949", "Hz"), Printed("(10)", "f_n,2", "6.715", "Hz"))
LUMPED_AMPLITUDE = (Printed("(9)", "rho_1", "1.812"), Printed("(10)", "rho_2", "0.231"))
LUMPED_PHASE = (Printed("(9)", "Theta_1", "0", "rad"), Printed("(10)", "Theta_2", "3.141", "rad"))

SAMPLING = Printed("Sec. V", "f_s", "32", "Hz")
DURATION = Printed("Sec. V", "T_s", "32", "s")
TIME_STEP = Printed("Sec. V", "time step", "3.125e-2", "s")
NYQUIST = Printed("Sec. V", "f_N", "16", "Hz")
CUT_OFF = Printed("Sec. V", "f_c", "16", "Hz")
ORDER = Printed("Sec. V", "order", "4")

FREQUENCY = (Printed("(47)", "f_n,1", "1.912", "Hz"), Printed("(48)", "f_n,2", "6.847", "Hz"))
DAMPING = (Printed("(47)", "xi_1", "0.0118"), Printed("(48)", "xi_2", "0.0039"))
AMPLITUDE = (Printed("(47)", "rho_1", "0.937"), Printed("(48)", "rho_2", "2.180"))
PHASE = (Printed("(47)", "Theta_1", "0.1076", "rad"), Printed("(48)", "Theta_2", "-3.1642", "rad"))
MODAL = FREQUENCY + DAMPING + AMPLITUDE + PHASE
"""The eight numbers of (47)-(48): f, xi, rho, Theta of both modes."""

PROPORTIONAL = (
    Printed("(49)", "alpha", "0.1752", "1/s"),
    Printed("(49)", "beta", "3.4355e-5", "s"),
)
MASS_MATRIX = _matrix("(50)", "M", ("1.3005", "-0.0846", "0.5663"), "kg")
STIFFNESS_MATRIX = _matrix("(51)", "K", ("1047.3", "-824.1", "841.6"), "N/m")
DAMPING_MATRIX = _matrix("(52)", "R", ("72.8876", "-45.6374", "46.3942"), "N s/m")
IMPROVED_DAMPING_MATRIX = _matrix("(53)", "R", ("0.3955", "-0.0485", "0.1838"), "N s/m")

GRAVITY = Printed("(56)", "g", "9.81", "m/s^2")
HALF_LENGTH = Printed("(56)", "l", "82.5e-3", "m")
PENDULUM_MASS = Printed("(56)", "m_3", "0.083", "kg")
PENDULUM_INERTIA = Printed("(56)", "I_zz,3", "8.32e-4", "kg m^2")
FORCE_AMPLITUDE = (Printed("(57)", "F_0,1", "0.1", "N"), Printed("(57)", "F_0,2", "0.1", "N"))
FORCE_FREQUENCY = (Printed("(57)", "f_1", "1.9", "Hz"), Printed("(57)", "f_2", "6.8", "Hz"))
CONTROL_DURATION = Printed("Sec. VI", "T_s", "64", "s")
CONTROL_START = Printed("Sec. VI", "control from", "32", "s")
CONTROL_STEP = Printed("Sec. VI", "time step", "3.125e-2", "s")
REDUCTION = (
    Printed("(60)", "x_1 reduced by", "76.93", "%"),
    Printed("(60)", "x_2 reduced by", "65.78", "%"),
)
