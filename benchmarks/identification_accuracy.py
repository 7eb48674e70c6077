"""Errors of every route and every peer over the Cramer-Rao bound, on the same noisy records.

Repeats one virtual test with fresh noise. ``hammer`` and ``floor`` (a random shaker) pass through
the whole instrument chain: the force is not constant between samples, the anti-alias filter rings.
``held`` is the hammer's force held between samples, which discrete models are exact for; its force
is known and only the accelerations are noisy.

The peers get what our own OKID gets: the force outside the hits set to zero, the true order, and
each of the settings listed. Their best setting counts.

    python benchmarks/identification_accuracy.py --test hammer --draws 50 \
        --json benchmarks/results/identification_accuracy.json
"""

# ruff: noqa: E402  (numpy reads the number of threads when it is imported)
from __future__ import annotations

import argparse
import json
import os
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import numpy as np
import peers
from machine import described
from rich.console import Console
from rich.progress import track
from rich.table import Table

from twin.errors import TwinError
from twin.estimation.noise import NoiseLevels, covariance, whitener
from twin.identification.era import era
from twin.identification.identify import identify
from twin.identification.modal_response import Hold, frequency_response
from twin.identification.modal_start import from_poles
from twin.identification.normal_equations import equations
from twin.identification.okid import okid
from twin.identification.records import Records, prepare
from twin.identification.seminormal import covariance_of
from twin.identification.spectra import spectrum
from twin.identification.stabilisation import continuous_poles
from twin.identification.starts import free_decay_markov
from twin.instruments import Instrument
from twin.laboratory import Experiment, Hammer, RandomShaking, run
from twin.modal import ModalModel, poles_to_modal
from twin.model import Twin
from twin.recording import Recording
from twin.state_space import StateSpace

Array = np.ndarray
SEED = 0
NOISE = 0.01
"""Share of every channel's RMS."""
HELD_FORCE = (0.6, 0.3)
"""[N], at two successive samples."""


def rms(x: Array) -> Array:
    return np.sqrt(np.mean(x**2, axis=0))


def truth() -> ModalModel:
    return Twin.load("two_storey_lumped").modes()


@cache
def clean_recording(test: str) -> Recording:
    """The test without noise; the same in every draw, so that one bound belongs to all."""
    twin = Twin.load("two_storey_lumped")
    if test != "held":
        quiet = {kind: Instrument(noise_fraction=0.0) for kind in ("acc", "force")}
        excitation = Hammer() if test == "hammer" else RandomShaking()
        return run(Experiment(excitation, at="floor1", instruments=quiet), twin, SEED)
    u = np.zeros((1024, 1))
    u[16 : 16 + len(HELD_FORCE), 0] = HELD_FORCE
    y = twin.second_order().acceleration_response(("floor1",)).held(1 / 32).simulate(u)
    columns = {"force_floor1": u[:, 0], "acc_floor1": y[:, 0], "acc_floor2": y[:, 1]}
    return Recording.build(32.0, columns, source="held")


def noisy_recording(test: str, draw: int) -> Recording:
    clean = clean_recording(test)
    level = NOISE * rms(clean.data)
    if test == "held":
        level[0] = 0.0
    noise = level * np.random.default_rng([SEED, draw]).standard_normal(clean.data.shape)
    return Recording(clean.sampling_hz, clean.channels, clean.data + noise, clean.source)


def bound(test: str) -> Array:
    """Cramer-Rao bound of f [Hz] and zeta at the true parameters.

    A hammer's force is known to be zero outside its hit, so its noise does not count there.
    """
    hold: Hold = "held" if test == "held" else "band-limited"
    records, true = prepare([clean_recording(test)]), truth()
    u, y = records.pairs[0]
    s = spectrum(u, y, records.dt, (0.0, 0.5 / records.dt))
    top = float(s.omega[-1])
    p = from_poles(true.poles, [s], hold, top, False)
    on_force = 1.0 if records.hits[0] is None else 0.0
    levels = NoiseLevels((NOISE * rms(y)) ** 2, on_force * (NOISE * rms(u)) ** 2)
    whiten = whitener(covariance(levels, frequency_response(p, s, hold, top)))
    std = np.sqrt(np.diag(covariance_of(equations(p, [s], [whiten], hold, top, False).gram)))
    n = len(true.natural_freq)
    return np.concatenate([std[:n] * true.natural_freq, std[n : 2 * n]])


def of_matrices(found: tuple[Array, Array, Array, Array], dt: float) -> Array | None:
    A, B, C, D = found
    return of_model(StateSpace(A, B, C, D, dt))


def of_model(model: StateSpace) -> Array | None:
    """Frequencies, then damping ratios; None unless every mode oscillates."""
    poles, _ = continuous_poles(model)
    if len(poles) != len(model.A) // 2:
        return None
    return np.concatenate(poles_to_modal(poles))


def refined(recording: Recording, modes: int) -> Array | None:
    result = identify([recording]).modal
    if len(result.natural_freq) != modes:
        return None
    return np.concatenate([result.natural_freq, result.damping_ratio])


def plain(records: Records, p: int, order: int, weighted: bool) -> Array | None:
    """OKID and ERA, without and with weights on the columns of the Markov parameters."""
    observer = okid(records.pairs, p)
    hankel = era(observer.markov(400), driving=observer.driving if weighted else None)
    return of_model(hankel.realize(order, records.dt, len(records.inputs)))


