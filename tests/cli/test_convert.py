import io
import json
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
import pytest

from twin.cli import main
from twin.formats import read_recording, write_recording
from twin.recording import Recording

RATE = 64.0
TIME = np.arange(640) / RATE


@pytest.fixture
def recording(tmp_path):
    columns = {"force_floor1": np.sin(2 * np.pi * 3 * TIME), "acc_floor1": np.cos(11 * TIME)}
    return write_recording(Recording.build(RATE, columns), tmp_path / "in.csv")


def run(*arguments):
    """Run ``twin convert``; return exit code, standard output and standard error."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as stopped:
        main(["convert", *map(str, arguments)])
    return stopped.value.code, out.getvalue(), err.getvalue()


@pytest.mark.parametrize("suffix", [".mat", ".h5", ".uff", ".npz", ".csv"])
def test_a_recording_is_converted_to_any_format_and_back(recording, tmp_path, suffix):
    there, back = tmp_path / f"out{suffix}", tmp_path / "back.csv"
    code, out, err = run(recording, there)
    assert (code, err) == (0, "")
    assert out == f"{there}: 640 samples at 64 Hz (10 s) of force_floor1, acc_floor1\n"
    assert run(there, back)[0] == 0
    assert back.read_text() == recording.read_text()


def test_a_foreign_file_is_mapped_resampled_and_trimmed(tmp_path):
    foreign = tmp_path / "f.csv"
    lines = [f"{x:.9f},{i},\n" for i, x in enumerate(np.cos(2 * np.pi * 3 * TIME))]
    foreign.write_text('"a","junk",\n' + "".join(lines))
    target = tmp_path / "out.h5"
    options = ["--rate", 64, "--map", "a=acc_floor1 [g]", "--resample", 256]
    code, _, err = run(foreign, target, *options, "--start", 2, "--stop", 3.5)
    assert code == 0
    assert err == "twin: left out, as the channel map does not name them: 'junk'\n"
    result = read_recording(target)
    assert (result.sampling_hz, result.start_s, result.samples) == (256, 2.0, 384)
    expected = 9.80665 * np.cos(2 * np.pi * 3 * result.time)
    assert np.abs(result.column("acc_floor1") - expected).max() < 1e-3


def test_json_on_standard_output_says_what_was_written(recording, tmp_path):
    code, out, err = run(recording, tmp_path / "out.mat", "--json", "-")
    assert code == 0
    assert json.loads(out) == {
        "input": str(recording),
        "output": str(tmp_path / "out.mat"),
        "sampling_hz": 64.0,
        "samples": 640,
        "start_s": 0.0,
        "duration_s": 10.0,
        "channels": [
            {"name": "force_floor1", "unit": "N"},
            {"name": "acc_floor1", "unit": "m/s^2"},
        ],
        "notes": [],
    }
    assert err.endswith("of force_floor1, acc_floor1\n")


def test_json_goes_to_a_file(recording, tmp_path):
    assert run(recording, tmp_path / "out.mat", "--json", tmp_path / "r.json")[0] == 0
    assert json.loads((tmp_path / "r.json").read_text())["samples"] == 640


def test_a_clipped_channel_is_warned_of(tmp_path):
    clipped = np.clip(np.sin(2 * np.pi * 2.3 * TIME), -0.6, 0.8)
    source = write_recording(Recording.build(RATE, {"acc_floor1": clipped}), tmp_path / "in.csv")
    code, _, err = run(source, tmp_path / "out.csv")
    assert code == 0
    assert err.startswith("twin: warning: channel 'acc_floor1' looks clipped: ")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--rate", "0"], "in.csv: the sampling rate 0.0 Hz is no positive number"),
        (["--rate", "nan"], "in.csv: the sampling rate nan Hz is no positive number"),
        (["--rate", "100"], "in.csv: the time in the file says 64 Hz, not 100 Hz"),
        (["--rate", "fast"], "'--rate'"),
        (["--resample", "-1"], "in.csv: cannot resample to -1.0 Hz"),
        (["--resample", "1e15"], "would give"),
        (["--start", "10"], "in.csv: fewer than two samples between 10 s and inf s"),
        (["--stop", "nan"], "in.csv: fewer than two samples"),
        (["--map", "nothing"], "--map 'nothing' is not of the form"),
        (["--map", "x=acc_floor1 [g]"], "in.csv: no column 'x', which the channel map names"),
        (["--mop", "x"], "No such option"),
    ],
)
def test_bad_options_are_one_line_and_leave_nothing(recording, tmp_path, options, message):
    code, out, err = run(recording, tmp_path / "out.csv", *options)
    assert (code, out) == (2, "")
    assert err.startswith("twin: ")
    assert message in err
    assert len(err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == [recording]


@pytest.mark.parametrize("target", ["out.tdms", "out.xlsx", "out", "in.csv/out.csv"])
def test_a_target_that_cannot_be_written_is_one_line_and_leaves_nothing(
    recording, tmp_path, target
):
    code, out, err = run(recording, tmp_path / target)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == [recording]


def test_a_missing_argument_is_one_line():
    code, _, err = run("in.csv")
    assert code == 2
    assert len(err.splitlines()) == 1


def test_a_file_that_must_not_be_read_is_one_line(recording, tmp_path, monkeypatch):
    def forbid(path, *arguments, **options):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "open", forbid)
    code, _, err = run(recording, tmp_path / "out.csv")
    assert (code, err) == (2, f"twin: {recording}: cannot be read (Permission denied)\n")


def test_the_recording_may_be_converted_onto_itself(recording):
    before = read_recording(recording)
    assert run(recording, recording)[0] == 0
    assert np.array_equal(read_recording(recording).data, before.data)


def test_the_help_shows_an_example():
    code, out, _ = run("--help")
    assert code == 0
    assert "Example: twin convert" in " ".join(out.split())
