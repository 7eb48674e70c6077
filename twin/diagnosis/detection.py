"""Is there anything to explain: the calibrated twin's one-step errors against the noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from twin.arrays import rms_of
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.predict import Predictor, predictors
from twin.diagnosis.result import Detection

Array = NDArray[np.float64]

LAGS = 32
"""Lags of the portmanteau test: an eighth of a second at 256 Hz, half a period of a slow mode."""

NO_PROCESS_NOISE = -3.0
"""Process noise in prior deviations: so little that only the measured noise is granted."""

RARE = 1e-6
"""Chance that noise alone leaves its bounds: once in a million windows of half a second."""


def detect(calibrated: Explanation) -> tuple[Detection, ...]:
    """Return, for every output, how far the calibrated twin's one-step errors are from noise."""
    hypothesis = calibrated.hypothesis
    own = ("noise of", "process noise")
    z = np.array([
        NO_PROCESS_NOISE if u.name.startswith(own[1]) else 0.0 if u.name.startswith(own[0]) else x
        for u, x in zip(hypothesis.unknowns, calibrated.fit.z, strict=True)
    ])  # fmt: skip
    beside = predictors(hypothesis, z)
    return tuple(
        _channel(beside, column, name)
        for column, name in enumerate(hypothesis.problem.model.outputs)
    )


def _channel(beside: list[Predictor], column: int, name: str) -> Detection:
    pieces, level = [], []
    rate = 1 / beside[0].trial.step_s
    for predictor in beside:
        e = predictor.followed.e[:, column]
        ratio = e / float(np.sqrt(predictor.gain.innovation[-1, column, column]))
        pieces.append(ratio)
        rms = float(rms_of(predictor.trial.y)[column])
        level.append((rms, float(np.sqrt(np.mean(ratio**2)))))
    whole = np.concatenate(pieces)
    return Detection(
        name,
        portmanteau(pieces),
        float(np.sqrt(np.mean(whole**2))),
        tuple(onset(piece, rate) for piece in pieces),
        _stands_out(whole, rate),
        np.array(level),
    )


def portmanteau(pieces: list[Array]) -> float:
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


def onset(ratio: Array, rate_hz: float) -> float:
    """Return when a running power of half a second first leaves what noise does [s]."""
    length = max(8, round(0.5 * rate_hz))
    power = np.convolve(ratio**2, np.ones(length) / length, mode="valid")
    limit = stats.chi2.isf(RARE, length) / length
    above = np.flatnonzero(power > limit)
    return float((above[0] + length) / rate_hz) if len(above) else float("nan")


def _stands_out(ratio: Array, rate_hz: float) -> float:
    """Return the frequency at which the errors' spectrum is largest [Hz]."""
    f, density = signal.welch(ratio, rate_hz, nperseg=min(1024, len(ratio)))
    return float(f[1:][np.argmax(density[1:])])
