"""Whatever happens to a file, the user gets finite numbers or one line that names the file."""

import gzip
import io
import json
from contextlib import redirect_stderr, redirect_stdout
from itertools import pairwise

import numpy as np
import pytest
from damage import damaged_bytes, damaged_text
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from twin.cli import main
from twin.errors import TwinError
from twin.formats import WRITTEN, parse_channel_map, read_recording, write_recording
from twin.recording import Recording

FOREIGN = (".tdms", ".xlsx", ".csv.gz", ".mcap")
RATE = 32.0
SAMPLES = 12
COLUMNS = {
    "force_floor1": np.sin(np.arange(SAMPLES)),
    "acc_floor1": np.cos(0.7 * np.arange(SAMPLES)) * 3,
    "acc_floor2": np.linspace(-1, 1, SAMPLES) ** 3,
}
WHOLE = Recording.build(RATE, COLUMNS)
MAPS = ["--map", "force_floor1=force_floor2", "--map", "acc_floor2=acc_floor1"]
OPTIONS = st.sampled_from(
    [[], [], [], ["--rate", "32"], ["--map", "acc_floor1=acc_floor3 [g]"], ["--rate", "32", *MAPS]]
)
quickly = settings(
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("damaged")


def rows():
    table = np.column_stack([WHOLE.time, WHOLE.data])
    header = ["time [s]", "force_floor1 [N]", "acc_floor1 [m/s^2]", "acc_floor2 [m/s^2]"]
    return [header, *([f"{x:.9g}" for x in row] for row in table)]


def whole_bytes(folder, suffix):
    """The bytes of a whole recording in a format."""
    path = folder / f"whole{suffix}"
    if suffix == ".tdms":
        nptdms = pytest.importorskip("nptdms")
        properties = {"wf_increment": 1 / RATE, "unit_string": "N"}
        with nptdms.TdmsWriter(path) as writer:
            writer.write_segment(
                [nptdms.ChannelObject("g", "force_floor1", COLUMNS["force_floor1"], properties)]
            )
    elif suffix == ".xlsx":
        book = pytest.importorskip("openpyxl").Workbook()
        for row in rows():
            book.active.append(row)
        book.save(path)
    elif suffix == ".mcap":
        with path.open("wb") as file:
            out = pytest.importorskip("mcap.writer").Writer(file)
            out.start()
            channel = out.register_channel("/A3", "json", 0, {"unit": "g"})
            for k, value in enumerate(COLUMNS["acc_floor1"].tolist()):
                out.add_message(channel, k * 10**8, json.dumps({"v": value}).encode(), k * 10**8)
            out.finish()
    elif suffix == ".csv.gz":
        path.write_bytes(gzip.compress("\n".join(map(",".join, rows())).encode()))
    else:
        write_recording(WHOLE, path)
    return path.read_bytes()


def assert_one_line_or_finite_numbers(path, options):
    maps = [value for key, value in pairwise(options) if key == "--map"]
    try:
        recording = read_recording(
            path, parse_channel_map(maps), RATE if "--rate" in options else None
        )
    except TwinError as error:
        message = str(error)
        assert message.startswith(f"{path}: "), message
        assert message.isprintable(), message
        assert len(message) < 600, message
        return False
    assert np.all(np.isfinite(recording.data))
    assert recording.samples >= 2
    return True


def assert_command_agrees(path, options, readable):
    """Convert by command line: exit code 2, one line and no file where reading fails."""
    target = path.parent / "converted.csv"
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as stopped:
        main(["convert", str(path), str(target), *options])
    if readable:
        assert stopped.value.code == 0, err.getvalue()
        assert read_recording(target).samples >= 2
        target.unlink()
    else:
        assert stopped.value.code == 2
        assert len(err.getvalue().splitlines()) == 1
        assert err.getvalue().startswith(f"twin: {path}: ")
        assert out.getvalue() == ""
    assert {left.name for left in path.parent.iterdir()} <= {
        path.name,
        path.name.replace("harmed", "whole"),
    }


@settings(quickly, max_examples=300)
@given(data=damaged_text(rows()), options=OPTIONS)
def test_a_harmed_table_gives_finite_numbers_or_one_line(folder, data, options):
    path = folder / "harmed.csv"
    path.write_bytes(data)
    readable = assert_one_line_or_finite_numbers(path, options)
    assert_command_agrees(path, options, readable)
    path.unlink()


@pytest.mark.parametrize("suffix", [*sorted(set(WRITTEN) - {".unv", ".hdf5"}), *FOREIGN])
def test_damaged_bytes_give_finite_numbers_or_one_line(tmp_path, suffix):
    whole = whole_bytes(tmp_path, suffix)
    path = tmp_path / f"harmed{suffix}"

    @settings(quickly, max_examples=100)
    @given(data=damaged_bytes(whole), options=OPTIONS)
    def check(data, options):
        path.write_bytes(data)
        readable = assert_one_line_or_finite_numbers(path, options)
        assert_command_agrees(path, options, readable)
        path.unlink()

    check()


@settings(quickly, max_examples=100)
@given(data=st.binary(max_size=300), suffix=st.sampled_from([*WRITTEN, *FOREIGN, ".npy", ".txt"]))
def test_noise_under_any_suffix_is_one_line(folder, data, suffix):
    path = folder / f"noise{suffix}"
    path.write_bytes(data)
    assert not assert_one_line_or_finite_numbers(path, [])
    path.unlink()
