"""Exact modal damping: one fixed tendon a mode.

With mass-normalised shapes phi_r and R = sum_r 2 zeta_r omega_r (M phi_r)(M phi_r)^T every mode has
the damping ratio asked for and the shapes stay real. A tendon with coefficients M phi_r and damping
2 zeta_r omega_r is one term of that sum. Its coefficients belong to joints that are drifts of the
storeys, never to the ground's, so it does not resist the frame sliding as a whole.
"""

from __future__ import annotations

import math
from typing import Protocol

import mujoco
import numpy as np

from twin.errors import ModelError
from twin.frame.mjcf import Document, add, comment
from twin.linearise import Linearisation, linearise

DIGITS = 8
"""Significant digits of eigenvectors in the file: the same file whatever the machine's rounding."""

NOTHING = 1e-9
"""A coefficient below this share of its mode's largest is rounding, and left out."""


class Damped(Protocol):
    """A design that says how its modes are damped."""

    def modal_damping(self, mode: int, omega: float) -> float:
        """Return the damping ratio of a mode (from 0) with angular frequency omega [rad/s]."""


def clamped_linearisation(document: Document) -> Linearisation:
    """Linearise the document's structure with its ground fast.

    Raises:
        ModelError: the frame does not compile, for instance with a mass that is next to nothing.
    """
    spec = mujoco.MjSpec.from_string(document.text())
    for element in (spec.equality("clamp"), spec.joint("ground")):
        if element is not None:
            spec.delete(element)
    try:
        return linearise(spec.compile())
    except ValueError as error:
        raise ModelError(f"FrameDesign: does not compile: {error}") from None


def add_modal_damping(document: Document, design: Damped, frame: Linearisation) -> None:
    """Add the damping tendons of a clamped frame without pendulum.

    Args:
        document: gets one tendon a mode.
        design: has the damping ratios.
        frame: the same frame, clamped and undamped.

    Raises:
        ModelError: the frame buckles under its own weight.
    """
    joints = [
        joint.get("name", "")
        for joint in document.section("worldbody").iter("joint")
        if joint.get("name") != "ground"
    ]
    eigenvalues, shapes = np.linalg.eigh(_whitened(frame))
    if eigenvalues[0] <= 0:
        raise ModelError("FrameDesign: the frame buckles under its own weight")
    factor = np.linalg.cholesky(frame.generalised.M)
    # M phi in the freedoms y, spread over the joints: the smallest coefficients that do it.
    loads = np.linalg.pinv(frame.basis).T @ factor @ shapes
    for mode, eigenvalue in enumerate(eigenvalues):
        omega = math.sqrt(eigenvalue)
        ratio = design.modal_damping(mode, omega)
        tendons = document.section("tendon")
        comment(tendons, f"mode {mode + 1}: {omega / (2 * math.pi):.4g} Hz, damping {ratio:.4g}")
        tendon = add(
            tendons,
            "fixed",
            damping=_rounded(2 * ratio * omega),
        )
        load = _signed(loads[:, mode])
        least = NOTHING * np.abs(load).max()
        for name, coefficient in zip(joints, load, strict=True):
            if abs(coefficient) <= least:
                continue
            add(tendon, "joint", joint=name, coef=_rounded(coefficient))


def _whitened(frame: Linearisation) -> np.ndarray:
    """K in coordinates in which M is the identity."""
    factor = np.linalg.cholesky(frame.generalised.M)
    half = np.linalg.solve(factor, frame.generalised.K)
    whole = np.linalg.solve(factor, half.T)
    return np.asarray((whole + whole.T) / 2)


def _signed(load: np.ndarray) -> np.ndarray:
    """Make the first large coefficient positive; the largest may be two that differ by rounding."""
    size = np.abs(load)
    return load * np.sign(load[np.argmax(size > size.max() / 2)])


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
