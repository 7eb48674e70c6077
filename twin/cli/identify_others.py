"""``twin identify`` of what has no measured input beside its output: responses, outputs alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from twin.cli.common import folder, write_json
from twin.errors import TwinError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.status import Status

    from twin.identification.from_responses import ResponseIdentification
    from twin.identification.output_only import OutputOnly
    from twin.identification.pole_diagram import Pick
    from twin.identification.segments import Progress
    from twin.provenance import Provenance
    from twin.recording import Recording


def telling(status: Status) -> Progress:
    """Return what an identification tells its progress to."""

    def progress(what: str, step: int, steps: int) -> None:
        status.update(f"{what}, {step} of {steps}")

    return progress


def choice(pick: bool, poles: str | None) -> Pick | None:
    """Return how poles are chosen: with the mouse, near given frequencies, or None for by itself.

    Raises:
        TwinError: both at once, or what are no frequencies.
    """
    if poles is None:
        if not pick:
            return None
        from twin.view.poles import pick_by_hand

        return pick_by_hand
    if pick:
        raise TwinError("--pick and --poles both choose poles: give one of them")
    from twin.identification.pole_diagram import poles_near

    try:
        frequencies = [float(part) for part in poles.split(",")]
    except ValueError:
        frequencies = []
    if not frequencies or not all(0 < f < float("inf") for f in frequencies):
        raise TwinError(
            f"--poles {poles}: frequencies in Hz, with commas between, such as 810.5,900"
        )
    return poles_near(frequencies)


def driven(recording: Recording) -> bool:
    """Whether a force or a shaken ground was measured, be it one that does not move."""
    return bool(recording.inputs) or any(c.kind in ("force", "torque") for c in recording.channels)


def from_responses(
    files: Sequence[Path],
    band: tuple[float, float] | None,
    window: float | None,
    pick: Pick | None,
    terminal: Console,
    target: Path,
    made: Provenance,
    json: str | None,
) -> None:
    """Identify modes from files of frequency responses."""
    from twin.formats.responses import read_responses
    from twin.identification.exponential_window import responses_without_window
    from twin.identification.from_responses import identify_responses
    from twin.view.report import print_responses

    with terminal.status("identifying") as status:
        result = identify_responses(read_responses(files), band, telling(status), pick)
    if window is not None:
        result = responses_without_window(result, window)
    print_responses(terminal, result)
    _write(result, result.responses.source, terminal, target, made, json)


def from_outputs(
    recordings: Sequence[Recording],
    outputs: Sequence[str] | None,
    band: tuple[float, float] | None,
    pick: Pick | None,
    terminal: Console,
    target: Path,
    made: Provenance,
    json: str | None,
) -> None:
    """Identify modes from responses to what nobody measured."""
    from twin.identification.output_only import identify_output_only
    from twin.view.report import print_modes

    with terminal.status("identifying") as status:
        result = identify_output_only(recordings, outputs, band, telling(status), pick)
    source = ", ".join(r.source for r in recordings)
    print_modes(terminal, result.modal, source, result.notes)
    _write(result, source, terminal, target, made, json)


def _write(
    result: ResponseIdentification | OutputOnly, source: str, terminal: Console, target: Path,
    made: Provenance, json: str | None,
) -> None:  # fmt: skip
    """Write the page of the modes, say where, and write the JSON."""
    from twin.view.page.identification import write_modes_page

    page = folder(target) / "identification.html"
    write_modes_page(page, result.modal, result.diagram, source, result.notes, made)
    terminal.print(f"written: {page}")
    write_json(result.as_json(), json)
