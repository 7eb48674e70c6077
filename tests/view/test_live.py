"""A viewer that shows a command's work while it is done, reached from this computer only."""

import select
import socket
import subprocess
import sys
import urllib.request
from contextlib import contextmanager

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from twin.cli import main
from twin.errors import TwinError
from twin.recording import Recording
from twin.view import live as module
from twin.view import viewer
from twin.view.live import Live, live

HIT = Recording.build(8.0, {"force_floor1": np.arange(9.0), "acc_floor1": np.ones(9)}, "hit.csv")


def entities(path):
    return {str(chunk.entity_path) for chunk in RrdReader(str(path)).stream().to_chunks()}


@contextmanager
def on_file(path):
    stream = rr.RecordingStream("test", recording_id="live", send_properties=False)
    stream.save(str(path))
    yield Live(stream)
    stream.flush()
    stream.disconnect()


def test_recordings_and_messages_are_streamed(tmp_path):
    with on_file(tmp_path / "live.rrd") as shown:
        shown.tell("calibrating")
        shown.show(HIT)
        shown.show(HIT)
    there = entities(tmp_path / "live.rrd")
    assert {"/progress", "/recording1/force_floor1", "/recording2/acc_floor1"} <= there


def test_a_test_is_streamed_while_it_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "live", lambda: on_file(tmp_path / "live.rrd"))
    with pytest.raises(SystemExit) as stop:
        main(["test", "hammer", "two_storey_lumped", "--repeat", "2", "--duration", "4", "--rerun"])
    assert stop.value.code == 0
    assert "/recording2/acc_floor2" in entities(tmp_path / "live.rrd")


def listening(port):
    """The addresses on which a port is listened to, as Linux lists them."""
    with open("/proc/net/tcp") as file:
        rows = [line.split() for line in file.readlines()[1:]]
    return {row[1].split(":")[0] for row in rows if row[1].endswith(f":{port:04X}")
            and row[3] == "0A"}  # fmt: skip


def test_a_page_is_served_to_this_computer_only(monkeypatch, capsys):
    monkeypatch.setattr(module, "window_can_open", lambda: False)
    ports = []
    monkeypatch.setattr(module, "free_port", lambda: ports.append(free()) or ports[-1])
    seen = {}

    def look(process):
        seen["page"] = urllib.request.urlopen(f"http://127.0.0.1:{ports[1]}", timeout=10).status
        seen["addresses"] = [listening(port) for port in ports]

    monkeypatch.setattr(module, "_served", look)
    with live() as shown:
        shown.show(HIT)
    assert seen == {"page": 200, "addresses": [{"0100007F"}, {"0100007F"}]}
    assert f"look at http://127.0.0.1:{ports[1]}" in capsys.readouterr().err
    with (
        pytest.raises(ConnectionRefusedError),
        socket.create_connection(("127.0.0.1", ports[1]), 2),
    ):
        pass


def test_what_a_viewer_started_ends_with_it_even_where_it_does_not_listen_to_it(monkeypatch):
    monkeypatch.setattr(viewer, "STOP_S", 0.5)
    deaf = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(flush=True)"
    parent = (
        "import subprocess, sys, time; "
        f"subprocess.Popen([sys.executable, '-c', {deaf + '; time.sleep(60)'!r}]); time.sleep(60)"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", parent], stdout=subprocess.PIPE, start_new_session=True
    )
    assert process.stdout is not None
    process.stdout.readline()
    viewer.ended(process)
    told, _, _ = select.select([process.stdout], [], [], 5.0)
    assert told, "somebody still holds it open"
    assert process.stdout.read() == b""
    process.stdout.close()


def free():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def test_a_viewer_that_does_not_start_is_one_line(monkeypatch):
    monkeypatch.setattr(module, "wait", _ended)
    monkeypatch.setattr(module, "started", lambda *given: None)
    monkeypatch.setattr(module, "ended", lambda process: None)
    with (
        pytest.raises(TwinError, match=r"--rerun: the Rerun viewer does not start \(it ended"),
        live(),
    ):
        pass


def _ended(*_):
    raise RuntimeError("it ended with code 1")
