"""Counterparts of the paper's Figs. 8 to 10, with its (60) beside ours and the window of each.

python experiments/control_figures.py out/control
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from rich.console import Console
from rich.table import Table

from twin.control.bare import pendulum_of
from twin.control.closed_loop import run
from twin.control.plant import Plant
from twin.control.study import (
    Settings,
    hammer_tests,
    identified_model,
    identify_frame,
    judged,
    worst_case,
)
from twin.model import Twin
from twin.view import figures
from twin.view.control_report import write_control

PRINTED = {"floor1": 0.7693, "floor2": 0.6578}
BLOCKS = {
    "wave generator": (0.0, 0.0),
    "amplifier": (1.6, 0.0),
    "shaker": (3.2, 0.0),
    "load cell": (4.8, 0.0),
    "ground of the frame": (6.4, 0.0),
    "two floors": (6.4, 1.2),
    "pendulum, motor, encoder": (6.4, 2.4),
    "digital controller": (3.2, 2.4),
    "drive": (4.8, 3.2),
}
ARROWS = (
    ("wave generator", "amplifier", ""),
    ("amplifier", "shaker", ""),
    ("shaker", "load cell", "stinger"),
    ("load cell", "ground of the frame", ""),
    ("ground of the frame", "two floors", ""),
    ("two floors", "pendulum, motor, encoder", ""),
    ("load cell", "digital controller", "force"),
    ("two floors", "digital controller", "accelerations"),
    ("pendulum, motor, encoder", "digital controller", "angle"),
    ("digital controller", "drive", "torque"),
    ("drive", "pendulum, motor, encoder", ""),
)


def scheme() -> Figure:
    """The control scheme (Fig. 8)."""
    figure = Figure(figsize=(10, 5), layout="constrained")
    ax = figure.subplots()
    drawn = {}
    for name, (x, y) in BLOCKS.items():
        drawn[name] = ax.text(
            x, y, name.replace(", ", ",\n"), ha="center", va="center", fontsize=9,
            bbox={"boxstyle": "round,pad=0.5", "fc": "#eef3f8", "ec": "#56B4E9"},
        )  # fmt: skip
    figure.canvas.draw()
    for start, end, label in ARROWS:
        _arrow(ax, drawn[start], drawn[end], label)
    ax.set_xlim(-0.8, 7.4)
    ax.set_ylim(-0.5, 3.7)
    ax.axis("off")
    return figure


def _arrow(ax: Axes, start: Text, end: Text, label: str) -> None:
    tail, tip = start.get_position(), end.get_position()
    ax.annotate(
        "", tip, tail,
        arrowprops={
            "arrowstyle": "->", "color": "#6B7480", "shrinkA": 3, "shrinkB": 3,
            "patchA": start.get_bbox_patch(), "patchB": end.get_bbox_patch(),
        },
    )  # fmt: skip
    if label:
        middle = ((tail[0] + tip[0]) / 2, (tail[1] + tip[1]) / 2 + 0.05)
        ax.text(
            *middle, label, fontsize=8, ha="center", va="bottom", color="#4a525c",
            bbox={"fc": "white", "ec": "none", "pad": 0.5},
        )  # fmt: skip


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/control")
    plant = Plant(Twin.load("two_storey_absorber"))
    settings = Settings()
    found = identify_frame(hammer_tests(plant))
    believed = identified_model(found, pendulum_of(plant.twin), plant.known_input)
    controller = settings.design(believed, plant.delay)
    outcome = run(plant, controller, worst_case(plant))
    files = [figures.save(scheme(), folder / "scheme.png")]
    result = judged(outcome, controller, believed, plant.delay)
    about = {"excitation": plant.known_input, "delay_samples": plant.delay}
    result = {**result, **about, "with_true_model": result}
    files += write_control(folder, outcome, plant, controller, believed, result)
    table = Table("reduction", "floor1", "floor2", title="eq. (60)")
    table.add_row("printed, window not stated", *(f"{100 * PRINTED[f]:.2f} %" for f in PRINTED))
    for window, meaning in (
        ("whole", "ours, peaks over 0-32 s and 32-64 s"),
        ("steady", "ours, peaks over 16-32 s and 48-64 s"),
        ("rms", "ours, RMS over 16-32 s and 48-64 s"),
    ):
        shares = getattr(outcome.reduction, window)
        table.add_row(meaning, *(f"{100 * shares[f]:.2f} %" for f in outcome.floors))
    console = Console()
    console.print(table)
    console.print(f"written: {', '.join(str(f) for f in files)}")


if __name__ == "__main__":
    main()
