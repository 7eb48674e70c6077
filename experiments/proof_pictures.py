"""Draw one concealed case, from the mismatch to the extended twin: docs/concealed_case.png.

    python experiments/proof_pictures.py [--mechanism clearance] [--place storey1] [--seed 7]

The case is made by the generator of ``twin concealed`` and diagnosed like every other; its truth is
opened last, for the title.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.case import case_name, generate  # noqa: E402
from experiments.concealed.tables import combination_of, combinations  # noqa: E402
from twin.diagnosis.pipeline import diagnose  # noqa: E402
from twin.diagnosis.predict import nrmse  # noqa: E402
from twin.diagnosis.result import Diagnosis, Trace  # noqa: E402
from twin.files import write_whole  # noqa: E402
from twin.formats import read_recording  # noqa: E402
from twin.model import Twin  # noqa: E402
from twin.view.colours import IDENTIFIED, LOCATED, MEASURED, REJECTED, TRUE  # noqa: E402
from twin.view.force_reach import force_reach  # noqa: E402

WINDOW_S = 1.5
SHOWN = 3000
SHOWN_PLACES = 6
DPI = 90


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mechanism", default="clearance")
    parser.add_argument("--place", default="storey1")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "concealed_case.png")
    given = parser.parse_args()
    wanted = ((given.mechanism, given.place),)
    if wanted not in combinations("single"):
        sys.exit(f"no {given.mechanism} at {given.place} in the table 'single'")
    number = 1
    while combination_of("single", number, given.seed) != wanted:
        number += 1
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        generate(number, given.seed, folder / "recordings", folder / "sealed")
        case = folder / "recordings" / case_name(number)
        train, test = (
            [read_recording(p) for p in sorted(case.glob(f"{role}_*.csv"))]
            for role in ("train", "test")
        )
        found = diagnose(Twin.load("two_storey_lumped"), train, test)
        truth = json.loads((folder / "sealed" / f"{case_name(number)}.json").read_text())
    figure = draw(found, truth)
    print(write_whole(given.out, lambda part: figure.savefig(part, dpi=DPI)))


def draw(found: Diagnosis, truth: dict[str, object]) -> Figure:
    """Return the four pictures of a diagnosis side by side, two by two."""
    figure = Figure(figsize=(11.5, 7.2), layout="constrained")
    (before, place), (law, after) = figure.subplots(2, 2)
    trace = next(t for t in found.traces if t.role == "test")
    _recording(before, trace, "calibrated", IDENTIFIED)
    before.set_title("1  an unseen recording: the best twin without the missing physics")
    _where(place, found)
    place.set_title("2  the best explanation at each place")
    _force(law, found)
    law.set_title("3  the force that is missing, and the law found for it")
    _recording(after, trace, "explained", TRUE)
    after.set_title("4  the same recording with the extended twin")
    first = found.findings[0]
    figure.suptitle(
        f"concealed: {truth['mechanism']} at {truth['location']};  found: "
        f"{first.mechanism.name} at {first.location}, probability {first.probability:.2f}",
        fontsize=13, parse_math=False,
    )  # fmt: skip
    return figure


def _recording(ax: Axes, trace: Trace, which: str, colour: str) -> None:
    column = int(np.argmax(np.nanstd(trace.calibrated - trace.measured, axis=0)))
    # where the calibrated twin is worst, in both pictures
    power = np.nansum((trace.calibrated - trace.measured) ** 2, axis=1)
    length = round(WINDOW_S * trace.sampling_hz)
    start = int(np.argmax(np.convolve(power, np.ones(length), "valid")))
    part = slice(start, start + length)
    time = np.arange(len(trace.measured))[part] / trace.sampling_hz
    ax.plot(time, trace.measured[part, column], color=MEASURED, lw=3.5, label="measured")
    signal = getattr(trace, which)
    error = nrmse([trace.measured], [signal])
    name = {"explained": "extended"}.get(which, which)
    label = f"{name} twin, free run: error {100 * error:.2g} %"
    ax.plot(time, signal[part, column], color=colour, lw=1.3, label=label)
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"{trace.outputs[column]} [m/s^2]", parse_math=False)
    ax.margins(x=0, y=0.28)
    ax.grid(alpha=0.3)
    ax.legend(loc="upper center", ncols=2, fontsize=9, framealpha=0.9)


def _where(ax: Axes, found: Diagnosis) -> None:
    best = {}
    for one in (*found.findings, *found.alternatives):
        if one.gain is not None and one.gain > best.get(one.location, ("", 0.0))[1]:
            best[one.location] = one.mechanism.name, one.gain
    rows = sorted(best.items(), key=lambda row: row[1][1])[-SHOWN_PLACES:]
    gains = [gain for _, (_, gain) in rows]
    located = {f.location for f in found.findings}
    colours = [LOCATED if place in located else REJECTED for place, _ in rows]
    names = [f"{what.replace('_', ' ')}\n{place}" for place, (what, _) in rows]
    bars = ax.barh(names, gains, 0.5, color=colours)
    ax.bar_label(bars, [f"{gain:,.0f}" for gain in gains], padding=4)
    ax.margins(x=0.25)
    ax.xaxis.set_major_formatter("{x:,.0f}")
    ax.xaxis.set_major_locator(MaxNLocator(5))
    ax.set_xlabel("log odds over nothing there [nat]")
    ax.grid(alpha=0.3, axis="x")


def _force(ax: Axes, found: Diagnosis) -> None:
    picture = next(p for p in found.force if p.place == found.findings[0].location)
    every = max(len(picture.drift) // SHOWN, 1)
    ax.plot(1e3 * picture.drift[::every], picture.latent[::every], ".", ms=3, color=MEASURED,
            alpha=0.5, label="estimated missing force")  # fmt: skip
    if picture.law is not None:
        grid = 1e3 * picture.law_drift
        ax.plot(grid, picture.law, color=LOCATED, lw=2, label="law found")
        if picture.law_std is not None:
            spread = 1.96 * picture.law_std
            ax.fill_between(grid, picture.law - spread, picture.law + spread, color=LOCATED,
                            alpha=0.3, lw=0, label="95 %")  # fmt: skip
    # the filter sees one side only where a recording begins
    if (reach := force_reach(picture)) is not None:
        ax.set_ylim(*reach)
    ax.set_xlabel(f"drift of {picture.place} [mm]")
    ax.set_ylabel("force [N]")
    ax.grid(alpha=0.3)
    ax.legend(fontsize=9)


if __name__ == "__main__":
    main()
