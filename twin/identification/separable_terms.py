"""The unknowns of a separable modal model, and what its linear parameters multiply."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from twin.identification.modal_response import Hold, basis
from twin.identification.spectra import Spectrum

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

LEAST_ZETA, MOST_ZETA = 1e-7, 0.95


@dataclass(frozen=True)
class Drive:
    """What is left to iterate on: n modes, r inputs, R transients.

    Attributes:
        omega: natural angular frequencies [rad/s], (n,).
        zeta: damping ratios, positive, (n,).
        v: participation of the inputs, then of the transients, (n, r + R).
        anchor: component of v that is fixed at 1, (n,).
    """

    omega: Array
    zeta: Array
    v: ComplexArray
    anchor: NDArray[np.int64]

    @property
    def poles(self) -> ComplexArray:
        """Continuous-time poles [rad/s], (n,)."""
        return self.omega * (-self.zeta + 1j * np.sqrt(1 - self.zeta**2))

    def moved(self, step: Array) -> Drive:
        """Return the drive after a step, (n, r + R, 2): log omega and log zeta, then v's parts."""
        q = self.v.shape[1]
        omega = self.omega * np.exp(np.clip(step[:, 0, 0], -1, 1))
        zeta = np.clip(self.zeta * np.exp(np.clip(step[:, 0, 1], -3, 3)), LEAST_ZETA, MOST_ZETA)
        v = self.v.copy()
        free = np.arange(q)[None, :] != self.anchor[:, None]
        v[free] += (step[:, 1:, 0] + 1j * step[:, 1:, 1]).ravel()
        return replace(self, omega=omega, zeta=zeta, v=v)

    def without(self, gone: NDArray[np.intp]) -> Drive:
        """Return the drive without some modes, given by their indices."""
        return self.only(np.setdiff1d(np.arange(len(self.omega)), gone))

    def only(self, kept: NDArray[np.intp]) -> Drive:
        """Return the drive of some modes, given by their indices."""
        return Drive(self.omega[kept], self.zeta[kept], self.v[kept], self.anchor[kept])


@dataclass(frozen=True)
class Terms:
    """The fixed part of the model: what the records hold and which terms stand beside the modes.

    Attributes:
        spectra: the records.
        hold: what the input does between its samples.
        powers: powers of w / w_max of the direct terms, 0 among them.
        w_max: highest analysed angular frequency [rad/s].
    """

    spectra: tuple[Spectrum, ...]
    hold: Hold
    powers: tuple[int, ...]
    w_max: float

    @property
    def rows(self) -> list[slice]:
        """Where each record's lines stand in the stacked arrays."""
        ends = np.cumsum([0, *(len(s.omega) for s in self.spectra)])
        return [slice(a, b) for a, b in pairwise(ends)]

    @property
    def Y(self) -> ComplexArray:
        """Outputs of all records, (lines, outputs)."""
        return np.vstack([s.Y for s in self.spectra])

    @property
    def noise(self) -> Array:
        """Relative standard deviation of the noise, 1 where it is white, (lines, outputs)."""
        return np.vstack([np.ones(s.Y.shape) if s.noise is None else s.noise for s in self.spectra])

    @property
    def drives(self) -> int:
        """Components of a mode's drive, r + R."""
        return self.spectra[0].U.shape[1] + sum(s.transient for s in self.spectra)

    def direct(self) -> ComplexArray:
        """Regressors of the direct terms and the free ends, (lines, columns)."""
        U = np.vstack([s.U for s in self.spectra])
        ratio = np.concatenate([s.omega for s in self.spectra])[:, None] / self.w_max
        columns = [np.zeros((len(U), 0)), *(U * ratio**power for power in self.powers)]
        for s, at in zip(self.spectra, self.rows, strict=True):
            if s.edge:
                ends = np.zeros((len(U), s.edge_columns.shape[1]), complex)
                ends[at] = s.edge_columns
                columns.append(ends)
        return np.hstack(columns)

    def modal(
        self, poles: ComplexArray
    ) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
        """Return what each component of v excites in each mode, and its derivative by the pole.

        Returns:
            Two arrays of shape (lines, n, r + R) for the poles, two for their conjugates.
        """
        lines = self.rows[-1].stop
        E, slope, mirror, mirror_slope = np.zeros((4, lines, len(poles), self.drives), complex)
        column = self.spectra[0].U.shape[1]
        last: Spectrum | None = None
        for s, at in zip(self.spectra, self.rows, strict=True):
            if last is None or not np.array_equal(s.omega, last.omega):
                direct, turned = (basis(p, s, self.hold) for p in (poles, poles.conj()))
            last = s
            end = None if s.from_rest is None else end_state(poles, s, self.hold)
            _fill(E[at], slope[at], direct, s, end, column)
            end = None if end is None else (end[0].conj(), end[1].conj())
            _fill(mirror[at], mirror_slope[at], turned, s, end, column)
            column += s.transient
        return E, slope, mirror, mirror_slope


def _fill(
    E: ComplexArray,
    slope: ComplexArray,
    response: tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray],
    s: Spectrum,
    end: tuple[ComplexArray, ComplexArray] | None,
    column: int,
) -> None:
    """Enter one record's lines: forced response, end state, and the free response's column."""
    b, b_slope, t, t_slope = response
    r = s.U.shape[1]
    E[:, :, :r] = b[:, :, None] * s.U[:, None, :]
    slope[:, :, :r] = b_slope[:, :, None] * s.U[:, None, :]
    if end is not None:
        E[:, :, :r] -= t[:, :, None] * end[0]
        slope[:, :, :r] -= t_slope[:, :, None] * end[0] + t[:, :, None] * end[1]
    if s.transient:
        E[:, :, column], slope[:, :, column] = t, t_slope


def end_state(poles: ComplexArray, s: Spectrum, hold: Hold) -> tuple[ComplexArray, ComplexArray]:
    """Return each pole's state at the end of a record from rest, for unit drive by each input.

    What a record's transform lacks against that of the steady state under the record repeated
    for ever is this state, as a free response: X = b U - x(T) t.

    Returns:
        The state, scaled as spectra are, and its derivative by the pole, (n, inputs).
    """
    assert s.from_rest is not None
    busy = np.flatnonzero(np.any(s.from_rest != 0, axis=1))
    left = (s.samples - busy) * s.dt
    scale = 1 / np.sqrt(s.samples)
    if hold == "band-limited":
        scale *= s.dt
    else:
        left = left - s.dt
    decay = np.exp(np.minimum(poles.real[:, None] * left, 1.0) + 1j * poles.imag[:, None] * left)
    u = s.from_rest[busy] * scale
    return decay @ u, (decay * left) @ u
