"""Modal parameters and how to compare mode shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

NODE_FRACTION = 0.05
"""A component smaller than this share of the largest is a node and never the scale of a shape."""


@dataclass(frozen=True)
class ModalModel:
    """Natural frequencies, damping ratios and mode shapes, in the order of frequency.

    Examples:
        >>> shapes = np.array([[0.5, 1.0], [1.0, -0.5]])
        >>> modes = ModalModel(np.array([2.0, 6.0]), np.array([0.01, 0.02]), shapes, ("a", "b"))
        >>> modes.mode_shape[:, 1].real.tolist()
        [1.0, -0.5]

    Attributes:
        natural_freq: undamped natural frequencies [Hz], (modes,).
        damping_ratio: damping ratios, dimensionless, (modes,).
        mode_shape: complex mode shapes, one column a mode, (outputs, modes).
        outputs: what the rows of ``mode_shape`` are ("floor1", "acc_floor1").
        natural_freq_std: standard deviations [Hz] or None, (modes,).
        damping_ratio_std: standard deviations or None, (modes,).

    Source: eqs. (8)-(10), (47)-(48); names after sdypy's SEP 2.
    """

    natural_freq: Array
    damping_ratio: Array
    mode_shape: ComplexArray
    outputs: tuple[str, ...]
    natural_freq_std: Array | None = None
    damping_ratio_std: Array | None = None

    def __post_init__(self) -> None:
        for name in ("natural_freq", "damping_ratio", "natural_freq_std", "damping_ratio_std"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name), float))
        object.__setattr__(self, "mode_shape", frozen(self.mode_shape, complex))
        if self.mode_shape.shape != (len(self.outputs), len(self.natural_freq)):
            raise ValueError(
                f"mode_shape has shape {self.mode_shape.shape}, expected "
                f"({len(self.outputs)} outputs, {len(self.natural_freq)} modes)"
            )

    @property
    def poles(self) -> ComplexArray:
        """Continuous-time poles with positive imaginary part [rad/s], (modes,)."""
        omega = 2 * np.pi * self.natural_freq
        return np.asarray(
            -self.damping_ratio * omega + 1j * omega * np.sqrt(1 - self.damping_ratio**2 + 0j)
        )

    @property
    def amplitude(self) -> Array:
        """Relative amplitudes rho_j of eq. (8), (outputs, modes)."""
        return np.abs(normalised(self.mode_shape))

    @property
    def phase(self) -> Array:
        """Relative phases Theta_j of eq. (8) [rad], in (-pi, pi], (outputs, modes)."""
        return np.angle(normalised(self.mode_shape))


def poles_to_modal(poles: ComplexArray) -> tuple[Array, Array]:
    """Return natural frequencies [Hz] and damping ratios of continuous-time poles [rad/s]."""
    magnitude = np.abs(poles)
    return magnitude / (2 * np.pi), -np.real(poles) / np.where(magnitude > 0, magnitude, 1)


def normalised(shapes: ComplexArray) -> ComplexArray:
    """Scale each column as the paper does: its first component that is no node becomes 1."""
    shapes = np.asarray(shapes, complex)
    size = np.abs(shapes)
    peak = size.max(axis=0, initial=0.0)
    if not np.all(peak > 0):
        raise ValueError("a mode shape is zero everywhere")
    reference = np.argmax(size >= NODE_FRACTION * peak, axis=0)
    return np.asarray(shapes / shapes[reference, np.arange(shapes.shape[1])])


def mac(a: ComplexArray, b: ComplexArray) -> Array:
    """Modal assurance criterion between the columns of a and b, (modes of a, modes of b).

    MAC = |a^H b|^2 / (a^H a)(b^H b): 1 for the same shape, whatever its scale or phase.

    Examples:
        >>> mac(np.array([[1.0], [2.0]]), np.array([[-2.0, 2.0], [-4.0, -1.0]])).round(3).tolist()
        [[1.0, 0.0]]

    Source: Allemang and Brown, 1982.
    """
    a, b = np.atleast_2d(np.asarray(a)), np.atleast_2d(np.asarray(b))
    cross = np.abs(a.conj().T @ b) ** 2
    power_a = np.sum(np.abs(a) ** 2, axis=0)
    power_b = np.sum(np.abs(b) ** 2, axis=0)
    return np.asarray(cross / np.outer(power_a, power_b))
