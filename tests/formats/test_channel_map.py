import pytest

from twin.errors import RecordingError
from twin.formats import parse_channel_map, read_recording

TEXT = "F [lbf],a,a,b = c [mm],time\n1,2,3,4,0\n5,6,7,8,1\n"


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "f.csv"
    path.write_text(TEXT)
    return path


def read(path, *options, rate=2.0):
    return read_recording(path, parse_channel_map(options), rate)


def test_a_map_names_columns_by_their_name_with_or_without_unit(path):
    for name in ("F", "F [lbf]"):
        recording = read(path, f"{name}=force_floor1")
        assert recording.column("force_floor1")[0] == pytest.approx(4.4482216152605)


def test_the_last_equals_sign_divides(path):
    assert read(path, "b = c=disp_floor2").column("disp_floor2")[0] == pytest.approx(4e-3)


def test_a_unit_in_the_map_overrides_the_files_and_says_so(path):
    recording = read(path, "F=force_floor1 [N]")
    assert recording.column("force_floor1")[0] == 1.0
    assert recording.notes[0] == "column 'F [lbf]' is read in [N], as the channel map says"


def test_what_the_map_does_not_name_is_left_out_and_said(path):
    assert read(path, "F=force_floor1").notes == (
        "left out, as the channel map does not name them: 'a', 'a', 'b = c [mm]', 'time'",
    )


def test_a_column_may_become_the_time(path):
    recording = read(path, "F=force_floor1", "time=time [ms]", rate=None)
    assert recording.sampling_hz == 1000.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["G=force_floor1 [N]"], r"no column 'G'.*the file has 'F \[lbf\]', 'a', 'a', 'b = c"),
        (["a=acc_floor1 [g]"], r"column 'a' appears 2 times \(columns 2, 3\)"),
        (["F=force_floor1", "b = c=force_floor1 [N]"], "channel 'force_floor1' appears twice"),
        (["F=force_floor1 [s]"], r"the unit \[s\] is not one of force"),
        (["a=storey1"], "column 'a' appears 2 times"),
        (["b = c=A3 [bananas]"], r"unknown unit \[bananas\]"),
        (["F=tip", "b = c=tip.x [N]"], "channel 'tip' appears twice"),
        (["force_floor1 [N]"], "not of the form"),
        (["=force_floor1 [N]"], "not of the form"),
        (["F="], "not of the form"),
        ([""], "not of the form"),
        (["F=force_floor1", "F=force_floor2"], "names the column 'F' twice"),
        (["time=time"], r"column 'time' has no unit; write \[s\], \[ms\]"),
    ],
)
def test_a_wrong_map_is_told_what_is_wrong(path, options, message):
    with pytest.raises(RecordingError, match=message):
        read(path, *options)


def test_a_column_may_become_any_channel(path):
    recording = read(path, "F=tip_force", "b = c=column3.y [m/s^2]")
    assert [c.title for c in recording.channels] == ["tip_force [N]", "column3.y [m/s^2]"]
    assert recording.column("tip_force")[0] == pytest.approx(4.4482216152605)
    assert recording.inputs == ("tip_force",)


def test_a_long_list_of_columns_is_cut(tmp_path):
    path = tmp_path / "f.csv"
    path.write_text(",".join(f"c{i}" for i in range(100)) + "\n" + ",".join("1" * 100) + "\n")
    with pytest.raises(RecordingError, match=r"'c11' and 88 more$"):
        read(path, "d=force_floor1 [N]")
