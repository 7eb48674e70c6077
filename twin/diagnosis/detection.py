"""Is there anything to explain: the calibrated twin's one-step errors against the noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit, gains_of
from twin.diagnosis.result import Detection

Array = NDArray[np.float64]

LAGS = 32
"""Lags of the portmanteau test."""

MEASURED_SLACK = 1e-4
"""Force noise beyond the measured one that is granted: none to speak of."""


def detect(bench: Bench, calibrated: Fit) -> tuple[Detection, ...]:
    """Return, for every output, how far the one-step errors of the calibrated twin are from noise.

    Args:
        bench: the training recordings.
        calibrated: the fit without new physics.
    """
    try:
        gains = gains_of(bench, calibrated.hypothesis, MEASURED_SLACK)
    except np.linalg.LinAlgError:
        gains = calibrated.gains
    rows = bench.innovations([calibrated.hypothesis], gains, calibrated.starts)
    errors = [row[0] for row in rows]
    outputs = bench.trials[0].outputs
    out = []
    for column, channel in enumerate(outputs):
        pieces, level, born = [], [], []
        for trial, gain, e in zip(bench.trials, gains, errors, strict=True):
            expected = float(np.sqrt(gain.innovation[column, column]))
            ratio = e[:, column] / expected
            pieces.append(ratio)
            rms = float(np.sqrt(np.mean(trial.y[:, column] ** 2)))
            level.append((rms, float(np.sqrt(np.mean(ratio**2)))))
            born.append(_born(ratio, trial.sampling_hz))
        whole = np.concatenate(pieces)
        out.append(
            Detection(
                channel,
                _portmanteau(pieces),
                float(np.sqrt(np.mean(whole**2))),
                tuple(born),
                _stands_out(whole, bench.trials[0].sampling_hz),
                np.array(level),
            )
        )
    return tuple(out)


def _portmanteau(pieces: list[Array]) -> float:
    """Return the p-value of the pieces being white (Ljung and Box 1978), all lags together."""
    statistic, freedom = 0.0, 0
    for x in pieces:
        n = len(x)
        lags = min(LAGS, n // 4)
        centred = x - x.mean()
        power = float(centred @ centred)
        if power == 0:
            continue
        r = np.array([centred[k:] @ centred[:-k] for k in range(1, lags + 1)]) / power
        statistic += n * (n + 2) * float(np.sum(r**2 / (n - np.arange(1, lags + 1))))
        freedom += lags
    return float(stats.chi2.sf(statistic, freedom)) if freedom else 1.0


def _born(ratio: Array, rate_hz: float) -> float:
    """Return when a running power of half a second first leaves what noise does [s]."""
    length = max(8, round(0.5 * rate_hz))
    power = np.convolve(ratio**2, np.ones(length) / length, mode="valid")
    limit = stats.chi2.isf(1e-6, length) / length
    above = np.flatnonzero(power > limit)
    return float((above[0] + length) / rate_hz) if len(above) else float("nan")


def _stands_out(ratio: Array, rate_hz: float) -> float:
    """Return the frequency at which the errors' spectrum is largest [Hz]."""
    f, density = signal.welch(ratio, rate_hz, nperseg=min(1024, len(ratio)))
    return float(f[1:][np.argmax(density[1:])])
