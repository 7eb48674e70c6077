"""The damping that an exponential window adds, taken off again.

A record multiplied by exp(-t / tau), force and responses alike, is the record of a structure whose
poles all lie 1 / tau further left: X(s + 1 / tau) is the transform of x(t) exp(-t / tau).

Source: McConnell and Varoto, Vibration Testing (2008), chapter 7.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import IdentificationError
from twin.identification.from_responses import ResponseIdentification
from twin.identification.proportional_damping import proportional_damping
from twin.identification.result import Identification
from twin.modal import ModalModel

Array = NDArray[np.float64]


CERTAIN = 3.0
"""Standard deviations below zero at which what is left of a damping contradicts the window."""


def without_window(modal: ModalModel, tau_s: float) -> tuple[ModalModel, NDArray[np.intp]]:
    """Return modes without the damping of a window exp(-t / tau), and which of them are left.

    A mode of which the window's damping leaves nothing that can be told from zero is left out.

    Args:
        modal: identified from windowed data.
        tau_s: time constant of the window [s].

    Raises:
        IdentificationError: the window damps more than a mode is damped altogether.
    """
    if not (np.isfinite(tau_s) and tau_s > 0):
        raise IdentificationError(f"a window's time constant of {tau_s:g} s is not possible")
    omega = 2 * np.pi * modal.natural_freq
    rate = modal.damping_ratio * omega
    left = rate - 1 / tau_s
    std = modal.damping_ratio_std
    spread = np.zeros(len(omega)) if std is None else std * omega
    for i in np.flatnonzero(left < -CERTAIN * spread):
        raise IdentificationError(
            f"a window of {tau_s:g} s damps more than the mode at {modal.natural_freq[i]:.5g} Hz, "
            f"which decays with {1 / rate[i]:.4g} s: another one was used"
        )
    kept = np.flatnonzero(left > 0)
    if not len(kept):
        raise IdentificationError(f"a window of {tau_s:g} s hides the damping of every mode")
    damped = omega * np.sqrt(1 - modal.damping_ratio**2)
    natural = np.hypot(damped, left)[kept]
    found = ModalModel(
        natural / (2 * np.pi), left[kept] / natural, modal.mode_shape[:, kept], modal.outputs,
        None if modal.natural_freq_std is None else modal.natural_freq_std[kept],
        None if std is None else std[kept],
    )  # fmt: skip
    return found, kept


def identification_without_window(found: Identification, tau_s: float) -> Identification:
    """Return modes and realization of the structure without its window.

    The fit behind them, and what is re-simulated, stay those of the windowed records. M, K and R
    are left out: a windowed acceleration is not the second derivative of a windowed displacement.

    Raises:
        IdentificationError: as of ``without_window``.
    """
    modal, kept = without_window(found.modal, tau_s)
    bounds = [
        None if b is None else b[kept]
        for b in (found.natural_freq_bound, found.damping_ratio_bound)
    ]
    a = 1 / tau_s
    alpha = beta = None
    if len(modal.natural_freq) >= 2:
        alpha, beta = proportional_damping(modal.natural_freq, modal.damping_ratio)
    realized = found.state_space
    # The windowed state w(k) = x(k) exp(-a k dt) obeys w(k+1) = exp(-a dt) (A w(k) + B u(k)).
    growth = float(np.exp(a / found.sampling_hz))
    G = None if realized.G is None else growth * realized.G
    realized = replace(realized, A=growth * realized.A, B=growth * realized.B, G=G)
    return replace(
        found, modal=modal, alpha=alpha, beta=beta, second_order=None,
        second_order_std=None, state_space=realized,
        natural_freq_bound=bounds[0], damping_ratio_bound=bounds[1],
        notes=(*found.notes, *_said(tau_s, found.modal, kept), "M, K and R: not with a window"),
    )  # fmt: skip


def responses_without_window(found: ResponseIdentification, tau_s: float) -> ResponseIdentification:
    """Return the modes of the structure without the window its responses were measured with.

    Raises:
        IdentificationError: as of ``without_window``.
    """
    notes = tuple(n for n in found.notes if "exponential window" not in n)
    modal, kept = without_window(found.modal, tau_s)
    return replace(found, modal=modal, notes=(*notes, *_said(tau_s, found.modal, kept)))


def _said(tau_s: float, modal: ModalModel, kept: NDArray[np.intp]) -> list[str]:
    said = [f"the damping of an exponential window of {tau_s:g} s was taken off"]
    hidden = np.delete(modal.natural_freq, kept)
    if len(hidden):
        at = ", ".join(f"{f:.5g}" for f in hidden)
        said.append(f"the window hides the damping of the modes at {at} Hz: they are left out")
    return said
