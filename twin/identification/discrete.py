"""The discrete-time realization and the re-simulated output that belong to a modal fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.identification.maximum_likelihood import ModalFit
from twin.identification.modal_response import basis, frequency_response
from twin.identification.spectra import Spectrum
from twin.identification.stabilisation import continuous_poles
from twin.modal import mac
from twin.state_space import StateSpace

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MOST_ELEMENTS = 5e7
"""Numbers in a matrix of regressors beyond which normal equations or residues take its place."""


def predict(fit: ModalFit, u: Array, y: Array, dt: float, edge: int = 0) -> Array:
    """Return the outputs that the model gives for the input, (samples, outputs).

    The model runs free; only the state at the start of the record (as the free response of
    every mode) and the sensors' offsets are read from the output.
    """
    samples = len(u)
    scale = 1 / np.sqrt(samples)
    omega = 2 * np.pi * np.asarray(np.fft.rfftfreq(samples, dt), float)
    whole = Spectrum(
        omega, np.fft.rfft(u, axis=0) * scale, np.fft.rfft(y, axis=0) * scale, samples, dt, edge
    )
    p = fit.parameters
    G = frequency_response(p, whole, fit.hold, fit.w_max, (fit.w_min, fit.w_max))
    Y = np.einsum("kmr,kr->km", G, whole.U)
    inside = (omega > 0) & (omega >= fit.w_min) & (omega <= fit.w_max)
    _, _, t, _ = basis(p.poles, whole, fit.hold)
    _, _, mirrored, _ = basis(p.poles.conj(), whole, fit.hold)
    c = _free_response(p.psi, t[inside], mirrored[inside], (whole.Y - Y)[inside])
    Y = Y + (t * c) @ p.psi.T + (mirrored * c.conj()) @ p.psi.conj().T
    Y[0] = whole.Y[0]
    return np.asarray(np.fft.irfft(Y, samples, axis=0) / scale)


def _free_response(
    psi: ComplexArray, t: ComplexArray, mirrored: ComplexArray, error: ComplexArray
) -> ComplexArray:
    """Fit every mode's free response to what the input leaves unexplained, (modes,)."""

    def rows(o: int) -> Array:
        plus, minus = t * psi[o], mirrored * psi[o].conj()
        pairs = np.stack([plus + minus, 1j * (plus - minus)], axis=2).reshape(len(t), -1)
        return np.vstack([pairs.real, pairs.imag])

    outputs, n = psi.shape
    if 4 * t.shape[0] * n * outputs <= MOST_ELEMENTS:
        left = np.vstack([rows(o) for o in range(outputs)])
        right = np.concatenate([np.r_[error[:, o].real, error[:, o].imag] for o in range(outputs)])
    else:
        left, right = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
        for o in range(outputs):
            own = rows(o)
            left += own.T @ own
            right += own.T @ np.r_[error[:, o].real, error[:, o].imag]
    c, *_ = np.linalg.lstsq(left, right, rcond=None)
    return np.asarray(c[0::2] + 1j * c[1::2])


def realize(
    fit: ModalFit, pairs: Sequence[tuple[Array, Array]], dt: float, observer: StateSpace | None
) -> StateSpace:
    """Return a real modal discrete-time realization with the fit's poles and shapes.

    B and D are fitted to the recordings: the response to an input that is band-limited between
    its samples is that of no finite discrete-time model, so this is the closest of its order. A
    pole above half the sampling rate, which only a fit of the continuous poles knows, is left out:
    sampled it would resonate at its alias.

    Args:
        fit: the modal fit.
        pairs: input and output of each record.
        dt: sampling interval [s].
        observer: the OKID/ERA realization whose observer gain is carried over.
    """
    p = fit.parameters
    if p.poles[fit.measured.stop :].imag.max(initial=0.0) * dt >= np.pi:
        p = p.only(fit.measured)
    (m, n), r = p.psi.shape, p.participation.shape[1]
    decay = np.exp(p.poles * dt)
    if sum(len(u) for u, _ in pairs) * m * 2 * n * r > MOST_ELEMENTS:
        gain = (decay - 1) / p.poles if fit.hold == "band-limited" else np.ones(n)
        return _modal(decay, p.psi, p.participation * gain[:, None], p.D, dt)
    gram = np.zeros((2 * n * r + m * r + 0, 2 * n * r + m * r))
    right = np.zeros(len(gram))
    for u, y in pairs:
        columns, target = _regressors(decay, p.psi, u), y
        start = _regressors_of_state(decay, p.psi, len(u))
        basis_of_state, _ = np.linalg.qr(start)
        rows = columns - basis_of_state @ (basis_of_state.T @ columns)
        gram += rows.T @ rows
        right += rows.T @ target.ravel()
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    solved = np.linalg.lstsq(gram / np.outer(scale, scale), right / scale, rcond=1e-13)[0] / scale
    drive = solved[: 2 * n * r].reshape(n, r, 2)
    model = _modal(
        decay, p.psi, drive[..., 0] + 1j * drive[..., 1], solved[2 * n * r :].reshape(m, r), dt
    )
    measured = p.only(fit.measured)
    G = _observer_gain(model, measured.poles, measured.psi, observer)
    return StateSpace(model.A, model.B, model.C, model.D, dt, G)


