"""One concealed case on a structure: drawn, recorded, and its truth sealed apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from twin.errors import TwinError

from ..chain import Chain
from ..mechanisms import VERDICT, Mechanism
from ..seal import seal
from .effects import moved
from .kinds import KINDS, Kind, draw_pairs, group_of
from .measuring import measured, write_csv
from .plan import draw_trials
from .strength import FARTHEST, LEFT_NATS, VISIBLE, Bench, draw, shows, weigh
from .structure import Structure

SPREADS = {"damping": 0.02}
SPREAD = 0.003
"""Masses and stiffnesses are off by 0.3 %, damping ratios by 2 %."""

TRIES = 12
"""Strengths tried at a place."""
ATTEMPTS = 12
"""Places tried."""


def generate_structure(table: str, number: int, seed: int, folder: Path, sealed: Path) -> str:
    """Write the recordings of a case and its truth.

    Args:
        table: one of ``KINDS``.
        number: of the case, from 1.
        seed: of the campaign; same seed, same bytes.
        folder: gets portal_0007/train_1.csv and so on.
        sealed: gets portal_0007.json.

    Returns:
        The SHA-256 of the truth.

    Raises:
        TwinError: nothing of the case's group can be seen and is physical.
    """
    kind, name = KINDS[table], f"{table}_{number:04d}"
    rng = np.random.default_rng([seed, number, crc32(table.encode())])
    off = _off(rng, kind)
    built = kind.assemble(off)
    trials = draw_trials(rng, kind.kit, list(built.drives))
    chain = Chain.draw(rng)
    chain = Chain("filtered", chain.order, chain.noise)
    bench = Bench.of(kind, built, trials[:4], chain)
    effects, evidence = _conceal(rng, table, group_of(table, number, seed), bench, name)
    units = {channel: sensor.unit for channel, sensor in built.sensors.items()}
    floor = {}
    for trial in trials:
        inputs, seen, _ = moved(built, effects, trial, kind.kit)
        quiet = Chain(chain.style, chain.order, 0.0)
        exact = measured(quiet, inputs, seen, units, kind.encoder, effects, rng)
        columns = measured(chain, inputs, seen, units, kind.encoder, effects, rng)
        write_csv(folder / name / f"{trial.name}.csv", columns)
        floor[trial.name] = _floor(columns, exact, list(seen))
    nominal = kind.assemble({})
    truth = {
        "case": name,
        "table": table,
        "model": kind.model,
        "number": number,
        "seed": seed,
        "effects": [_entry(m, built, nominal) for m in effects],
        "expected": VERDICT.get(effects[0].name, "missing_physics") if effects else "consistent",
        **_entry(effects[0] if effects else Mechanism(), built, nominal),
        "alike": dict(nominal.alike),
        "noise": chain.noise,
        "style": chain.style,
        "chain": asdict(chain),
        "off": off,
        "plan": [trial.as_json() for trial in trials],
        "recorded": list(built.sensors),
        "effect_over_noise": evidence.get("change_over_noise", 0.0),
        "evidence": evidence,
        "floor": floor,
    }
    return seal(sealed / f"{name}.json", truth)


def reference_of(truth: Mapping[str, Any]) -> dict[str, float]:
    """Return the NRMSE that the noise of the test recordings alone leaves, pooled."""
    tests = [value for name, value in truth["floor"].items() if name.startswith("test")]
    pooled = float(np.sqrt(np.mean(np.square(tests))))
    return {"fit": pooled, "fit_ahead": pooled}


def _floor(noisy: Mapping[str, Any], exact: Mapping[str, Any], seen: list[str]) -> float:
    shares = [
        np.mean((noisy[key] - exact[key]) ** 2) / np.mean(noisy[key] ** 2)
        for key in noisy
        if key.partition(" [")[0] in seen
    ]
    return float(np.sqrt(np.mean(shares)))


def _off(rng: np.random.Generator, kind: Kind) -> dict[str, float]:
    """Draw by how much a structure as built differs from its drawing."""
    nominal = kind.assemble({})
    springs = [name for name in (*nominal.scales, *nominal.alike) if _is_spring(name)]
    names = [*nominal.bodies, *springs]
    off = {name: 1 + SPREAD * rng.standard_normal() for name in names}
    for i in range(4):
        off[f"damping{i + 1}"] = 1 + SPREADS["damping"] * rng.standard_normal()
    return {name: float(value) for name, value in off.items()}


def _is_spring(name: str) -> bool:
    return "_column" in name or name.startswith("hinge")


def _conceal(
    rng: np.random.Generator, table: str, group: str, bench: Bench, name: str
) -> tuple[tuple[Mechanism, ...], dict[str, float]]:
    """Draw effects that show, that no calibration hides and that have one place."""
    if group == "nothing":
        return (), {}
    calibrations = np.empty((0, 0)) if bench.kind.kit.loop else bench.calibrations()
    for _ in range(ATTEMPTS):
        pairs = draw_pairs(rng, group, table, bench.structure)
        for _ in range(TRIES):
            effects = tuple(draw(rng, m, place, bench) for m, place in pairs)
            evidence = _evidence(bench, effects, calibrations)
            if evidence is not None:
                return effects, evidence
    raise TwinError(f"{name}: no effect of the group '{group}' can be seen and is physical")


def _evidence(
    bench: Bench, effects: tuple[Mechanism, ...], calibrations: np.ndarray
) -> dict[str, float] | None:
    """Return how well a case's effects show; None where they do not, or are not physical."""
    try:
        change, farthest = bench.change(effects)
    except (np.linalg.LinAlgError, ZeroDivisionError):
        return None
    if not (np.all(np.isfinite(change)) and farthest < FARTHEST):
        return None
    found = {"change_over_noise": shows(bench, change)}
    if found["change_over_noise"] < VISIBLE:
        return None
    for m in effects:
        if len(effects) > 1:
            rest = [other for other in effects if other is not m]
            change = bench.change(effects)[0] - bench.change(rest)[0]
            found[f"change_over_noise_of_{m.name}"] = shows(bench, change)
            if found[f"change_over_noise_of_{m.name}"] < VISIBLE:
                return None
        weighed = weigh(bench, m, change, calibrations)
        least = min(value for key, value in weighed.items())
        if least < LEFT_NATS:
            return None
        found |= {f"{m.name} {key}" if len(effects) > 1 else key: v for key, v in weighed.items()}
    return found


def _entry(m: Mechanism, built: Structure, nominal: Structure) -> dict[str, Any]:
    """Return an effect as a diagnosis sees it: a change counts from the nominal value."""
    parameters = dict(m.parameters)
    if m.name == "mass":
        parameters["change"] += built.bodies[m.location].kg - nominal.bodies[m.location].kg
    elif m.name == "stiffness":
        parameters["change"] += built.scales[m.location] - nominal.scales[m.location]
    return {
        "mechanism": m.name,
        "location": m.location,
        "parameters": parameters,
        "form": m.form,
    }
