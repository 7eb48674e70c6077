"""How accurate the identification is, through the whole instrument chain, against the bound.

Repeats one virtual test many times with fresh noise and compares every route's errors with the
Cramer-Rao bound: plain OKID/ERA for several observer lengths, ERA on the free decay, and the
maximum-likelihood estimate that ``twin identify`` takes by default.

    python experiments/identification_accuracy.py --test hammer --draws 200
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from twin.errors import TwinError
from twin.estimation.noise import NoiseLevels, covariance, whitener
from twin.identification.era import era
from twin.identification.identify import identify
from twin.identification.modal_response import frequency_response
from twin.identification.modal_start import from_poles
from twin.identification.normal_equations import equations
from twin.identification.okid import okid
from twin.identification.records import prepare
from twin.identification.seminormal import covariance_of
from twin.identification.spectra import spectrum
from twin.identification.stabilisation import continuous_poles
from twin.identification.starts import free_decay_markov
from twin.instruments import Instrument
from twin.laboratory import Experiment, Hammer, RandomShaking, run
from twin.modal import poles_to_modal
from twin.model import Twin

OBSERVER_LENGTHS = (4, 10, 20, 40, 80)
NOISE = 0.01


def experiment(test: str, noise: float) -> Experiment:
    instruments = {kind: Instrument(noise_fraction=noise) for kind in ("acc", "force")}
    if test == "hammer":
        return Experiment(Hammer(), instruments=instruments)
    place = "ground" if test == "ground" else "floor1"
    return Experiment(RandomShaking(), at=place, instruments=instruments)


def rig(test: str) -> Twin:
    lumped = Twin.load("two_storey_lumped")
    return lumped.released() if test == "ground" else lumped


def bound(test: str, seed: int) -> np.ndarray:
    """Cramer-Rao bound at the true parameters, with noise on outputs and on the input.

    A hammer's force is known to be zero outside its hit, so its noise counts only inside.
    """
    true = rig(test).modes()
    clean = run(experiment(test, 0.0), Twin.load("two_storey_lumped"), seed)
    records = prepare([clean])
    u, y = records.pairs[0]
    s = spectrum(u, y, records.dt, (0.0, 0.5 * clean.sampling_hz))
    p = from_poles(true.poles, [s], "band-limited", float(s.omega[-1]), False)
    inside = records.hits[0]
    share = 1.0 if inside is None else 0.0
    levels = NoiseLevels((NOISE * rms(y)) ** 2, share * (NOISE * rms(u)) ** 2)
    whiten = whitener(covariance(levels, frequency_response(p, s, "band-limited", s.omega[-1])))
    fisher = equations(p, [s], [whiten], "band-limited", float(s.omega[-1]), False).gram
    std = np.sqrt(np.diag(covariance_of(fisher)))
    n = len(true.natural_freq)
    return np.concatenate([std[:n] * true.natural_freq, std[n : 2 * n]])


def rms(x: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(x**2, axis=0))


def one_draw(test: str, seed: int, draw: int) -> dict[str, list[float] | None]:
    """Every route's estimates (frequencies, then damping ratios) from one noisy recording."""
    # The excitation stays the same in every draw, so that one bound belongs to all of them.
    clean = run(experiment(test, 0.0), Twin.load("two_storey_lumped"), seed)
    rng = np.random.default_rng([seed, draw])
    noisy = clean.data + NOISE * rms(clean.data) * rng.standard_normal(clean.data.shape)
    recording = type(clean)(clean.sampling_hz, clean.channels, noisy)
    records = prepare([recording])
    modes = len(rig(test).floors) + (test == "ground")
    found: dict[str, list[float] | None] = {}
    for p in OBSERVER_LENGTHS:
        markov = okid(records.pairs, p).markov(400)
        found[f"OKID/ERA, p = {p}"] = of_model(markov, 2 * modes, records.dt, len(records.inputs))
    decay = free_decay_markov(records)
    if decay is not None:
        markov = np.concatenate([np.zeros((1, *decay.shape[1:])), decay[:800]])
        found["ERA on the free decay"] = of_model(markov, 2 * modes, records.dt, 1)
    try:
        result = identify([recording])
    except TwinError:
        found["refined"] = None
        return found
    if len(result.modal.natural_freq) != modes:
        found["refined"] = None
        return found
    found["refined"] = [*result.modal.natural_freq, *result.modal.damping_ratio]
    stds = (result.modal.natural_freq_std, result.modal.damping_ratio_std)
    assert all(s is not None for s in stds)
    found["std"] = [*stds[0], *stds[1]]
    true = rig(test).second_order()
    if result.second_order is not None:
        order = [result.second_order.coordinates.index(c) for c in true.coordinates]
        for name in ("M", "K"):
            mine = getattr(result.second_order, name)[np.ix_(order, order)]
            theirs = getattr(true, name)
            found[name] = list((np.diag(mine) / np.diag(theirs) - 1).tolist())
    return found


