"""A start for a twin whose numbers are not known: its equation of motion fitted to spectra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import build
from twin.diagnosis.trials import Trial
from twin.errors import RecordingError
from twin.mechanisms.mechanism import Mechanism, StructuralChange
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]

PASSES = 8
"""Reweightings (Sanathanan and Koerner 1963): the last one weighs by the model it found."""

BAND = 0.4
"""Share of the sampling rate up to which spectra are used."""


def identified(bench: Bench, base: Hypothesis) -> Hypothesis:
    """Return the base with the changes that fit the gentlest recording's spectra best.

    The equation of motion is linear in the changes of masses, dampings and stiffnesses, so no
    starting value is needed; weighing by the model's own response makes it an output error.

    Args:
        bench: at least one recording with every floor measured.
        base: changes of masses, dampings, stiffnesses.

    Raises:
        RecordingError: a floor is not measured.
    """
    trial = min(bench.trials, key=lambda t: float(np.sqrt(np.mean(t.y**2))))
    spectra = _spectra(bench, trial)
    columns = [_linear_part(bench.model, mechanism) for mechanism in base.base]
    values = np.zeros(len(columns))
    for _ in range(PASSES):
        values = _pass(bench.model, columns, spectra, values)
    changed = tuple(
        m.with_values({"change": float(v)}) for m, v in zip(base.base, values, strict=True)
    )
    return replace(base, base=changed)


Spectra = tuple[Array, NDArray[np.complex128], NDArray[np.complex128]]


def _spectra(bench: Bench, trial: Trial) -> Spectra:
    """Return angular frequencies, displacements and forces at the coordinates, (bins, n)."""
    plant = build(trial.base(bench.model), (), trial.inputs, trial.outputs)
    n = len(plant.model.coordinates)
    window = np.hanning(trial.samples)[:, None]
    Y = np.fft.rfft((trial.y - trial.y.mean(axis=0)) * window, axis=0)
    U = np.fft.rfft((trial.u - trial.u.mean(axis=0)) * window, axis=0)
    omega = np.asarray(2 * np.pi * np.fft.rfftfreq(trial.samples, 1 / trial.sampling_hz), float)
    X: NDArray[np.complex128] = np.zeros((len(omega), n), complex)
    for index, place in enumerate(plant.model.coordinates):
        if f"disp_{place}" in trial.outputs:
            X[:, index] = Y[:, trial.outputs.index(f"disp_{place}")]
        elif f"acc_{place}" in trial.outputs:
            with np.errstate(divide="ignore", invalid="ignore"):
                X[:, index] = -Y[:, trial.outputs.index(f"acc_{place}")] / omega**2
        else:
            raise RecordingError(
                f"{trial.name}: {place} is not measured, so the model's numbers cannot be found "
                f"from nothing; there are {', '.join(trial.outputs)}"
            )
    power = np.sum(np.abs(U) ** 2, axis=1)
    used = (omega > 0) & (omega < 2 * np.pi * BAND * trial.sampling_hz)
    used &= power > 1e-3 * np.max(power)
    F: NDArray[np.complex128] = U @ (plant.model.M @ plant.B[n : 2 * n]).T
    return omega[used], X[used], F[used]


def _linear_part(model: SecondOrderModel, mechanism: Mechanism) -> tuple[Array, Array, Array]:
    """Return what a unit change adds to M, R and K."""
    assert isinstance(mechanism, StructuralChange)
    changed = mechanism.with_values({"change": 1.0}).edit(model)
    return changed.M - model.M, changed.R - model.R, changed.K - model.K


def _pass(
    model: SecondOrderModel,
    columns: list[tuple[Array, Array, Array]],
    spectra: Spectra,
    values: Array,
) -> Array:
    omega, X, F = spectra
    M = model.M + sum(v * c[0] for v, c in zip(values, columns, strict=True))
    R = model.R + sum(v * c[1] for v, c in zip(values, columns, strict=True))
    K = model.K + sum(v * c[2] for v, c in zip(values, columns, strict=True))
    s = 1j * omega[:, None, None]
    weight = np.linalg.inv(s**2 * M + s * R + K) if np.any(values) else np.eye(len(M))

    def seen(m: Array, r: Array, k: Array) -> NDArray[np.complex128]:
        force = np.einsum("bij,bj->bi", s**2 * m + s * r + k, X)
        return np.einsum("...ij,...j->...i", weight, force).reshape(-1)

    target = np.einsum("...ij,...j->...i", weight, F).reshape(-1) - seen(model.M, model.R, model.K)
    A = np.column_stack([seen(*c) for c in columns])
    size = np.linalg.norm(A, axis=0)
    size[size == 0] = 1.0
    rows = np.vstack([A.real, A.imag]) / size
    found = np.linalg.lstsq(rows, np.concatenate([target.real, target.imag]), rcond=1e-9)[0]
    return np.asarray(found / size)
