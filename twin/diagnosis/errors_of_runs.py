"""Errors of simulations on the training and on the test recordings."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Errors:
    """NRMSE of the simulated outputs, pooled over the output channels of all recordings.

    ``stated``: what the training recordings alone let expect of the explained twin, if it was.
    """

    nominal: float
    calibrated: float
    explained: float
    noise_floor: float
    stated: float | None = None


@dataclass(frozen=True)
class Fits:
    """Errors on the training and on the test recordings."""

    train: Errors
    test: Errors

    def stating(self, stated: float | None) -> Fits:
        """Return the errors with what was stated of the test recordings, if anything was."""
        return replace(self, test=replace(self.test, stated=stated))
