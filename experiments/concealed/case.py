"""One concealed case: a rig, a plan, one effect; its recordings, and the truth sealed apart."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from twin.errors import TwinError, available
from twin.formats import write_recording

from .chain import Chain, at_sensor, measure
from .distinct import evidence
from .integrator import simulate
from .mechanisms import Mechanism, build, unmeasured
from .plans import FADE_S, FINE, FINE_HZ, Test, band_limited, draw_plan, excitation, log_uniform
from .rig import TWO_STOREY, Array, Rig
from .seal import seal
from .strengths import Motion, draw
from .tables import TABLES, case_name, combination_of, expected, stream

__all__ = ["Case", "case_name", "draw_case", "from_truth", "generate", "motion"]

COARSE = 4
"""Strengths are set, and the effect is judged, on a grid this much coarser."""

VISIBLE = 3.0
"""The effect changes the outputs of some training recording by at least this many times noise."""

CLEAR_NATS = 25.0
"""A soft base is by so much likelier than the best frame on a hard one."""

Run = tuple[Array, Array]
FARTHEST_M = 0.12
"""No drift goes beyond this: a storey of the frame is 0.3 m high."""

TRIES = 60


@dataclass(frozen=True)
class Case:
    """All that a case is made of, its truth included.

    Attributes:
        name: "case_0007".
        rig: as built.
        nominal: what the diagnosis is told.
        plan: its tests.
        chain: how it is measured.
        mechanism: what is concealed.
        effect: the largest change of a training recording's outputs, as a share of their RMS.
        table: of the cases that this is one of.
    """

    name: str
    rig: Rig
    nominal: Rig
    plan: tuple[Test, ...]
    chain: Chain
    mechanism: Mechanism
    effect: float
    table: str = "single"

    @property
    def visible_parameters(self) -> dict[str, float]:
        """The parameters as a diagnosis sees them: a change counts from the nominal value."""
        found, i = dict(self.mechanism.parameters), self.mechanism.index
        if self.mechanism.name == "stiffness":
            found["change"] += self.rig.stiffnesses[i] - self.nominal.stiffnesses[i]
        elif self.mechanism.name == "mass":
            found["change"] += self.rig.masses[i] - self.nominal.masses[i]
        return found

    def truth(self, number: int, seed: int) -> dict[str, Any]:
        """Return the truth as plain types."""
        one = {
            "mechanism": self.mechanism.name,
            "location": self.mechanism.location,
            "parameters": self.visible_parameters,
            "form": self.mechanism.form,
        }
        effects = (self.mechanism,) if self.mechanism.name != "none" else ()
        return {
            "case": self.name,
            "table": self.table,
            "model": self.nominal.model,
            "effects": [one] if effects else [],
            "expected": expected(self.table, effects),
            "number": number,
            "seed": seed,
            **one,
            "built_in": self.mechanism.as_json(),
            "nominal": self.nominal.as_json(),
            "noise": self.chain.noise,
            "style": self.chain.style,
            "chain": asdict(self.chain),
            "rig": self.rig.as_json(),
            "plan": [test.as_json() for test in self.plan],
            "effect_over_noise": self.effect / self.chain.noise,
        }


def from_truth(truth: dict[str, Any]) -> Case:
    """Undo ``Case.truth``."""
    return Case(
        truth["case"],
        Rig.from_json(truth["rig"]),
        Rig.from_json(truth["nominal"]),
        tuple(Test(**test) for test in truth["plan"]),
        Chain(**truth["chain"]),
        Mechanism.from_json(truth["built_in"]),
        truth["effect_over_noise"] * truth["noise"],
        truth["table"],
    )


def generate(
    number: int, seed: int, folder: Path, sealed: Path, table: str = "single",
    nominal: Rig = TWO_STOREY,
) -> str:  # fmt: skip
    """Write the recordings of a case and its truth.

    Args:
        number: of the case, from 1; with seed and table it says what is concealed where.
        seed: of the campaign; same seed, same bytes.
        folder: gets case_0007/train_1.csv and so on, none_0007 where nothing is concealed.
        sealed: gets case_0007.json.
        table: one of ``TABLES``; "none" conceals nothing.
        nominal: the rig before its scatter.

    Returns:
        The SHA-256 of the truth.

    Raises:
        TwinError: there is no such table.
    """
    if table not in TABLES:
        raise TwinError(f"no table '{table}' of concealed cases; there are {available(TABLES)}")
    pairs = combination_of(table, number, seed, nominal.storeys)
    for attempt in range(TRIES):
        # a spring that softens may lose a hit that the drawing did not look at: then once more
        key = [seed, number, stream(table), *([attempt] if attempt else [])]
        rng = np.random.default_rng(key)
        drawn = draw_case(rng, case_name(number, table), pairs[0] if pairs else None, nominal)
        case = replace(drawn, table=table)
        moved = [motion(case, test) for test in case.plan]
        if all(np.all(np.isfinite(seen)) for _, seen, _ in moved):
            break
    for test, (forces, seen, _) in zip(case.plan, moved, strict=True):
        recording = measure(case.chain, test, forces, seen, case.mechanism, rng)
        write_recording(recording, folder / case.name / f"{test.name}.csv")
    return seal(sealed / f"{case.name}.json", case.truth(number, seed))


def draw_case(
    rng: np.random.Generator, name: str, pair: tuple[str, str] | None, nominal: Rig = TWO_STOREY
) -> Case:
    """Draw a rig, a plan, a chain and a strength whose effect can be seen and stays physical.

    Raises:
        TwinError: no strength would do.
    """
    rig = nominal.scattered(rng)
    plan, chain = draw_plan(rng, rig.storeys), Chain.draw(rng)
    case = Case(name, rig, nominal, plan, chain, Mechanism(), 0.0)
    if pair is None:
        return case
    training = [test for test in plan if test.name.startswith("train")]
    healthy = [motion(case, test, COARSE)[1:] for test in training]
    scale = Motion.of(rig, healthy)
    for _ in range(TRIES):
        tried = replace(case, mechanism=draw(rng, *pair, rig, scale))
        if pair[0] == "unmeasured_force":
            tried = _scaled(rng, tried, training, healthy)
        moved = [motion(tried, test, COARSE)[1:] for test in training]
        effect = max(
            _effect(tried.mechanism, a, b, FINE_HZ / COARSE)
            for a, b in zip(healthy, moved, strict=True)
        )
        if pair[1].startswith("force_"):
            effect = abs(tried.mechanism["gain"] - 1)
        if pair[0] == "base_compliance":
            system = build(rig, tried.mechanism)
            if evidence(rig, system, training, chain.fine, chain.noise) < CLEAR_NATS:
                continue
        n = rig.storeys
        farthest = max(np.abs(states[:, :n] @ rig.drifts.T).max() for _, states in moved)
        if farthest < FARTHEST_M and effect > VISIBLE * chain.noise:  # NaN fails the first
            return replace(tried, effect=float(effect))
    raise TwinError(f"{name}: no strength of {pair[0]} at {pair[1]} can be seen and is physical")


def motion(case: Case, test: Test, stride: int = 1) -> tuple[Array, Array, Array]:
    """Return forces, accelerations and states of a test, the mechanism built in.

    ``stride`` coarsens the integrator's grid.
    """
    forces = excitation(test, case.rig.storeys, case.chain.fine)[::stride]
    acting, seen_besides = forces, np.zeros((1, 1))
    if case.mechanism.name == "unmeasured_force":
        waveform = _waveform(case.mechanism, test)[::stride]
        acting = forces + unmeasured(case.rig, case.mechanism, waveform)
        if case.mechanism.location == "ground":
            seen_besides = waveform[:, None]
    seen, states = simulate(build(case.rig, case.mechanism), acting, stride / FINE_HZ)
    return forces, seen + seen_besides, states


def _effect(mechanism: Mechanism, healthy: Run, moved: Run, rate: float) -> float:
    """Return the change of the outputs as a share of their RMS, pooled over channels."""
    given = at_sensor(moved[0], mechanism, rate)
    return float(np.sqrt(np.sum((given - healthy[0]) ** 2) / np.sum(healthy[0] ** 2)))


def _scaled(rng: np.random.Generator, case: Case, tests: list[Test], healthy: list[Run]) -> Case:
    """Return the case with an unmeasured force of a drawn effect in the middle recording."""
    moved = [motion(case, test, COARSE)[1:] for test in tests]
    rate = FINE_HZ / COARSE
    pairs = zip(healthy, moved, strict=True)
    unit = np.exp(np.mean([np.log(_effect(case.mechanism, a, b, rate)) for a, b in pairs]))
    wanted = log_uniform(rng, VISIBLE * case.chain.noise, 0.5)
    parameters = {**dict(case.mechanism.parameters), "rms": float(wanted / unit)}
    return replace(case, mechanism=replace(case.mechanism, parameters=tuple(parameters.items())))


def _waveform(m: Mechanism, test: Test) -> Array:
    """Return the unmeasured force [N] or ground acceleration [m/s^2] of a recording."""
    rng = np.random.default_rng([test.seed, 5])
    count = (test.samples - 1) * FINE + 1
    time = np.arange(count) / FINE_HZ
    if m.form == "sine":
        phase = rng.uniform(0, 2 * np.pi)
        return np.asarray(m["rms"] * np.sqrt(2) * np.sin(2 * np.pi * m["frequency"] * time + phase))
    width = 0.2 * m["frequency"] if m.form == "narrow" else 7.25
    noise = band_limited(rng, count, FINE_HZ, m["frequency"] - width, m["frequency"] + width)
    return m["rms"] * noise * np.minimum(time / FADE_S, 1.0)
