"""Counterparts of the paper's Figs. 4-7 from the virtual laboratory.

Run: python experiments/paper_figures.py [FOLDER]
Hits floor 1 of the lumped frame (Fig. 3), records 32 s at 32 Hz with 1 % sensor noise, passes the
recording through OKID and ERA and draws: Fig. 4 the force, Figs. 5 and 6 the accelerations of
floors 1 and 2, Fig. 7 the singular values of the Hankel matrix N(0). One PNG a figure.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from twin.identification.era import HankelFactors, era
from twin.identification.okid import okid
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, Hammer, run
from twin.model import Twin
from twin.recording import Recording
from twin.view.colours import FORCE, IDENTIFIED, MEASURED, REJECTED

OBSERVER_LENGTH = 80
MARKOV_PARAMETERS = 400
ORDER = 4
SHOWN = 40
OUTPUTS = ("acc_floor1", "acc_floor2")
PULSE_WINDOW_S = 1.0


def hammer_test(seed: int = 0) -> Recording:
    """Return the paper's test on the lumped frame: 32 Hz, 32 s, cut-off 16 Hz."""
    experiment = Experiment(
        Hammer(),
        "floor1",
        Analyser(32.0, 32.0, 16.0),
        instruments={"acc": Instrument(noise_fraction=0.01)},
    )
    return run(experiment, Twin.load("two_storey_lumped"), seed)


def hankel_factors(recording: Recording) -> HankelFactors:
    """Return the singular value decomposition (33) of N(0), by (24)-(33)."""
    record = (recording.matrix(("force_floor1",)), recording.matrix(OUTPUTS))
    return era(okid([record], OBSERVER_LENGTH).markov(MARKOV_PARAMETERS))


def time_figure(
    recording: Recording, channel: str, title: str, label: str, colour: str
) -> plt.Figure:
    figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
    axes.plot(recording.time, recording.column(channel), color=colour, linewidth=0.9)
    axes.set(title=title, xlabel="Time (s)", ylabel=label, xlim=(0, recording.duration_s))
    axes.grid(alpha=0.3)
    return figure


def force_figure(recording: Recording) -> plt.Figure:
    figure = time_figure(
        recording, "force_floor1", "Counterpart of Fig. 4: force on floor 1", "Force (N)", FORCE
    )
    inset = figure.axes[0].inset_axes((0.45, 0.32, 0.5, 0.6))
    inset.plot(recording.time, recording.column("force_floor1"), ".-", color=FORCE, markersize=4)
    inset.set(xlim=(0, PULSE_WINDOW_S), title="first second: 8 ms blow, seen at 32 Hz")
    inset.title.set_fontsize(9)
    inset.grid(alpha=0.3)
    return figure


def singular_figure(singular_values: np.ndarray) -> plt.Figure:
    figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
    number = np.arange(1, SHOWN + 1)
    for part, colour, name in (
        (slice(0, ORDER), IDENTIFIED, f"the {ORDER} that are kept"),
        (slice(ORDER, SHOWN), REJECTED, "the rest"),
    ):
        axes.stem(
            number[part],
            singular_values[:SHOWN][part],
            linefmt=colour,
            markerfmt="o",
            basefmt=" ",
            label=name,
        )
    axes.set(
        title="Counterpart of Fig. 7: singular values of the Hankel matrix N(0)",
        xlabel="Number",
        ylabel="Singular value",
        xlim=(0, SHOWN + 1),
        ylim=(0, None),
    )
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


def main(target: Path) -> None:
    recording = hammer_test()
    singular_values = hankel_factors(recording).singular_values
    figures = {
        "paper_fig4_force": force_figure(recording),
        "paper_fig5_acceleration_floor1": time_figure(
            recording,
            "acc_floor1",
            "Counterpart of Fig. 5: acceleration of floor 1",
            "Acceleration (m/s²)",
            MEASURED,
        ),
        "paper_fig6_acceleration_floor2": time_figure(
            recording,
            "acc_floor2",
            "Counterpart of Fig. 6: acceleration of floor 2",
            "Acceleration (m/s²)",
            MEASURED,
        ),
        "paper_fig7_singular_values": singular_figure(singular_values),
    }
    target.mkdir(parents=True, exist_ok=True)
    for name, figure in figures.items():
        figure.savefig(target / f"{name}.png", dpi=150)
        plt.close(figure)
        print(target / f"{name}.png")
    ratio = singular_values[ORDER - 1] / singular_values[ORDER]
    print("singular values:", " ".join(f"{value:.4g}" for value in singular_values[:8]))
    print(f"the {ORDER}th is {ratio:.1f} times the next")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "twin-out"))
