"""What a user would pick instead, behind one signature each; nothing here is ours.

Every function imports its package itself, so that a missing one costs a line and not the run.
"""

from __future__ import annotations

import io
import logging
import warnings
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from importlib.metadata import PackageNotFoundError, version

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Matrices = tuple[Array, Array, Array, Array]

INSTALL = {
    "control": "pip install control",
    "pymor": "pip install pymor",
    "sippy_unipi": "pip install sippy-unipi",
    "modred": "pip install 'setuptools<81' wheel && pip install --no-build-isolation modred",
}
"""Distribution and how to get it; modred's build needs the pkg_resources of an old setuptools."""


def installed(package: str) -> bool:
    """Whether the package is there."""
    try:
        version(package)
    except PackageNotFoundError:
        return False
    return True


def missing_lines() -> list[str]:
    """One line for each peer that is not installed: it is skipped, and how to get it."""
    return [
        f"skipped: {package} is not installed ({how})"
        for package, how in INSTALL.items()
        if not installed(package)
    ]


def versions() -> dict[str, str]:
    """Versions of everything that takes part."""
    named = ("numpy", "scipy", *INSTALL)
    return {package: version(package) for package in named if installed(package)}


def control_markov(u: Array, y: Array, count: int) -> Array:
    """python-control's regression on past inputs, (count, outputs, inputs), entry 0 is D."""
    import control

    found = control.markov(y.T, u.T, count)
    return np.atleast_3d(found).transpose(2, 0, 1)


def control_era(markov: Array, order: int) -> Matrices:
    """python-control's ERA; ``markov`` has D as entry 0."""
    import control

    half = (len(markov) - 2) // 2
    model, _ = control.eigensys_realization(
        np.ascontiguousarray(markov.transpose(1, 2, 0)), order, m=half, n=half, dt=1.0
    )
    return model.A, model.B, model.C, model.D


def modred_okid(u: Array, y: Array, p: int) -> Array:
    """Modred's OKID: as many Markov parameters as the observer has, entry 0 is D."""
    import modred

    return np.asarray(modred.OKID(u.T, y.T, p))


def modred_era(markov: Array, order: int) -> Matrices:
    """Modred's ERA; ``markov`` has D as entry 0."""
    import modred

    pulses = markov[1:]
    _, sampled = modred.make_sampled_format(np.arange(len(pulses)), pulses)
    A, B, C = modred.ERA(verbosity=0).compute_model(sampled, order)
    return A, B, C[: markov.shape[1]], markov[0]


def pymor_era(markov: Array, order: int) -> Matrices:
    """Full SVD of pymor; ``markov`` has D as entry 0."""
    return _pymor("ERAReductor", markov, order)


def pymor_randomised_era(markov: Array, order: int) -> Matrices:
    """Randomised ERA of pymor; ``markov`` has D as entry 0."""
    return _pymor("RandomizedERAReductor", markov, order)


def _pymor(reductor: str, markov: Array, order: int) -> Matrices:
    logging.disable(logging.WARNING)
    from pymor.reductors import era

    pulses = np.ascontiguousarray(markov[1:])
    found = getattr(era, reductor)(pulses, 1.0, force_stability=False, feedthrough=markov[0].copy())
    model = found.reduce(order)
    return tuple(M.matrix for M in (model.A, model.B, model.C, model.D))


def sippy_parsim(u: Array, y: Array, order: int, horizon: int) -> Matrices:
    """PARSIM-K of SIPPY, with direct transmission; the horizon is its f and its p."""
    from sippy_unipi import system_identification

    with warnings.catch_warnings(), redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        model = system_identification(
            y.T.copy(), u.T.copy(), "PARSIM-K", SS_fixed_order=order, SS_f=horizon, SS_p=horizon,
            SS_D_required=True,
        )  # fmt: skip
    return model.A, model.B, model.C, model.D


Method = Callable[..., object]
NEEDS: dict[Method, str] = {
    control_markov: "control",
    control_era: "control",
    modred_okid: "modred",
    modred_era: "modred",
    pymor_era: "pymor",
    pymor_randomised_era: "pymor",
    sippy_parsim: "sippy_unipi",
}


def available(methods: Sequence[Method]) -> list[Method]:
    """Those of the methods whose package is installed."""
    return [m for m in methods if m not in NEEDS or installed(NEEDS[m])]
