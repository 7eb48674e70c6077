"""A command's work in a viewer while it runs: recordings and messages as they come."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from twin.errors import TwinError
from twin.recording import Recording
from twin.view.colours import FORCE, MEASURED
from twin.view.signals import log_line
from twin.view.viewer import LOCAL, ended, free_port, started, wait, window_can_open

APPLICATION = "frame-twin-live"
WORK = "work"
"""Time line of the messages: how long the command has run [s]."""

GRPC = f"rerun+http://{LOCAL}:{{}}/proxy"


class Live:
    """What a command tells and shows, on a stream to a viewer.

    Attributes:
        stream: to a viewer, or to a file.
    """

    def __init__(self, stream: rr.RecordingStream) -> None:
        self.stream = stream
        self._begin = time.monotonic()
        self._roots: list[str] = []

    def tell(self, message: str) -> None:
        """Log a message at the time since the command began."""
        self.stream.set_time(WORK, duration=time.monotonic() - self._begin)
        self.stream.log("progress", rr.TextLog(message))
        self.stream.reset_time()

    def show(self, recording: Recording) -> None:
        """Draw every channel of a recording; the newest one stands in front."""
        root = f"recording{len(self._roots) + 1}"
        self._roots.append(root)
        for name in recording.names:
            colour = FORCE if name in recording.inputs else MEASURED
            part = rr.escape_entity_path_part(name)
            values = recording.column(name)
            log_line(self.stream, f"{root}/{part}", recording.time, values, name, colour)
        self.tell(f"{root}: {recording.source}, {recording.samples} samples")
        views = [
            rrb.Vertical(
                *(
                    rrb.TimeSeriesView(
                        origin=f"{one}/{rr.escape_entity_path_part(name)}", name=name
                    )
                    for name in recording.names
                ),
                name=one,
            )
            for one in self._roots
        ]
        front = rrb.Tabs(*views, active_tab=len(views) - 1)
        words = rrb.TextLogView(origin="progress", name="progress")
        self.stream.send_blueprint(rrb.Blueprint(rrb.Vertical(front, words, row_shares=[4, 1])))


@contextmanager
def live() -> Iterator[Live]:
    """Open a viewer, a window or a page in the browser, and yield what streams to it.

    A window stays open when the command is done; a page is served until Ctrl-C.

    Raises:
        TwinError: the viewer does not start.
    """
    window = window_can_open()
    port, page = free_port(), free_port()
    # the server of a page has no window, and takes what is streamed to its proxy
    arguments = ["--expect-data-soon"] if window else [
        "--serve-web", "--web-viewer-port", str(page)]  # fmt: skip
    with tempfile.TemporaryFile() as said:
        process = started(arguments, port, said)
        try:
            wait(process, port)
        except RuntimeError as error:
            ended(process)
            raise TwinError(f"--rerun: the Rerun viewer does not start ({error})") from None
    address = f"http://{LOCAL}:{page}?url={GRPC.format(port)}".replace("+", "%2B")
    if not window:
        sys.stderr.write(f"twin: no window can open here; look at {address}\n")
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.connect_grpc(GRPC.format(port))
    try:
        yield Live(stream)
        stream.flush()
        if not window:
            _served(process)
    finally:
        stream.disconnect()
        if not window:
            ended(process)


def _served(process: subprocess.Popen[Any]) -> None:
    """Leave the page open until Ctrl-C."""
    sys.stderr.write("twin: done; Ctrl-C ends the viewer's page\n")
    try:
        process.wait()
    except KeyboardInterrupt:
        return
