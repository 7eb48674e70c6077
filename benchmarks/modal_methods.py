"""Modal identification by other packages and by ours, behind one signature each.

Every method takes recordings, a band and the frequencies near which a person would pick poles, and
returns frequencies [Hz] and damping ratios, with standard deviations where the package has them.
Every function imports its package itself, so that a missing one costs a line and not the run.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Sequence
from multiprocessing import get_context
from queue import Empty
from typing import Any

import numpy as np
import peers
from numpy.typing import NDArray

from twin.identification.records import prepare
from twin.recording import Recording
from twin.signals.frf import measured_response

Array = NDArray[np.float64]
Found = tuple[Array, ...]
"""Frequencies [Hz] and damping ratios; then their standard deviations, where they are stated."""

EMA_ORDER = 100
LSCF_ORDER, LSCF_BLOCK = 60, 8192
SUBSPACE_ROWS, SUBSPACE_ORDER = 20, 100
MARKOV = 200
STATES = 80
"""True order of the plate: 40 modes."""

HORIZON = 20
UNCERTAINTY_BLOCKS = 50


def ours(recordings: Sequence[Recording], band: tuple[float, float], hints: Array) -> Found:
    from twin.identification.identify import identify

    modal = identify(recordings, band_hz=band).modal
    return modal.natural_freq, modal.damping_ratio


def ours_output_only(
    recordings: Sequence[Recording], band: tuple[float, float], hints: Array
) -> Found:
    from twin.identification.output_only import identify_output_only

    modal = identify_output_only(recordings, band_hz=band).modal
    assert modal.natural_freq_std is not None
    assert modal.damping_ratio_std is not None
    return (
        modal.natural_freq, modal.damping_ratio, modal.natural_freq_std, modal.damping_ratio_std,
    )  # fmt: skip


def sdypy_ema(recordings: Sequence[Recording], band: tuple[float, float], hints: Array) -> Found:
    from sdypy import EMA

    records = prepare(recordings)
    found = measured_response(records.pairs, recordings[0].sampling_hz)
    keep = found.frequency_hz > 0
    model = EMA.Model(
        found.H[keep, :, 0].T, found.frequency_hz[keep], lower=band[0], upper=band[1],
        pol_order_high=EMA_ORDER, frf_form="accelerance",
    )  # fmt: skip
    model.get_poles(show_progress=False)
    model.select_closest_poles(list(hints))
    return np.asarray(model.nat_freq, float), np.asarray(model.nat_xi, float)


def _pyoma(algorithm: Any, data: Array, rate: float, hints: Array, order: int | str) -> Found:
    from pyoma2.setup import SingleSetup

    setup = SingleSetup(data, rate)
    setup.add_algorithms(algorithm)
    setup.run_by_name(algorithm.name)
    algorithm.mpe(list(hints), order, rtol=5e-3)
    result = algorithm.result
    freq, damping = np.asarray(result.Fn, float), np.asarray(result.Xi, float)
    std = [getattr(result, name, None) for name in ("Fn_std", "Xi_std")]
    if any(s is None for s in std):
        return freq, damping
    return freq, damping, np.asarray(std[0], float), np.asarray(std[1], float)


def pyoma_lscf(recordings: Sequence[Recording], band: tuple[float, float], hints: Array) -> Found:
    from pyoma2.algorithms import pLSCF

    data = np.vstack([y for _, y in prepare(recordings).pairs])
    many = data.shape[1] > 4
    algorithm = pLSCF(
        name="pLSCF", ordmax=LSCF_ORDER // 5 if many else LSCF_ORDER,
        nxseg=min(LSCF_BLOCK, len(data) // 2),
    )  # fmt: skip
    return _pyoma(algorithm, data, recordings[0].sampling_hz, hints, "find_min")


def pyoma_ssi(recordings: Sequence[Recording], band: tuple[float, float], hints: Array) -> Found:
    from pyoma2.algorithms import SSI

    data = np.vstack([y for _, y in prepare(recordings).pairs])
    algorithm = SSI(
        name="SSI", method="cov", br=SUBSPACE_ROWS, ordmax=SUBSPACE_ORDER, step=2
    )  # fmt: skip
    return _pyoma(algorithm, data, recordings[0].sampling_hz, hints, SUBSPACE_ORDER)


def pyoma_ssi_alone(
    recordings: Sequence[Recording], band: tuple[float, float], hints: Array
) -> Found:
    """The order is given: the shaken frame's two modes and a few for the noise."""
    from pyoma2.algorithms import SSI

    data = np.column_stack([recordings[0].column(name) for name in recordings[0].names])
    algorithm = SSI(
        name="SSI", method="cov", br=SUBSPACE_ROWS, ordmax=8, step=2, calc_unc=True,
        nb=UNCERTAINTY_BLOCKS,
    )  # fmt: skip
    return _pyoma(algorithm, data, recordings[0].sampling_hz, hints, 8)


