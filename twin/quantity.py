"""The quantities that a channel can measure, each with its SI unit."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """One kind of channel.

    Attributes:
        words: what it is called in a sentence.
        unit: SI unit, as it is written behind a channel's name.
        examples: units to suggest.
    """

    words: str
    unit: str
    examples: str


QUANTITIES = {
    "force": Quantity("force", "N", "[N], [kN], [lbf]"),
    "torque": Quantity("torque", "N m", "[N m], [N mm], [lbf in]"),
    "acc": Quantity("acceleration", "m/s^2", "[m/s^2], [g], [mm/s^2]"),
    "vel": Quantity("velocity", "m/s", "[m/s], [mm/s], [in/s]"),
    "disp": Quantity("displacement", "m", "[m], [mm], [in]"),
    "angle": Quantity("angle", "rad", "[rad], [deg]"),
    "rate": Quantity("angular rate", "rad/s", "[rad/s], [deg/s], [rpm]"),
    "angacc": Quantity("angular acceleration", "rad/s^2", "[rad/s^2], [deg/s^2]"),
    "strain": Quantity("strain", "m/m", "[m/m], [um/m], [microstrain]"),
    "voltage": Quantity("voltage", "V", "[V], [mV]"),
    "current": Quantity("current", "A", "[A], [mA]"),
    "pressure": Quantity("pressure", "Pa", "[Pa], [kPa], [bar]"),
    "number": Quantity("number", "1", "[1], [%]"),
}
"""By kind. A channel of a quantity that is not here has the kind "other" and a unit of its own."""

OTHER = "other"

SI_UNIT = {kind: quantity.unit for kind, quantity in QUANTITIES.items()}
"""The SI unit of each kind of channel."""

KIND_NAMES = {kind: quantity.words for kind, quantity in QUANTITIES.items()}
"""What each kind is called in a sentence."""

KIND_OF_UNIT = {quantity.unit: kind for kind, quantity in QUANTITIES.items()}
"""The kind that each SI unit says."""
