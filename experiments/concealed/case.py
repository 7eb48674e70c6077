"""One concealed case: a rig, a plan, its effects; its recordings, and the truth sealed apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from twin.errors import TwinError, available
from twin.formats import write_recording

from .chain import Chain, measure
from .drawing import TRIES, conceal
from .frames import nominal_of, write_model
from .mechanisms import Mechanism
from .motions import motion
from .nearest import explained_share, port_of
from .plans import FINE_HZ, Test, draw_plan, on_ground
from .rig import Array, Rig
from .seal import seal
from .structures.cases import generate_structure
from .tables import KNOWN, STRUCTURES, Combination, case_name, combination_of, expected, stream

__all__ = ["Case", "case_name", "draw_case", "from_truth", "generate", "moved"]


@dataclass(frozen=True)
class Case:
    """All that a case is made of, its truth included.

    Attributes:
        name: "case_0007".
        table: of the cases that this is one of.
        rig: as built.
        nominal: what the diagnosis is told.
        plan: its tests.
        chain: how it is measured.
        recorded: floors whose accelerometers are recorded, from 1.
        effects: what is concealed, the stronger or the only one first.
        effect: the largest change of a training recording's outputs, as a share of their RMS.
        evidence: what was asked of the strengths and what they reach; see the tables' modules.
    """

    name: str
    table: str
    rig: Rig
    nominal: Rig
    plan: tuple[Test, ...]
    chain: Chain
    recorded: tuple[int, ...]
    effects: tuple[Mechanism, ...] = ()
    effect: float = 0.0
    evidence: tuple[tuple[str, float], ...] = ()

    @property
    def mechanism(self) -> Mechanism:
        """The first effect, "none" where there is none."""
        return self.effects[0] if self.effects else Mechanism()

    @property
    def training(self) -> tuple[Test, ...]:
        """The tests that a diagnosis may learn from."""
        return tuple(test for test in self.plan if test.name.startswith("train"))

    def has(self, name: str) -> Mechanism | None:
        """Return the effect of a name, if it is one of the case's."""
        return next((m for m in self.effects if m.name == name), None)

    def visible_parameters(self, m: Mechanism) -> dict[str, float]:
        """Return parameters as a diagnosis sees them: a change counts from the nominal value."""
        found, i = dict(m.parameters), m.index
        if m.name == "stiffness":
            found["change"] += self.rig.stiffnesses[i] - self.nominal.stiffnesses[i]
        elif m.name == "mass":
            found["change"] += self.rig.masses[i] - self.nominal.masses[i]
        return found

    def _entry(self, m: Mechanism) -> dict[str, Any]:
        return {
            "mechanism": m.name,
            "location": m.location,
            "parameters": self.visible_parameters(m),
            "form": m.form,
        }

    def truth(self, number: int, seed: int) -> dict[str, Any]:
        """Return the truth as plain types."""
        return {
            "case": self.name,
            "table": self.table,
            "model": self.nominal.model,
            "number": number,
            "seed": seed,
            "effects": [self._entry(m) for m in self.effects],
            "expected": expected(self.table, self.effects),
            **self._entry(self.mechanism),
            "built_in": [m.as_json() for m in self.effects],
            "nominal": self.nominal.as_json(),
            "noise": self.chain.noise,
            "style": self.chain.style,
            "chain": asdict(self.chain),
            "rig": self.rig.as_json(),
            "plan": [test.as_json() for test in self.plan],
            "recorded": list(self.recorded),
            "effect_over_noise": self.effect / self.chain.noise,
            "evidence": dict(self.evidence),
        }


def from_truth(truth: dict[str, Any]) -> Case:
    """Undo ``Case.truth``."""
    return Case(
        truth["case"],
        truth["table"],
        Rig.from_json(truth["rig"]),
        Rig.from_json(truth["nominal"]),
        tuple(Test(**test) for test in truth["plan"]),
        Chain(**truth["chain"]),
        tuple(truth["recorded"]),
        tuple(Mechanism.from_json(entry) for entry in truth["built_in"]),
        truth["effect_over_noise"] * truth["noise"],
        tuple(truth["evidence"].items()),
    )