def _in_band(A: Array, rate: float, band: tuple[float, float]) -> Found:
    poles = np.log(np.linalg.eigvals(A).astype(complex)) * rate
    poles = poles[poles.imag > 0]
    f, zeta = np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles)
    inside = (f > band[0]) & (f < band[1])
    order = np.argsort(f[inside])
    return f[inside][order], zeta[inside][order]


def control_era(recordings: Sequence[Recording], band: tuple[float, float], hints: Array) -> Found:
    ((u, y),) = prepare(recordings).pairs
    found = peers.control_era(peers.control_markov(u, y, MARKOV), STATES)
    return _in_band(found[0], recordings[0].sampling_hz, band)


def pymor_era(recordings: Sequence[Recording], band: tuple[float, float], hints: Array) -> Found:
    ((u, y),) = prepare(recordings).pairs
    found = peers.pymor_randomised_era(peers.control_markov(u, y, MARKOV), STATES)
    return _in_band(found[0], recordings[0].sampling_hz, band)


def sippy(recordings: Sequence[Recording], band: tuple[float, float], hints: Array) -> Found:
    ((u, y),) = prepare(recordings).pairs
    found = peers.sippy_parsim(u, y, STATES, HORIZON)
    return _in_band(found[0], recordings[0].sampling_hz, band)


Method = Callable[[Sequence[Recording], tuple[float, float], Array], Found]
METHODS: dict[str, Method] = {
    "ours": ours,
    "sdypy-EMA": sdypy_ema,
    "pyOMA2 pLSCF": pyoma_lscf,
    "pyOMA2 SSI": pyoma_ssi,
    "python-control ERA": control_era,
    "pymor ERA": pymor_era,
    "SIPPY PARSIM-K": sippy,
}
OUTPUT_ONLY: dict[str, Method] = {"ours": ours_output_only, "pyOMA2 SSI": pyoma_ssi_alone}
HINTED = ("sdypy-EMA", "pyOMA2 pLSCF", "pyOMA2 SSI")


def _work(
    queue: Any, method: Method, recordings: Sequence[Recording], band: tuple[float, float],
    hints: Array,
) -> None:  # fmt: skip
    start = time.perf_counter()
    try:
        found = method(recordings, band, hints)
    except ImportError as error:
        queue.put({"error": f"skipped: {error.name} is not installed"})
        return
    except Exception as error:  # whatever a peer does is its result
        queue.put({"error": f"{type(error).__name__}: {str(error)[:80]}"})
        return
    seconds = time.perf_counter() - start
    keys = ("frequency", "damping", "frequency_std", "damping_std")
    result: dict[str, Any] = dict(zip(keys, (np.ravel(x).tolist() for x in found), strict=False))
    known = np.isfinite(result["frequency"])
    result = {k: np.asarray(v)[known].tolist() for k, v in result.items()}
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    queue.put(result | {"seconds": seconds, "memory_gb": memory})


def alone(
    name: str, recordings: Sequence[Recording], band: tuple[float, float], hints: Array,
    limit: float,
) -> dict[str, Any]:  # fmt: skip
    """Run one method in a process of its own.

    Returns:
        frequency, damping and, where stated, their deviations; seconds, memory_gb,
        hinted; or error.
    """
    method = METHODS[name]
    context = get_context("spawn")
    queue = context.Queue()
    process = context.Process(target=_work, args=(queue, method, recordings, band, hints))
    process.start()
    try:
        found: dict[str, Any] = queue.get(timeout=limit)
    except Empty:
        found = {"error": f"more than {limit:.0f} s"}
    process.join(timeout=5)
    if process.is_alive():
        process.terminate()
    return found | {"hinted": name in HINTED}