def of_model(markov: np.ndarray, order: int, dt: float, inputs: int) -> list[float] | None:
    poles, _ = continuous_poles(era(markov).realize(order, dt, inputs))
    if len(poles) != order // 2:
        return None
    freq, damping = poles_to_modal(poles)
    return [*freq, *damping]


def summary(draws: list[dict], true: np.ndarray, limit: np.ndarray) -> dict[str, dict]:
    rows: dict[str, dict] = {}
    for route in [k for k in draws[0] if k not in ("std", "M", "K")]:
        values = np.array([d[route] for d in draws if d[route] is not None])
        error = values - true if len(values) else np.full((1, len(true)), np.nan)
        rows[route] = {
            "bias_percent": (100 * error.mean(axis=0) / true).tolist(),
            "spread_percent": (100 * error.std(axis=0) / true).tolist(),
            "rmse_over_bound": (rms(error) / limit).tolist(),
            "bias_over_bound": (error.mean(axis=0) / limit).tolist(),
            "failed": len(draws) - len(values),
        }
    good = [d for d in draws if d["refined"] is not None]
    error = np.array([d["refined"] for d in good]) - true
    std = np.array([d["std"] for d in good])
    rows["refined"]["coverage_95"] = np.mean(np.abs(error) < 1.96 * std, axis=0).tolist()
    for name in ("M", "K"):
        off = np.array([d[name] for d in good if name in d])
        rows["refined"][f"{name}_rmse_percent"] = (100 * rms(off)).tolist()
        rows["refined"][f"{name}_bias_percent"] = (100 * off.mean(axis=0)).tolist()
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--test", choices=("hammer", "floor", "ground"), default="hammer")
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    console = Console()
    modes = rig(chosen.test).modes()
    true = np.concatenate([modes.natural_freq, modes.damping_ratio])
    limit = bound(chosen.test, chosen.seed)
    work = partial(one_draw, chosen.test, chosen.seed)
    with ProcessPoolExecutor(chosen.jobs) as pool:
        results = pool.map(work, range(chosen.draws), chunksize=4)
        draws = list(track(results, "draws", chosen.draws, console=console, transient=True))
    rows = summary(draws, true, limit)
    n = len(modes.natural_freq)
    names = [f"f{i + 1}" for i in range(n)] + [f"zeta{i + 1}" for i in range(n)]
    title = f"{chosen.test}: {chosen.draws} draws, {100 * NOISE:g} % noise on every channel"
    for quantity, digits in (("bias_percent", 4), ("spread_percent", 4), ("rmse_over_bound", 2)):
        table = Table("route", *names, "failed", title=f"{title}; {quantity.replace('_', ' ')}")
        for route, row in rows.items():
            cells = [f"{x:.{digits}f}" for x in row[quantity]]
            table.add_row(route, *cells, str(row["failed"]))
        console.print(table)
    table = Table("refined", *names, title="the default route of twin identify")
    table.add_row("bound [%]", *[f"{100 * x:.5f}" for x in limit / true])
    for quantity in ("rmse_over_bound", "bias_over_bound", "coverage_95"):
        table.add_row(quantity.replace("_", " "), *[f"{x:.3f}" for x in rows["refined"][quantity]])
    console.print(table)
    for name in ("M", "K"):
        cells = ", ".join(f"{x:.2f}" for x in rows["refined"][f"{name}_rmse_percent"])
        console.print(f"RMSE of the diagonal of {name} [%]: {cells}")
    if chosen.json:
        chosen.json.write_text(json.dumps({"bound": limit.tolist(), "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