def _modal(
    decay: ComplexArray, psi: ComplexArray, drive: ComplexArray, D: Array, dt: float
) -> StateSpace:
    """Return the real block-diagonal realization of x(k+1) = decay x(k) + drive u(k)."""
    (m, n), r = psi.shape, drive.shape[1]
    A, B, C = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, r)), np.zeros((m, 2 * n))
    for i in range(n):
        at = slice(2 * i, 2 * i + 2)
        A[at, at] = [[decay[i].real, -decay[i].imag], [decay[i].imag, decay[i].real]]
        B[at] = drive[i].real, drive[i].imag
        C[:, 2 * i], C[:, 2 * i + 1] = 2 * psi[:, i].real, -2 * psi[:, i].imag
    return StateSpace(A, B, C, D, dt)


def _regressors(decay: ComplexArray, psi: ComplexArray, u: Array) -> Array:
    """Outputs for a unit real or imaginary drive of each mode by each input, then for D."""
    m, r = len(psi), u.shape[1]
    columns = []
    for i, pole in enumerate(decay):
        for k in range(r):
            state = signal.lfilter([0, 1], [1, -pole], u[:, k].astype(complex))
            response = 2 * np.outer(state, psi[:, i])
            columns += [response.real.ravel(), -response.imag.ravel()]
    columns += [np.outer(u[:, k], np.eye(m)[j]).ravel() for j in range(m) for k in range(r)]
    return np.column_stack(columns)


def _regressors_of_state(decay: ComplexArray, psi: ComplexArray, samples: int) -> Array:
    columns = []
    for i, pole in enumerate(decay):
        response = np.outer(pole ** np.arange(samples), psi[:, i])
        columns += [response.real.ravel(), response.imag.ravel()]
    return np.column_stack(columns)


def _observer_gain(
    model: StateSpace, poles: ComplexArray, psi: ComplexArray, observer: StateSpace | None
) -> Array | None:
    """Carry the observer gain of eq. (38) over to the refined modal coordinates.

    The states of a pole above the band come last and have no gain: they are stable by themselves,
    and what the sensors see of them is too little to correct them by.
    """
    if observer is None or observer.G is None:
        return None
    values, vectors = np.linalg.eig(observer.A)
    own = np.linalg.solve(vectors, observer.G.astype(complex))
    shapes = observer.C @ vectors
    known, _ = continuous_poles(observer)
    if len(known) < len(poles):
        return None
    G = np.zeros((len(model.A), psi.shape[0]))
    for i, pole in enumerate(np.exp(poles * (model.dt or 1.0))):
        j = int(np.argmin(np.abs(values - pole)))
        if mac(shapes[:, [j]], psi[:, [i]])[0, 0] < 0.5:
            return None
        scale = np.vdot(psi[:, i], shapes[:, j]) / np.vdot(psi[:, i], psi[:, i])
        row = scale * own[j]
        G[2 * i], G[2 * i + 1] = row.real, row.imag
    stable = np.abs(np.linalg.eigvals(model.A + G @ model.C)).max() < 1
    return G if stable else None
