"""Stable poles of other packages on a hammer's records, over all orders of their diagrams.

sdypy-EMA gets the frequency responses. pyOMA2 has no use for a force: it gets the decays that
follow the hits, whose correlations have the structure's poles. Three things its user has to know
(1.4.3): a single output needs its limits of phase collinearity switched off, they are 0/0 there
and reject every pole; a decay wants correlations, not a Hann window over its beginning; and the
exponential window that its correlations get is not taken off the damping again (the correction
is per sample, where the poles are per second), which is done here.
"""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.identification.records import prepare
from twin.recording import Recording
from twin.signals.frf import measured_response

Array = NDArray[np.float64]
Poles = tuple[Array, Array]
"""Frequencies [Hz] and damping ratios of all stable poles of a diagram."""

FREQUENCY_STABLE, DAMPING_STABLE = 1e-3, 0.05
"""Relative change from one order to the next below which a pole is stable: sdypy-EMA's defaults,
given to pyOMA2 as well (its own 5 % in frequency are 40 bandwidths here)."""

NEAR = 5e-4
"""Relative distance in frequency within which a pole belongs to a mode: the issue's 0.05 %."""

EMA_ORDER = 100
LSCF_ORDER = 70
"""At 14 s for a diagram; every order costs a pass over all lines."""

SUBSPACE_ROWS, SUBSPACE_ORDER = 300, 160

DECIMATION = 2
"""Leaves 6.4 kHz, which holds the band."""

AFTER_HIT = 32
"""Samples after the force's peak at which the decay begins: 1.25 ms, the hit and the analyser's
filter are over."""

TAPER = float(np.log(100))
"""Exponent that pyOMA2's exponential window reaches at its end."""


@dataclass(frozen=True)
class Picked:
    """What a diagram says about one mode.

    Attributes:
        frequency_hz: median of its stable poles [Hz].
        damping: median of their damping ratios.
        low: of the damping ratios, the quantile of 5 %.
        high: the quantile of 95 %.
        poles: how many there are.
    """

    frequency_hz: float
    damping: float
    low: float
    high: float
    poles: int


def picked(poles: Poles, frequency_hz: float) -> Picked | None:
    """Return what the stable poles near a frequency have in common; None where there are none."""
    f, zeta = poles
    near = np.abs(f / frequency_hz - 1) < NEAR
    if not near.any():
        return None
    low, middle, high = np.quantile(zeta[near], [0.05, 0.5, 0.95])
    return Picked(
        float(np.median(f[near])), float(middle), float(low), float(high), int(near.sum())
    )


def sdypy_ema(hits: Sequence[Recording], band: tuple[float, float]) -> Poles:
    """Least-squares complex frequency of sdypy-EMA, its own test of stability."""
    from sdypy import EMA
    from sdypy.EMA import stabilization

    found = measured_response(prepare(hits).pairs, hits[0].sampling_hz)
    keep = found.frequency_hz > 0
    model = EMA.Model(
        found.H[keep, :, 0].T, found.frequency_hz[keep], lower=band[0], upper=band[1],
        pol_order_high=EMA_ORDER, frf_form="accelerance",
    )  # fmt: skip
    with _quiet():
        model.get_poles(show_progress=False)
        f, zeta, f_stable, zeta_stable = stabilization._stabilization(
            model.all_poles, EMA_ORDER, err_fn=FREQUENCY_STABLE, err_xi=DAMPING_STABLE
        )
    stable = (f_stable > 0) & (zeta_stable > 0) & (zeta > 0)
    return f[stable], zeta[stable]


def pyoma_lscf(hits: Sequence[Recording], band: tuple[float, float]) -> Poles:
    """Poly-reference least-squares complex frequency of pyOMA2 on the decays' correlations."""
    from pyoma2.algorithms import pLSCF

    decay = _decays(hits)
    block = 2 * (len(decay) // len(hits) // DECIMATION)
    algorithm = pLSCF(
        name="pLSCF", ordmax=LSCF_ORDER, nxseg=block, method_SD="cor", sc=_soft(), hc=_hard()
    )
    f, zeta = _stable(algorithm, decay, hits[0].sampling_hz)
    window = TAPER / (block * DECIMATION / hits[0].sampling_hz)
    return f, zeta - window / (2 * np.pi * f)


def pyoma_ssi(hits: Sequence[Recording], band: tuple[float, float]) -> Poles:
    """Covariance-driven subspace of pyOMA2 on the decays."""
    from pyoma2.algorithms import SSI

    algorithm = SSI(
        name="SSI", method="cov", br=SUBSPACE_ROWS, ordmax=SUBSPACE_ORDER, step=2, sc=_soft(),
        hc=_hard(),
    )  # fmt: skip
    return _stable(algorithm, _decays(hits), hits[0].sampling_hz)


PEERS: dict[str, Callable[[Sequence[Recording], tuple[float, float]], Poles]] = {
    "sdypy-EMA LSCF": sdypy_ema,
    "pyOMA2 pLSCF": pyoma_lscf,
    "pyOMA2 SSI": pyoma_ssi,
}


def _decays(hits: Sequence[Recording]) -> Array:
    """Return what follows the hits, of one length, one below the other, (samples, outputs)."""
    parts = [y[int(np.argmax(np.abs(u[:, 0]))) + AFTER_HIT :] for u, y in prepare(hits).pairs]
    length = min(len(part) for part in parts)
    return np.vstack([part[:length] for part in parts])


def _soft() -> dict[str, float]:
    return {"err_fn": FREQUENCY_STABLE, "err_xi": DAMPING_STABLE, "err_phi": DAMPING_STABLE}


def _hard() -> dict[str, float | None]:
    return {"xi_max": 0.1, "mpc_lim": None, "mpd_lim": None, "CoV_max": 0.2}


def _stable(algorithm: Any, data: Array, rate: float) -> Poles:
    from pyoma2.setup import SingleSetup

    with _quiet():
        setup = SingleSetup(data, rate)
        setup.decimate_data(q=DECIMATION)
        setup.add_algorithms(algorithm)
        setup.run_by_name(algorithm.name)
    result = algorithm.result
    stable = (np.nanmax(result.Lab) == result.Lab) & (result.Lab > 0)
    return result.Fn_poles[stable], result.Xi_poles[stable]


@contextlib.contextmanager
def _quiet() -> Any:
    logging.disable(logging.CRITICAL)
    with warnings.catch_warnings(), contextlib.redirect_stderr(io.StringIO()):
        warnings.simplefilter("ignore")
        yield
    logging.disable(logging.NOTSET)
