"""A picture by a viewer without a window: for this computer only, its failures in a line."""

import socket
import subprocess
import sys
import time

import pytest
import rerun as rr

from twin.errors import TwinError
from twin.view import screenshot as module
from twin.view import viewer
from twin.view.screenshot import complaint, one_view, screenshot

GLYPH = """thread 'main' panicked at 'No glyph for "一" (U+4E00) in Proportional. Install a font.'
epaint-0.37.0/src/text/fonts.rs:806
stack backtrace:
   6: core::panicking::panic_fmt
"""
ADAPTER = "thread 'main' panicked at 'No graphics adapter was found'\nstack backtrace:\n"


def recording(path, name="curve"):
    stream = rr.RecordingStream("test", recording_id="one", send_properties=False)
    stream.save(str(path))
    stream.log(name, rr.Points2D([[0.0, 0.0], [1.0, 1.0]]), static=True)
    stream.flush()
    return path


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        (GLYPH, "its font lacks the letter '一' of a name in this recording"),
        (ADAPTER, f"No graphics adapter was found; {module.DRIVER}"),
        ("", f"transport error; {module.DRIVER}"),
    ],
)
def test_the_viewers_last_words_are_one_line(said, reason):
    assert complaint(said, "transport\nerror") == reason


def fake(monkeypatch, code):
    """Let a Python program stand for the viewer; return what it was started with."""
    started = []
    real = subprocess.Popen

    def start(command, **options):
        started.append(command)
        return real([sys.executable, "-c", code, *command[3:]], **options)

    monkeypatch.setattr(viewer.subprocess, "Popen", start)
    return started


def test_a_viewer_that_ends_is_said_and_leaves_nothing(tmp_path, monkeypatch):
    started = fake(monkeypatch, f"import sys; sys.stderr.write({ADAPTER!r}); sys.exit(101)")
    with pytest.raises(
        TwinError, match="takes no picture: No graphics adapter was found"
    ) as caught:
        screenshot(recording(tmp_path / "r.rrd"), tmp_path / "r.png")
    assert str(caught.value).isprintable()
    assert not (tmp_path / "r.png").exists()
    (command,) = started
    assert command[command.index("--bind") + 1] == "127.0.0.1"


def test_a_viewer_is_ended_with_its_children(monkeypatch):
    code = (
        "import socket, subprocess, sys; port = int(sys.argv[-1]);"
        "inner = f'import socket, time; s = socket.create_server((\"127.0.0.1\", {port}));'"
        "'time.sleep(60)'; subprocess.run([sys.executable, '-c', inner])"
    )
    fake(monkeypatch, code)
    with open("/dev/null", "w+b") as nowhere, module._viewer(nowhere) as (process, port):
        viewer.wait(process, port)
    deadline = time.monotonic() + 5
    while time.monotonic() < deadline and listens(port):
        time.sleep(0.05)
    assert not listens(port)


def listens(port):
    with socket.socket() as one:
        return one.connect_ex(("127.0.0.1", port)) == 0


def test_a_picture_is_taken_where_a_driver_is(tmp_path):
    try:
        picture = screenshot(recording(tmp_path / "r.rrd"), tmp_path / "r.png")
    except TwinError as error:
        pytest.skip(str(error))
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_where_no_window_can_open_it_is_said_what_to_do(tmp_path, monkeypatch):
    from twin.cli.view import view as command

    monkeypatch.setattr(viewer, "window_can_open", lambda: False)
    with pytest.raises(TwinError, match="give --web, or --screenshot PNG"):
        command(recording(tmp_path / "r.rrd"))


def test_one_view_is_put_in_front_of_the_others():
    layout = {
        "/viewport": {"ViewportBlueprint": {"root_container": "r"}},
        "/container/r": {"ContainerBlueprint": {"container_kind": "Horizontal", "contents": []}},
        "/container/inner": {"ContainerBlueprint": {"container_kind": "Vertical"}},
    }
    names = [("acc [m/s²]", "/view/a"), ("acc [m/s²]", "/view/b"), ("stabilisation", "/view/s")]
    made = one_view(layout, names, "Stab")
    assert "Clear" in made["/container/inner"]  # a view has one parent
    tabs = made["/container/r"]["ContainerBlueprint"]
    assert tabs["container_kind"] == "Tabs"
    assert tabs["contents"] == ["/view/a", "/view/b", "/view/s"]
    assert tabs["active_tab"] == "/view/s"
    with pytest.raises(TwinError, match=r"no view 'nothing'; there are acc \[m"):
        one_view(layout, names, "nothing")