def decay_parameters(records: Records) -> Array:
    """The free decay as Markov parameters of a free response, entry 0 empty."""
    decay = free_decay_markov(records)
    assert decay is not None
    return np.concatenate([np.zeros((1, *decay.shape[1:])), decay[:800]])


Route = Callable[[], Array | None]


def routes(test: str, recording: Recording) -> dict[str, Route]:
    """Every route as a function without arguments; the key's part before the comma is the group."""
    records = prepare([recording])
    (u, y), dt = records.pairs[0], records.dt
    order = 2 * len(truth().natural_freq)
    table: dict[str, Route] = {"twin identify": lambda: refined(recording, order // 2)}
    for p in (20, 80):
        table[f"twin OKID/ERA as in the paper, p = {p}"] = lambda p=p: plain(
            records, p, order, False
        )
        table[f"twin OKID/ERA, columns weighted, p = {p}"] = lambda p=p: plain(
            records, p, order, True
        )
    for m in (400, 800):
        table[f"python-control markov + ERA, m = {m}"] = lambda m=m: of_matrices(
            peers.control_era(peers.control_markov(u, y, m), order), dt
        )
    for p in (100, 200, 340):
        table[f"modred OKID + ERA, p = {p}"] = lambda p=p: of_matrices(
            peers.modred_era(peers.modred_okid(u, y, p), order), dt
        )
    for horizon in (20, 40):
        table[f"SIPPY PARSIM-K, f = p = {horizon}"] = lambda horizon=horizon: of_matrices(
            peers.sippy_parsim(u, y, order, horizon), dt
        )
    table["pymor ERA, python-control markov"] = lambda: of_matrices(
        peers.pymor_era(peers.control_markov(u, y, 800), order), dt
    )
    if records.hits[0] is not None:
        decay = decay_parameters(records)
        table["twin ERA, free decay"] = lambda: of_model(era(decay).realize(order, dt, 1))
        table["pymor ERA, free decay"] = lambda: of_matrices(peers.pymor_era(decay, order), dt)
        table["python-control ERA, free decay"] = lambda: of_matrices(
            peers.control_era(decay, order), dt
        )
    absent = [word for package, word in PACKAGES.items() if not peers.installed(package)]
    return {k: f for k, f in table.items() if not any(word in k for word in absent)}


PACKAGES = {
    "control": "python-control",
    "pymor": "pymor",
    "sippy_unipi": "SIPPY",
    "modred": "modred",
}


def one_draw(test: str, draw: int) -> dict[str, list[float] | None]:
    found: dict[str, list[float] | None] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name, route in routes(test, noisy_recording(test, draw)).items():
            try:
                values = route()
            except (TwinError, np.linalg.LinAlgError, ValueError):
                values = None
            found[name] = None if values is None else values.tolist()
    return found


def summary(draws: list[dict], true: Array, limit: Array) -> dict[str, dict]:
    rows = {}
    for name in draws[0]:
        values = np.array([d[name] for d in draws if d[name] is not None])
        error = values - true if len(values) else np.full((1, len(true)), np.nan)
        rows[name] = {
            "rmse_over_bound": (rms(error) / limit).tolist(),
            "bias_over_bound": (error.mean(axis=0) / limit).tolist(),
            "failed": len(draws) - len(values),
        }
    return rows


def table_of(test: str, draws: int, result: dict) -> Table:
    title = f"{test}: RMSE over the Cramer-Rao bound, {draws} draws, {100 * NOISE:g} % noise"
    names = ("f1", "f2", "zeta1", "zeta2")
    table = Table("route", *names, "failed", title=title)
    table.add_row("bound [%]", *[f"{x:.2g}" for x in result["bound_percent"]], "")
    table.add_section()
    for name, row in sorted(
        result["routes"].items(),
        key=lambda item: np.nan_to_num(max(item[1]["rmse_over_bound"]), nan=1e99),
    ):
        cells = [f"{x:.3g}" for x in row["rmse_over_bound"]]
        table.add_row(name, *cells, str(row["failed"] or ""))
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--test", choices=("hammer", "held", "floor"), default="hammer")
    parser.add_argument("--draws", type=int, default=50)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path, help="update this file with this test")
    chosen = parser.parse_args()
    console = Console()
    for line in peers.missing_lines():
        console.print(line)
    modes = truth()
    true = np.concatenate([modes.natural_freq, modes.damping_ratio])
    limit = bound(chosen.test)
    with ProcessPoolExecutor(chosen.jobs) as pool:
        results = pool.map(partial(one_draw, chosen.test), range(chosen.draws))
        draws = list(track(results, "draws", chosen.draws, console=console, transient=True))
    result = {
        "draws": chosen.draws,
        "bound_percent": (100 * limit / true).tolist(),
        "routes": summary(draws, true, limit),
    }
    console.print(table_of(chosen.test, chosen.draws, result))
    if chosen.json:
        whole = json.loads(chosen.json.read_text()) if chosen.json.exists() else {"tests": {}}
        whole |= {"machine": described(), "versions": peers.versions()}
        whole["tests"][chosen.test] = result
        chosen.json.write_text(json.dumps(whole, indent=1) + "\n")


if __name__ == "__main__":
    main()
