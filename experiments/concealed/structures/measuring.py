"""From a structure's motion to its recording: sensors' faults, filter, sampler, noise, CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from twin.files import write_whole

from ..chain import Chain, delayed
from ..mechanisms import Mechanism
from ..plans import FINE_HZ, SAMPLING_HZ
from .structure import Array


def at_sensors(seen: Mapping[str, Array], effects: Sequence[Mechanism]) -> Array:
    """Return what the sensors give, faults included, (samples, channels)."""
    given = dict(seen)
    for m in effects:
        if m.name == "sensor_gain":
            given[m.location] = m["gain"] * given[m.location]
        elif m.name == "sensor_polarity":
            given[m.location] = -given[m.location]
        elif m.name == "sensor_delay":
            given[m.location] = delayed(given[m.location], m["delay"], FINE_HZ)
    return np.column_stack(list(given.values()))


def measured(
    chain: Chain, inputs: Mapping[str, Array], seen: Mapping[str, Array], units: Mapping[str, str],
    encoder: float, effects: Sequence[Mechanism], rng: np.random.Generator,
) -> dict[str, Array]:  # fmt: skip
    """Return the channels of a recording, "name [unit]" -> samples with noise.

    Args:
        chain: filter, sampler and noise.
        inputs: what drives, on the integrator's grid.
        seen: what ideal sensors see.
        units: of the sensors.
        encoder: noise of a displacement over that of the others, as shares of their RMS.
        effects: faults of sensors among them.
        rng: draws the noise.
    """
    both = np.column_stack([*inputs.values(), at_sensors(seen, effects)])
    sampled = chain.sampled(both)
    of_input = {name: "m/s^2" if name.startswith("acc_") else "N" for name in inputs}
    names = {**of_input, **{name: units[name] for name in seen}}
    found = {}
    for column, (name, unit) in zip(sampled.T, names.items(), strict=True):
        share = chain.noise * (encoder if unit == "m" else 1.0)
        deviation = share * np.sqrt(np.mean(column**2))
        found[f"{name} [{unit}]"] = column + deviation * rng.standard_normal(len(column))
    return found


def write_csv(path: Path, columns: Mapping[str, Array]) -> None:
    """Write a recording with ten digits."""
    table = np.column_stack(list(columns.values()))
    lines = [",".join(["time [s]", *columns])]
    for i, row in enumerate(table):
        lines.append(",".join([f"{i / SAMPLING_HZ:.9g}", *(f"{value:.10g}" for value in row)]))
    text = "\n".join(lines) + "\n"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, lambda part: part.write_text(text, encoding="utf-8"))


def read_csv(path: Path) -> dict[str, Array]:
    """Undo ``write_csv``; without the time."""
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    return dict(zip(names[1:], table.T[1:], strict=True))
