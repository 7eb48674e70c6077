"""What ``twin control`` shows and writes: the table, the run as a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from twin.control.outcome import Outcome
from twin.control.plant import Plant, frame_frequencies
from twin.formats import write_recording
from twin.frame import Pendulum
from twin.identification.result import Identification
from twin.recording import Recording
from twin.view.tables import REDUCTIONS


def show(screen: Console, result: dict[str, Any]) -> None:
    """Print the figures of the contract, identified model beside true model."""
    true = result["with_true_model"]
    table = Table(title=f"control on for the second half, excited by {result['excitation']}")
    table.add_column("")
    for name in ("identified model", "true model"):
        table.add_column(name, justify="right")
    for window, floors in result["reduction"].items():
        for floor, share in floors.items():
            other = true["reduction"][window][floor]
            table.add_row(f"{REDUCTIONS[window]}, {floor}", f"{share:.1%}", f"{other:.1%}")
    rows = (
        (r"peak swing \[rad]", "peak_swing_rad", ".3f"),
        (r"peak torque \[N m]", "peak_torque_nm", ".3f"),
        ("stability margin", "stability_margin", ".3f"),
    )
    for label, key, form in rows:
        table.add_row(label, format(result[key], form), format(true[key], form))
    for key in ("median", "p99"):
        times = (r["controller_step_us"][key] for r in (result, true))
        table.add_row(rf"controller step, {key} \[us]", *(f"{t:.1f}" for t in times))
    screen.print(table)
    pendulum = result["pendulum"]
    screen.print(
        f"I_zz,3 = {pendulum['inertia_kg_m2']:.3g} kg m^2 read about the "
        f"{pendulum['inertia_about']}; the frame's own frequencies are "
        + ", ".join(f"{f:.3f}" for f in result["frequencies_hz"])
        + " Hz"
    )
    for note in result["notes"]:
        screen.print(f"[yellow]note:[/yellow] {note}")


def about(
    plant: Plant, pendulum: Pendulum, identification: Identification, outcome: Outcome
) -> dict[str, Any]:
    """Return what the figures are for, as plain types."""
    frame = identification.second_order
    assert frame is not None
    return {
        "excitation": plant.known_input,
        "frequencies_hz": list(frame_frequencies(plant.linear().structure)),
        "delay_samples": plant.delay,
        "windows_s": {
            "off": [0.0, outcome.switch_s],
            "on": [outcome.switch_s, len(outcome.torque) / outcome.rate_hz],
            "steady": "last half of each",
            "rms": "last half of each",
        },
        "pendulum": {
            "mass_kg": pendulum.mass,
            "centre_distance_m": pendulum.centre_distance,
            "inertia_kg_m2": pendulum.inertia,
            "inertia_about": pendulum.inertia_about,
        },
        "identified": {
            "route": identification.route,
            "coordinates": list(frame.coordinates),
            "M": frame.M.tolist(),
            "R": frame.R.tolist(),
            "K": frame.K.tolist(),
        },
    }


def write_run(outcome: Outcome, path: Path) -> Path:
    """Write what the controller read and gave, and the true displacements, as a recording."""
    every = round(outcome.physics_hz / outcome.rate_hz)
    columns = dict(zip(outcome.channels, outcome.measured.T, strict=True))
    columns["torque_pendulum"] = outcome.torque
    for floor, motion in zip(outcome.floors, outcome.displacement[::every].T, strict=True):
        columns[f"disp_{floor}"] = motion
    order = [outcome.known_input, *(name for name in columns if name != outcome.known_input)]
    recording = Recording.build(outcome.rate_hz, {name: columns[name] for name in order})
    return write_recording(recording, path)
