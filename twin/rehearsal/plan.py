"""A test plan: which recordings, with which sensors and noise, and what is to be concealed."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from twin.errors import TwinError, available
from twin.laboratory import Hammer, RandomShaking
from twin.mechanisms import vocabulary
from twin.rehearsal.fields import Fields

Kind = Literal["hammer", "shaker"]
Use = Literal["train", "test"]

KEYS = ("tolerance", "damping_tolerance", "sensors", "noise", "recordings", "conceal")
OF_RECORDING = (
    "kind", "at", "ground", "level", "width_s", "band_hz", "duration_s", "rate_hz", "use", "repeat",
)  # fmt: skip
OF_CONCEAL = ("mechanisms", "places", "sizes", "values")
SHARE = 0.01
"""Noise of an output, as a share of its RMS, where the plan says nothing: as of ``twin test``."""


@dataclass(frozen=True)
class Noise:
    """White noise of a channel: a share of its RMS, and a level in the channel's unit."""

    share: float = 0.0
    std: float = 0.0


@dataclass(frozen=True)
class PlannedTest:
    """One recording of the plan.

    Attributes:
        kind: "hammer" or "shaker".
        at: actuators or floors that are hit or shaken.
        ground: axes along which the ground is shaken instead.
        level: peak of a hammer's force, RMS of a shaker's [N, of a shaken ground m/s^2].
        width_s: contact of the hammer [s].
        band_hz: lowest and highest frequency of the shaker [Hz].
        duration_s: length [s].
        rate_hz: sampling rate [Hz].
        use: "train" or "test".
    """

    kind: Kind
    at: tuple[str, ...]
    ground: tuple[str, ...]
    level: float
    width_s: float
    band_hz: tuple[float, float]
    duration_s: float
    rate_hz: float
    use: Use

    @property
    def excitation(self) -> Hammer | RandomShaking:
        """What the laboratory does."""
        if self.kind == "hammer":
            return Hammer(width_s=self.width_s, peak_n=self.level)
        return RandomShaking(self.level, self.band_hz)


