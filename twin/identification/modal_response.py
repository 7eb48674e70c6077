"""The response of a modal model in the frequency domain, and its derivatives.

Each mode adds a pole pair with a shape, a participation of every input, and a free response:

    Y(k) = sum_r [ psi_r (L_r U(k) b_r(k) + c_r t_r(k)) + conjugate pole ] + D U(k)

b_r is 1/(j w - l_r) where the input is band-limited between its samples, and 1/(z - e^{l_r dt})
where it is held; t_r = 1/(1 - e^{l_r dt} / z) is exact for the free response of a sampled record,
whose end state differs from its start state.

Source: Pintelon and Schoukens, System Identification (2012), ch. 6, for the transient term.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Hold = Literal["band-limited", "held"]


@dataclass(frozen=True)
class ModalParameters:
    """Parameters of a modal model with n modes, r inputs, m outputs and any number of records.

    Attributes:
        omega: natural angular frequencies [rad/s], (n,).
        zeta: damping ratios, (n,).
        psi: mode shapes, the ``anchor`` component of each fixed at 1, (m, n).
        anchor: the output whose component is fixed, (n,).
        participation: L, (n, r).
        D: direct transmission, (m, r).
        D2: what modes above the band add, multiplied by (w / w_max)^2, (m, r).
        D_low: what modes below the band add, multiplied by (w_max / w)^2, (m, r), or None.
        transient: c, (records, n).
        edges: outputs at the free samples, by combinations of them, (records, combinations, m).
    """

    omega: Array
    zeta: Array
    psi: ComplexArray
    anchor: NDArray[np.int64]
    participation: ComplexArray
    D: Array
    D2: Array
    transient: ComplexArray
    edges: tuple[Array, ...]
    D_low: Array | None = None

    @property
    def poles(self) -> ComplexArray:
        """Continuous-time poles [rad/s], (n,)."""
        return self.omega * (-self.zeta + 1j * np.sqrt(1 - self.zeta**2))

    def only(self, modes: slice) -> ModalParameters:
        """Return the parameters of some of the modes; what else there is stays."""
        return replace(
            self,
            omega=self.omega[modes],
            zeta=self.zeta[modes],
            psi=self.psi[:, modes],
            anchor=self.anchor[modes],
            participation=self.participation[modes],
            transient=self.transient[:, modes],
        )


def basis(
    poles: ComplexArray, s: Spectrum, hold: Hold
) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
    """Return b, its derivative by the pole, t and its derivative, each (bins, poles)."""
    # A trial pole of an iteration may run away; a bounded growth keeps the numbers finite.
    decay = np.exp(np.minimum(poles.real * s.dt, 1.0) + 1j * poles.imag * s.dt)
    z = s.z[:, None]
    t = 1 / (1 - decay / z)
    t_slope = s.dt * (decay / z) * t**2
    if hold == "held":
        b = 1 / (z - decay)
        return b, s.dt * decay * b**2, t, t_slope
    b = 1 / (1j * s.omega[:, None] - poles)
    return b, b**2, t, t_slope


def frequency_response(
    parameters: ModalParameters,
    s: Spectrum,
    hold: Hold,
    w_max: float,
    limits: tuple[float, float] | None = None,
) -> ComplexArray:
    """Return G at the bins of ``s``, (bins, outputs, inputs).

    Args:
        parameters: of the model.
        s: the lines.
        hold: what the input does between its samples.
        w_max: highest analysed angular frequency [rad/s].
        limits: beyond them the out-of-band terms, a fit inside the band, stay what they are there.
    """
    p = parameters
    b, _, _, _ = basis(p.poles, s, hold)
    mirrored, _, _, _ = basis(p.poles.conj(), s, hold)
    G = np.einsum("mn,kn,nr->kmr", p.psi, b, p.participation)
    G += np.einsum("mn,kn,nr->kmr", p.psi.conj(), mirrored, p.participation.conj())
    omega = s.omega if limits is None else np.clip(s.omega, *limits)
    ratio = omega[:, None, None] / w_max
    if p.D_low is not None:
        G = G + p.D_low * np.maximum(ratio, np.finfo(float).eps) ** -2
    return np.asarray(G + p.D + p.D2 * ratio**2)


def respond(
    parameters: ModalParameters, s: Spectrum, record: int, hold: Hold, w_max: float
) -> ComplexArray:
    """Return the modelled output spectrum of one record, (bins, outputs)."""
    p = parameters
    Y = np.einsum("kmr,kr->km", frequency_response(p, s, hold, w_max), s.U)
    _, _, t, _ = basis(p.poles, s, hold)
    _, _, mirrored, _ = basis(p.poles.conj(), s, hold)
    Y += (t * p.transient[record]) @ p.psi.T
    Y += (mirrored * p.transient[record].conj()) @ p.psi.conj().T
    if s.edge:
        Y += s.edge_columns @ p.edges[record]
    return Y


def jacobian(
    parameters: ModalParameters, s: Spectrum, record: int, hold: Hold, w_max: float, residual: bool
) -> ComplexArray:
    """Derivatives of ``respond`` by the real parameters, (bins, outputs, parameters).

    Order: log omega (n), zeta (n), psi without anchors (real then imaginary, per mode),
    participation (n, r, 2), D (m, r), D2 (m, r) where ``residual``, transient (n, 2) of this
    record, edges (combinations, m) of this record.
    """
    p = parameters
    m, n = p.psi.shape
    r = p.participation.shape[1]
    b, b_slope, t, t_slope = basis(p.poles, s, hold)
    c, c_slope, u, u_slope = basis(p.poles.conj(), s, hold)
    drive, drive_m = s.U @ p.participation.T, s.U @ p.participation.conj().T
    c0, psi = p.transient[record], p.psi
    a = b * drive + t * c0
    a_m = c * drive_m + u * c0.conj()
    slope = b_slope * drive + t_slope * c0
    slope_m = c_slope * drive_m + u_slope * c0.conj()
    root = np.sqrt(1 - p.zeta**2)
    by_zeta = p.omega * (-1 - 1j * p.zeta / root)
    columns: list[ComplexArray] = []
    for by in (p.poles, by_zeta):
        columns += [
            np.outer(slope[:, i] * by[i], psi[:, i])
            + np.outer(slope_m[:, i] * by[i].conj(), psi[:, i].conj())
            for i in range(n)
        ]
    eye = np.eye(m)
    for i in range(n):
        for j in range(m):
            if j != p.anchor[i]:
                columns.append(np.outer(a[:, i] + a_m[:, i], eye[j]))
                columns.append(np.outer(1j * (a[:, i] - a_m[:, i]), eye[j]))
    for i in range(n):
        for k in range(r):
            plus = np.outer(b[:, i] * s.U[:, k], psi[:, i])
            minus = np.outer(c[:, i] * s.U[:, k], psi[:, i].conj())
            columns += [plus + minus, 1j * (plus - minus)]
    powers = [np.ones(len(s.omega))] + ([(s.omega / w_max) ** 2] if residual else [])
    for power in powers:
        columns += [
            np.outer(power * s.U[:, k], eye[j]).astype(complex) for j in range(m) for k in range(r)
        ]
    for i in range(n):
        plus, minus = np.outer(t[:, i], psi[:, i]), np.outer(u[:, i], psi[:, i].conj())
        columns += [plus + minus, 1j * (plus - minus)]
    for pulse in s.edge_columns.T:
        columns += [np.outer(pulse, eye[j]) for j in range(m)]
    return np.stack(columns, axis=2)