def generate(
    number: int, seed: int, folder: Path, sealed: Path, table: str = "single",
    nominal: Rig | None = None, sensors: Callable[[Array, float], Array] | None = None,
) -> str:  # fmt: skip
    """Write the recordings of a case and its truth.

    Args:
        number: of the case, from 1; with seed and table it says what is concealed where.
        seed: of the campaign; same seed, same bytes.
        folder: gets case_0007/train_1.csv and so on, none_0007 where nothing is concealed; and
            model.xml, where the model that a diagnosis is told does not come with the package.
        sealed: gets case_0007.json.
        table: one of ``KNOWN``; "none" conceals nothing.
        nominal: the rig before its scatter; None for the table's own.
        sensors: what the accelerometers do to accelerations, (samples, floors), at a rate [Hz],
            before any filter; None for sound ones.

    Returns:
        The SHA-256 of the truth.

    Raises:
        TwinError: there is no such table, or no strength that would do.
    """
    if table not in KNOWN:
        raise TwinError(f"no table '{table}' of concealed cases; there are {available(KNOWN)}")
    if table in STRUCTURES:
        return generate_structure(table, number, seed, folder, sealed)
    nominal = nominal or nominal_of(table)
    combination = combination_of(table, number, seed, nominal.storeys)
    for attempt in range(TRIES):
        # a spring that softens may lose a hit that the drawing did not look at: then once more
        key = [seed, number, stream(table), *([attempt] if attempt else [])]
        rng = np.random.default_rng(key)
        try:
            case = draw_case(rng, case_name(number, table), combination, table, nominal)
        except TwinError:
            if attempt == TRIES - 1:
                raise
            continue
        runs = [moved(case, test) for test in case.plan]
        if all(np.all(np.isfinite(seen)) for _, seen, _ in runs):
            break
    if table == "near":
        port = port_of(case.rig, case.mechanism, case.training, runs[: len(case.training)])
        share = explained_share(case.mechanism, port)
        case = replace(case, evidence=(*case.evidence, ("explained", share)))
    for test, (drive, seen, _) in zip(case.plan, runs, strict=True):
        given = seen if sensors is None else sensors(seen, FINE_HZ)
        recording = measure(case.chain, test, drive, given, case.effects, case.recorded, rng)
        write_recording(recording, folder / case.name / f"{test.name}.csv")
    write_model(nominal, folder / case.name)
    return seal(sealed / f"{case.name}.json", case.truth(number, seed))


def draw_case(
    rng: np.random.Generator, name: str, combination: Combination, table: str = "single",
    nominal: Rig | None = None,
) -> Case:  # fmt: skip
    """Draw a rig, a plan, a chain and strengths that can be seen and stay physical.

    Raises:
        TwinError: no strength would do.
    """
    nominal = nominal or nominal_of(table)
    rig = nominal.scattered(rng)
    plan, chain = draw_plan(rng, rig.storeys), Chain.draw(rng)
    if table == "ground":
        plan = on_ground(plan)
    recorded = tuple(range(1, rig.storeys + 1))
    if table == "one_sensor":
        recorded = (_only(rng, combination, rig.storeys),)
    case = Case(name, table, rig, nominal, plan, chain, recorded)
    found = conceal(rng, table, combination, rig, case.training, chain, recorded, name)
    return replace(case, effects=found.effects, effect=found.effect, evidence=found.evidence)


def _only(rng: np.random.Generator, combination: Combination, storeys: int) -> int:
    """Return the floor whose accelerometer is left: a faulty sensor's own, else any."""
    for name, location in combination:
        if name.startswith("sensor_") and location.startswith("acc_"):
            return int(location[-1])
    return int(rng.integers(storeys)) + 1


def moved(case: Case, test: Test, stride: int = 1) -> tuple[Array, Array, Array]:
    """Return what drives a test of the case, the floors' accelerations and the states."""
    return motion(case.rig, case.effects, test, case.chain.fine, stride)
