"""What an identification found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twin.arrays import frozen
from twin.identification.maximum_likelihood import ModalFit
from twin.identification.stabilisation import StablePole
from twin.modal import ModalModel
from twin.presentable import Presentable, with_deviation
from twin.recording import Recording
from twin.second_order import SecondOrderModel
from twin.state_space import StateSpace

Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Identification(Presentable):
    """An identified linear model, with the uncertainty of every modal parameter.

    Attributes:
        modal: natural frequencies, damping ratios and shapes with standard deviations.
        natural_freq_bound: Cramer-Rao bound of the natural frequencies [Hz], or None, (modes,).
        damping_ratio_bound: Cramer-Rao bound of the damping ratios, or None, (modes,).
        state_space: discrete-time realization at the recording's rate, observer gain included.
        singular_values: of the Hankel matrix of eq. (33), largest first.
        order: number of states kept.
        second_order: M, R, K of eq. (41), or None (the notes say why).
        second_order_std: standard deviations of the entries of M, R and K, or None.
        alpha: mass-proportional damping coefficient of eq. (43) [1/s], or None.
        beta: stiffness-proportional damping coefficient of eq. (43) [s], or None.
        inputs: channels that drive the structure.
        outputs: channels that respond, the rows of every shape.
        sampling_hz: sampling frequency [Hz].
        route: which estimate this is, in words.
        recordings: what it was fitted to.
        predicted: outputs re-simulated from the measured inputs, one array a recording,
            (samples, outputs).
        diagram: the poles of the stabilisation diagram.
        fit: the maximum-likelihood modal fit behind the modal parameters.
        notes: what a reader has to know, one sentence each.
    """

    modal: ModalModel
    state_space: StateSpace
    singular_values: Array
    order: int
    second_order: SecondOrderModel | None
    alpha: float | None
    beta: float | None
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    sampling_hz: float
    route: str
    recordings: tuple[Recording, ...]
    predicted: tuple[Array, ...]
    natural_freq_bound: Array | None = None
    damping_ratio_bound: Array | None = None
    second_order_std: SecondOrderModel | None = None
    diagram: tuple[StablePole, ...] = ()
    fit: ModalFit | None = None
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        object.__setattr__(self, "singular_values", frozen(self.singular_values, float))
        object.__setattr__(self, "predicted", tuple(frozen(p, float) for p in self.predicted))
        for name in ("natural_freq_bound", "damping_ratio_bound"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name), float))

    def _title(self) -> str:
        files = ", ".join(recording.source for recording in self.recordings)
        return f"identified from {files}"

    def _rows(self) -> Iterator[tuple[str, str]]:
        modal = self.modal
        f_std, z_std = modal.natural_freq_std, modal.damping_ratio_std
        for i, (f, z) in enumerate(zip(modal.natural_freq, modal.damping_ratio, strict=True)):
            frequency = f"{f:.6g}" if f_std is None else with_deviation(f, f_std[i])
            damping = f"{100 * z:.4g}" if z_std is None else with_deviation(100 * z, 100 * z_std[i])
            yield f"mode {i + 1}", f"{frequency} Hz, damping {damping} %"
        if self.second_order is not None:
            mass = ", ".join(f"{m:.4g}" for m in np.diag(self.second_order.M))
            yield "masses", f"{mass} kg"
        yield "error", f"{100 * self.nrmse:.2f} % of the outputs' RMS"
        yield "estimate", self.route

    @property
    def nrmse(self) -> float:
        """RMS of the re-simulation's error over RMS of the output, inside the fitted band."""
        measured = [recording.matrix(self.outputs) for recording in self.recordings]
        band = (self.fit.w_min, self.fit.w_max) if self.fit else (0.0, np.inf)
        return band_error(measured, self.predicted, 1 / self.sampling_hz, band)


def band_error(
    measured: Sequence[Array], predicted: Sequence[Array], dt: float, band: tuple[float, float]
) -> float:
    """Return RMS of the error over RMS of the output inside a band, pooled over outputs.

    Args:
        measured: outputs of every record, (samples, outputs).
        predicted: what the model says, alike.
        dt: sampling interval [s].
        band: angular frequencies [rad/s]; what the model does not claim does not count.
    """
    error = power = 0.0
    for y, model in zip(measured, predicted, strict=True):
        omega = 2 * np.pi * np.fft.rfftfreq(len(y), dt)
        inside = (omega >= band[0]) & (omega <= band[1])
        error += float(np.sum(np.abs(np.fft.rfft(y - model, axis=0)[inside]) ** 2)) / len(y)
        power += float(np.sum(np.abs(np.fft.rfft(y, axis=0)[inside]) ** 2)) / len(y)
    return float(np.sqrt(error / power)) if power > 0 else float("nan")
