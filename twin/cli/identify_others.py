"""``twin identify`` of what has no measured input beside its output: responses, outputs alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from twin.cli.common import write_json

if TYPE_CHECKING:
    from rich.console import Console
    from rich.status import Status

    from twin.identification.segments import Progress
    from twin.recording import Recording


def telling(status: Status) -> Progress:
    """Return what an identification tells its progress to."""

    def progress(what: str, step: int, steps: int) -> None:
        status.update(f"{what}, {step} of {steps}")

    return progress


def driven(recording: Recording) -> bool:
    """Whether a force or a shaken ground was measured, be it one that does not move."""
    return bool(recording.inputs) or any(c.kind in ("force", "torque") for c in recording.channels)


def from_responses(
    files: Sequence[Path],
    band: tuple[float, float] | None,
    window: float | None,
    terminal: Console,
    json: str | None,
) -> None:
    """Identify modes from files of frequency responses."""
    from twin.formats.responses import read_responses
    from twin.identification.exponential_window import responses_without_window
    from twin.identification.from_responses import identify_responses
    from twin.view.report import print_responses

    with terminal.status("identifying") as status:
        result = identify_responses(read_responses(files), band, telling(status))
    if window is not None:
        result = responses_without_window(result, window)
    print_responses(terminal, result)
    write_json(result.as_json(), json)


def from_outputs(
    recordings: Sequence[Recording],
    outputs: Sequence[str] | None,
    band: tuple[float, float] | None,
    terminal: Console,
    json: str | None,
) -> None:
    """Identify modes from responses to what nobody measured."""
    from twin.identification.output_only import identify_output_only
    from twin.view.report import print_modes

    with terminal.status("identifying") as status:
        result = identify_output_only(recordings, outputs, band, telling(status))
    source = ", ".join(r.source for r in recordings)
    print_modes(terminal, result.modal, source, result.notes)
    write_json(result.as_json(), json)