@dataclass(frozen=True)
class Plan:
    """A test plan.

    Attributes:
        recordings: in the order they are made, repetitions one by one.
        sensors: channels that are recorded beside the inputs; None for all accelerations.
        noise: by channel name or quantity ("acc", "force"); the name wins.
        tolerance: of the drawing's masses and stiffnesses, as a share; None for the engine's own.
        damping_tolerance: the same of the dampings.
        mechanisms: what is concealed; None for the whole vocabulary.
        places: where; None for every place there is.
        sizes: mechanism -> sizes to try in its own unit; a search without.
        values: mechanism -> parameter -> value that is not the strength: a gap, a corner.
    """

    recordings: tuple[PlannedTest, ...]
    sensors: tuple[str, ...] | None = None
    noise: Mapping[str, Noise] = field(default_factory=dict)
    tolerance: float | None = None
    damping_tolerance: float | None = None
    mechanisms: tuple[str, ...] | None = None
    places: tuple[str, ...] | None = None
    sizes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    values: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def read_plan(path: str | Path) -> Plan:
    """Read a plan from a TOML or JSON file.

    Examples:
        >>> import pathlib, tempfile
        >>> file = pathlib.Path(tempfile.mkdtemp()) / "plan.toml"
        >>> _ = file.write_text("recordings = 3")
        >>> read_plan(file)
        Traceback (most recent call last):
        twin.errors.TwinError: ...: recordings: expected a list of at least one table, not 3

    Raises:
        TwinError: no such file, or a key that is unknown, missing or out of its range; the message
            names the key.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "no text"
        raise TwinError(f"{file}: cannot read this plan ({reason})") from None
    try:
        table = json.loads(text) if file.suffix.lower() == ".json" else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise TwinError(f"{file}: neither TOML nor, as NAME.json, JSON ({error})") from None
    return plan_of(table, str(file))


def plan_of(table: object, source: str = "plan") -> Plan:
    """Return the plan of a table of keys, as a file has it.

    Args:
        table: key -> value, as TOML or JSON gives it.
        source: how messages begin.

    Raises:
        TwinError: as of ``read_plan``.
    """
    top = Fields(f"{source}: ", table, KEYS)
    tests: list[PlannedTest] = []
    for number, entry in enumerate(top.tables("recordings"), 1):
        made = Fields(f"{source}: recordings[{number}].", entry, OF_RECORDING)
        tests += [_test(made)] * made.count("repeat", 1)
    for use in ("train", "test"):
        if not any(test.use == use for test in tests):
            raise TwinError(f"{source}: recordings: none has use = '{use}'; a diagnosis needs one")
    conceal = Fields(f"{source}: conceal.", top.table_at("conceal"), OF_CONCEAL)
    optional = {
        key: top.positive(key) if key in top.table else None
        for key in ("tolerance", "damping_tolerance")
    }
    return Plan(
        recordings=tuple(tests),
        sensors=top.names("sensors") or None,
        noise=_noise(f"{source}: noise", top.table_at("noise")),
        mechanisms=_mechanisms(conceal, "mechanisms", conceal.names("mechanisms")),
        places=conceal.names("places") or None,
        sizes=_sizes(conceal, source),
        values=_values(conceal, source),
        **optional,
    )


def _test(entry: Fields) -> PlannedTest:
    kind = entry.one_of("kind", ("hammer", "shaker"))
    at, ground = entry.names("at"), entry.names("ground")
    if bool(at) == bool(ground):
        raise entry.wrong("at" if not ground else "ground", "either 'at' or 'ground', and not both")
    if kind == "hammer" and ground:
        raise entry.wrong("ground", "a shaker there")
    rate = entry.positive("rate_hz", None, "Hz")
    band = entry.numbers("band_hz", 2) if "band_hz" in entry.table else (0.02 * rate, 0.4 * rate)
    return PlannedTest(
        "hammer" if kind == "hammer" else "shaker",
        at,
        ground,
        entry.positive("level", None, "N"),
        entry.positive("width_s", Hammer().width_s, "s"),
        (band[0], band[1]),
        entry.positive("duration_s", None, "s"),
        rate,
        "train" if entry.one_of("use", ("train", "test")) == "train" else "test",
    )


def _noise(where: str, table: Mapping[str, Any]) -> dict[str, Noise]:
    """Return noise by channel or quantity: a number is a share, a table has share and std."""
    found = {}
    for name, value in table.items():
        entry = value if isinstance(value, Mapping) else {"share": value}
        fields = Fields(f"{where}.{name}.", entry, ("share", "std"))
        levels = {}
        for key in entry:
            # nothing is as good a noise as any
            levels[key] = 0.0 if entry[key] == 0 else fields.positive(key)
        found[name] = Noise(**levels)
    return found


def _mechanisms(entry: Fields, key: str, names: tuple[str, ...]) -> tuple[str, ...] | None:
    for name in names:
        if name not in vocabulary():
            known = available(vocabulary())
            raise TwinError(f"{entry.where}{key}: no mechanism '{name}'; there are {known}")
    return names or None


def _sizes(conceal: Fields, source: str) -> dict[str, tuple[float, ...]]:
    table = conceal.table_at("sizes")
    _mechanisms(conceal, "sizes", tuple(table))
    fields = Fields(f"{source}: conceal.sizes.", table)
    return {name: fields.numbers(name) for name in table}


def _values(conceal: Fields, source: str) -> dict[str, dict[str, float]]:
    table = conceal.table_at("values")
    _mechanisms(conceal, "values", tuple(table))
    found = {}
    for name, entry in table.items():
        known = tuple(vocabulary()[name].parameters)
        fields = Fields(f"{source}: conceal.values.{name}.", entry, known)
        found[name] = {key: fields.positive(key) for key in fields.table}
    return found
