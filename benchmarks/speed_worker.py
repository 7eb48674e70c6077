"""One measurement in a process of its own: time and peak memory of one method on one file.

``identification_speed.py`` starts it; it prints one line of JSON.
"""

from __future__ import annotations

import json
import resource
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import peers
from numpy.typing import NDArray
from scipy import signal

from twin.identification.era import era
from twin.identification.okid import okid

Array = NDArray[np.float64]

MARKOV_PARAMETERS = 400
"""What ERA gets; the length of python-control's regression."""
SPEND_S = 1.0
NOISE = 0.01


def twin_okid(u: Array, y: Array, p: int, count: int) -> Array:
    return okid([(u, y)], p).markov(count)


def twin_okid_era(u: Array, y: Array, p: int, order: int) -> Array:
    return era(twin_okid(u, y, p, MARKOV_PARAMETERS)).realize(order, 1.0, u.shape[1]).A


def twin_era(markov: Array, order: int) -> Array:
    return era(markov, keep=order).realize(order, 1.0, 1).A


METHODS = {
    "twin OKID": lambda d: twin_okid(d["u"], d["y"], int(d["p"]), int(d["p"])),
    "twin OKID, 400 parameters": lambda d: twin_okid(
        d["u"], d["y"], int(d["p"]), MARKOV_PARAMETERS
    ),
    "modred OKID": lambda d: peers.modred_okid(d["u"], d["y"], int(d["p"])),
    "python-control markov": lambda d: peers.control_markov(d["u"], d["y"], MARKOV_PARAMETERS),
    "twin OKID + ERA": lambda d: twin_okid_era(d["u"], d["y"], int(d["p"]), int(d["order"])),
    "SIPPY PARSIM-K": lambda d: peers.sippy_parsim(d["u"], d["y"], int(d["order"]), int(d["p"]))[0],
    "twin ERA": lambda d: twin_era(d["markov"], int(d["order"])),
    "pymor randomised ERA": lambda d: peers.pymor_randomised_era(d["markov"], int(d["order"]))[0],
    "pymor ERA": lambda d: peers.pymor_era(d["markov"], int(d["order"]))[0],
    "python-control ERA": lambda d: peers.control_era(d["markov"], int(d["order"]))[0],
    "modred ERA": lambda d: peers.modred_era(d["markov"], int(d["order"]))[0],
}


def structure(modes: int, outputs: int, columns: int) -> tuple[Array, Array, Array]:
    """Poles and residues of a lightly damped structure: (modes,), (outputs, modes), (modes, q)."""
    rng = np.random.default_rng(0)
    omega = np.linspace(0.2, 2.4, modes)
    poles = np.exp((-0.01 + 1j * np.sqrt(1 - 0.01**2)) * omega)
    shapes = rng.standard_normal((outputs, modes)) * np.exp(0.1j * rng.standard_normal(modes))
    return poles, shapes, rng.standard_normal((modes, columns))


def make_record(path: Path, samples: int, outputs: int, p: int) -> None:
    """Write a record of white noise driving a structure, 1 % noise on its outputs."""
    modes = min(outputs, 8)
    poles, shapes, _ = structure(modes, outputs, 1)
    rng = np.random.default_rng(1)
    u = rng.standard_normal((samples, 1))
    y = np.zeros((samples, outputs))
    for pole, shape in zip(poles, shapes.T, strict=True):
        state = signal.lfilter([0, 1], [1, -pole], u[:, 0].astype(complex))
        for channel in range(outputs):
            y[:, channel] += (state * shape[channel]).real
    y += NOISE * y.std() * rng.standard_normal(y.shape)
    powers = poles ** np.arange(p - 1)[:, None]
    true = np.einsum("mn,kn->km", shapes, powers).real[:, :, None]
    true = np.concatenate([np.zeros((1, outputs, 1)), true])
    np.savez(path, u=u, y=y, p=p, order=2 * modes, true=true)


def make_markov(path: Path, count: int, outputs: int, columns: int) -> None:
    """Write the Markov parameters of a structure with 0.1 % noise."""
    poles, shapes, drive = structure(8, outputs, columns)
    powers = poles ** np.arange(count)[:, None]
    markov = np.zeros((count + 1, outputs, columns))
    markov[1:] = np.einsum("mn,kn,nq->kmq", shapes, powers, drive, optimize=True).real
    markov[1:] += 1e-3 * markov.std() * np.random.default_rng(2).standard_normal(markov[1:].shape)
    np.savez(path, markov=markov, order=2 * len(poles), poles=poles)


def deviation(answer: Array, data: dict[str, Array]) -> float:
    """Relative error of Markov parameters 0 .. p-1, or the largest error of the poles."""
    if "true" in data and answer.ndim == 3:
        true = data["true"]
        return float(np.linalg.norm(answer[: len(true), :, :1] - true) / np.linalg.norm(true))
    if "poles" not in data:
        return float("nan")
    found = np.linalg.eigvals(answer)
    return float(max(np.abs(found - pole).min() for pole in data["poles"]))


def peak_mib() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measure(method: str, small: Path, path: Path, repeats: int, limit_gib: float) -> dict:
    """Processor time, and peak memory beyond that of a process that did a small task.

    The memory includes the data. With one thread, processor time is what the clock shows on an
    idle machine; on a busy one the clock shows the others too.
    """
    limit = int(limit_gib * 2**30)
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    with np.load(small) as file:
        METHODS[method](dict(file))  # loads what the packages import late
    before = peak_mib()
    with np.load(path) as file:
        data = dict(file)
    seconds: list[float] = []
    while len(seconds) < repeats and sum(seconds) < SPEND_S:
        start = time.process_time()
        answer = np.asarray(METHODS[method](data))
        seconds.append(time.process_time() - start)
        if len(seconds) == 1:
            peak = peak_mib() - before
    return {
        "seconds": float(np.median(seconds)),
        "peak_mib": peak,
        "deviation": deviation(answer, data),
    }


def main() -> None:
    warnings.simplefilter("ignore")
    request = json.loads(sys.argv[1])
    path = Path(request["path"])
    if request["do"] == "record":
        make_record(path, *request["size"])
    elif request["do"] == "markov":
        make_markov(path, *request["size"])
    else:
        small, repeats, limit = Path(request["small"]), request["repeats"], request["limit_gib"]
        try:
            print(json.dumps(measure(request["method"], small, path, repeats, limit)))
        except (MemoryError, np.linalg.LinAlgError) as error:
            print(json.dumps({"failed": type(error).__name__}))


if __name__ == "__main__":
    main()
