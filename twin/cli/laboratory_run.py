"""Carries out virtual tests for the command line: progress, files, table and JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from twin.cli.common import check_folder, console, folder, watched, write_json
from twin.errors import TwinError
from twin.formats import write_recording
from twin.instruments import INSTRUMENT_OF, Instrument
from twin.laboratory import Experiment, run
from twin.mechanisms.mass import Mass
from twin.model import Twin
from twin.recording import Recording

if TYPE_CHECKING:
    from twin.view.live import Live

DEFAULT_FOLDER = Path("twin-out")


def instruments(
    ground: Sequence[str],
    noise: float,
    input_noise: float,
    range_: float | None,
    input_range: float | None,
    bits: int,
    bandwidth: float | None,
    piezo_corner: float | None,
) -> dict[str, Instrument]:
    """Return the instruments of a test by channel or kind, from the options.

    Args:
        ground: the channels of a shake table, which ``input_noise`` is then for.
        noise: of responses, fraction of their RMS.
        input_noise: of the input, fraction of its RMS.
        range_: of accelerometers [m/s^2], or None.
        input_range: of load cells [N], or None.
        bits: of every converter but the encoder's.
        bandwidth: of accelerometers [Hz], or None.
        piezo_corner: of accelerometers [Hz], or None.
    """
    accelerometer = Instrument(bandwidth, piezo_corner, range_, bits, noise)
    encoder = INSTRUMENT_OF["angle"]
    chosen = {
        "acc": accelerometer,
        "force": Instrument(full_scale=input_range, bits=bits, noise_fraction=input_noise),
        "torque": Instrument(full_scale=input_range, bits=bits, noise_fraction=input_noise),
        "disp": Instrument(bits=bits, noise_fraction=noise),
        "angle": Instrument(full_scale=encoder.full_scale, bits=encoder.bits, noise_fraction=noise),
    }
    table = Instrument(bandwidth, piezo_corner, range_, bits, input_noise)
    return {**chosen, **dict.fromkeys(ground, table)}


def loaded(twin: Twin, added_mass: Sequence[str] | None) -> Twin:
    """Return the twin with masses bolted on, from options such as "floor2=0.5" [kg].

    Raises:
        TwinError: an option that cannot be read.
        ModelError: no such floor.
    """
    masses = []
    for option in added_mass or ():
        place, _, value = option.partition("=")
        try:
            masses.append(Mass(place, float(value)))
        except ValueError:
            raise TwinError(f"--added-mass {option}: expected PLACE=KG, as in floor2=0.5") from None
    return twin.including(*masses) if masses else twin


@dataclass(frozen=True)
class LaboratoryRun:
    """An experiment to be done ``repeat`` times on one twin."""

    experiment: Experiment
    twin: Twin
    seed: int
    repeat: int

    @property
    def stem(self) -> str:
        """Start of the file names: "hammer_floor1", "random_ground", "earthquake"."""
        test = self.experiment
        if test.ground:
            return f"{test.excitation.kind}_ground_{'+'.join(test.ground)}"
        if test.excitation.moves_the_ground:
            return test.excitation.kind
        return f"{test.excitation.kind}_{'+'.join(test.places)}"

    def carry_out(self, out: Path | None, json_target: str | None, rerun: bool = False) -> None:
        """Run, write the recordings as CSV, print a table and, where asked for, JSON.

        Args:
            out: folder of the recordings.
            json_target: file of the JSON, "-" for standard output.
            rerun: whether a viewer shows each recording when it is made.
        """
        target = folder(check_folder(out or DEFAULT_FOLDER))
        with watched(rerun) as viewer:
            self._write(target, json_target, viewer)

    def _write(self, target: Path, json_target: str | None, viewer: Live | None) -> None:
        screen = console(json_target)
        recordings = self._recordings(viewer)
        paths = []
        for number, recording in enumerate(recordings, start=1):
            name = self.stem if self.repeat == 1 else f"{self.stem}_{number:02d}"
            path = target / f"{name}.csv"
            paths.append(write_recording(recording, path))
            self._show(screen, recording, path)
        write_json(self._result(recordings, paths), json_target)

    def _recordings(self, viewer: Live | None) -> list[Recording]:
        shown = Console(stderr=True)
        with Progress(console=shown, transient=True, disable=not shown.is_terminal) as progress:
            task = progress.add_task(self.stem, total=self.repeat)
            recordings = []
            for number in range(self.repeat):

                def report(share: float, done: int = number) -> None:
                    progress.update(task, completed=done + share)

                recordings.append(run(self.experiment, self.twin, self.seed, number, report))
                if viewer is not None:
                    viewer.show(recordings[-1])
        return recordings

    def _show(self, screen: Console, recording: Recording, path: Path) -> None:
        screen.print(
            f"{recording.source}: {recording.samples} samples at {recording.sampling_hz:g} Hz "
            f"({recording.duration_s:g} s)",
            soft_wrap=True,
        )
        table = Table("channel", "unit")
        for column in ("peak", "RMS"):
            table.add_column(column, justify="right")
        for row in channel_rows(recording):
            table.add_row(row["name"], row["unit"], f"{row['peak']:.4g}", f"{row['rms']:.4g}")
        screen.print(table)
        for note in recording.notes:
            screen.print(f"[yellow]note:[/yellow] {note}")
        screen.print(f"written to {path}\n", soft_wrap=True)

    def _result(self, recordings: list[Recording], paths: list[Path]) -> dict[str, Any]:
        return {
            "kind": self.experiment.excitation.kind,
            "input": recordings[0].inputs[0],
            "inputs": list(recordings[0].inputs),
            "model": self.twin.source,
            "sampling_hz": recordings[0].sampling_hz,
            "samples": recordings[0].samples,
            "seed": self.seed,
            "recordings": [
                {
                    "file": str(path),
                    "channels": channel_rows(recording),
                    "notes": list(recording.notes),
                }
                for recording, path in zip(recordings, paths, strict=True)
            ],
        }


def channel_rows(recording: Recording) -> list[dict[str, Any]]:
    """Return name, unit, peak (largest magnitude) and RMS of each channel."""
    return [
        {
            "name": channel.name,
            "unit": channel.unit,
            "peak": float(np.abs(recording.data[:, index]).max()),
            "rms": float(np.sqrt(np.mean(recording.data[:, index] ** 2))),
        }
        for index, channel in enumerate(recording.channels)
    ]
