import numpy as np
import pytest

from twin.errors import RecordingError
from twin.formats import read_recording

CLEAN = (
    "time [s],force_floor1 [N],acc_floor1 [m/s^2]\n"
    "0,1,2\n"
    "0.5,3,-4e-3\n"
    "1,5,+6.25\n"
    "1.5,7,.5\n"
)  # fmt: skip
MAP = {"F": "force_floor1 [N]", "a": "acc_floor1 [g]"}


@pytest.fixture
def file(tmp_path):
    def make(content, name="r.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return make


def refusal(path, *arguments):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, *arguments)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert message.isprintable()
    return message.removeprefix(f"{path}: ")


def test_a_clean_file_is_read_to_the_last_digit(file):
    recording = read_recording(file(CLEAN))
    assert recording.sampling_hz == 2.0
    assert recording.names == ("force_floor1", "acc_floor1")
    assert np.array_equal(recording.data, [[1, 2], [3, -4e-3], [5, 6.25], [7, 0.5]])
    assert recording.source == "r.csv"
    assert recording.notes == ()


@pytest.mark.parametrize(
    "content",
    [
        CLEAN.replace("\n", "\r\n"),
        CLEAN.replace("\n", "\r"),
        "\ufeff" + CLEAN,
        CLEAN.replace(",", ";"),
        CLEAN.replace(",", "\t"),
        CLEAN.replace(",", " , "),
        CLEAN.replace("\n", ",\n"),
        CLEAN + "\n\n",
        CLEAN + ",,\n,,\n",
        CLEAN.rstrip("\n"),
        CLEAN.replace("1,5", '"1","5"'),
        '"time [s]","force_floor1 [N]","acc_floor1 [m/s^2]"' + CLEAN[CLEAN.index("\n") :],
    ],
)
def test_line_ends_separators_quotes_and_marks_do_not_change_the_numbers(file, content):
    assert np.array_equal(read_recording(file(content)).data, read_recording(file(CLEAN)).data)


def test_units_are_converted(file):
    text = "time [ms],force_floor1 [lbf],acc_floor1 [g],angle_pendulum [deg]\n0,1,1,90\n500,2,0,0\n"
    recording = read_recording(file(text))
    assert recording.sampling_hz == 2.0
    assert recording.data[0] == pytest.approx([4.4482216152605, 9.80665, np.pi / 2], rel=1e-14)


def test_a_western_windows_header_is_understood(file):
    text = "time [s],angle_pendulum [°]\n0,180\n1,0\n".encode("cp1252")
    assert read_recording(file(text)).data[0, 0] == pytest.approx(np.pi)


def test_a_foreign_file_is_read_through_a_map_and_a_rate(file):
    text = '"F","a","note","Fs",\n1,1,x,400,\n2,0,,,\n3,-1,y,,\n'
    recording = read_recording(file(text), MAP, 400)
    assert recording.sampling_hz == 400
    assert np.array_equal(recording.column("force_floor1"), [1, 2, 3])
    assert np.array_equal(recording.column("acc_floor1"), [9.80665, 0, -9.80665])
    assert recording.notes == ("left out, as the channel map does not name them: 'note', 'Fs'",)


def test_an_own_time_column_is_used_although_the_map_does_not_name_it(file):
    recording = read_recording(file("time [s],F\n10,1\n10.25,2\n"), {"F": "force_floor1 [N]"})
    assert (recording.sampling_hz, recording.start_s) == (4.0, 10.0)


def test_a_rate_beside_a_time_column_has_to_agree_with_it(file):
    assert read_recording(file(CLEAN), None, 2.00001).sampling_hz == 2.00001
    assert "the time in the file says 2 Hz, not 3 Hz" in refusal(file(CLEAN), None, 3)


@pytest.mark.parametrize("rate", [0, -1, float("nan"), float("inf")])
def test_a_rate_that_is_no_positive_number_is_refused(file, rate):
    assert "no positive number" in refusal(file(CLEAN), None, rate)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("5,+6.25", "nan,+6.25", "row 4, column 'force_floor1 [N]': nan is not finite"),
        ("5,+6.25", "5,-inf", "row 4, column 'acc_floor1 [m/s^2]': -inf is not finite"),
        ("5,+6.25", "5,1e999", "row 4, column 'acc_floor1 [m/s^2]': inf is not finite"),
        ("0.5,3", "nan,3", "row 3, column 'time [s]': nan is not finite"),
        ("5,+6.25", ",+6.25", "row 4, column 'force_floor1 [N]': the cell is empty"),
        ("5,+6.25", "5", "row 4 has 2 cells where the header has 3"),
        ("5,+6.25", "5,6,25", "row 4 has 4 cells where the header has 3"),
        ("5,+6.25", "five,6", "row 4, column 'force_floor1 [N]': 'five' is not a number"),
        ("5,+6.25", "1_0,6", "row 4, column 'force_floor1 [N]': '1_0' is not a number"),
        ("5,+6.25", "٥,6", "is not a number"),
        ("5,+6.25", '"5,6', "row 4 cannot be split into cells"),
        ("5,+6.25\n", "5,+6.25\n\n", "row 5 is empty"),
        ("5,+6.25", "5,6\x00", "row 4 holds byte 0x00"),
        ("5,+6.25\n1.5", "5,+6.25\n1.7", "row 5: time is not uniform"),
        ("0.5,3", "0,3", "row 3: time does not increase"),
        ("[N]", "[lightyear]", "column 'force_floor1 [lightyear]': the unit [lightyear] is not"),
        ("[N]", "[bananas]", "column 'force_floor1 [bananas]': unknown unit [bananas]"),
        (" [m/s^2]", "", "column 'acc_floor1' has no unit; write [m/s^2], [g], [mm/s^2]"),
        ("time [s]", "time", "column 'time' has no unit; write [s], [ms]"),
        ("force_floor1 [N]", "Force", "column 'Force' has no unit, so nothing says what it measu"),
        ("acc_floor1 [m/s^2]", "force_floor1 [N]", "'force_floor1' appears twice (columns 2 and 3"),
        ("force_floor1 [N]", "time [s]", "channel 'time' appears twice (columns 1 and 2)"),
        ("time [s]", "disp_floor1 [m]", "no column 'time [s]' among 'disp_floor1 [m]'"),
        (",acc_floor1 [m/s^2]", ",", "column 3 holds values but has no name"),
    ],
)
def test_damage_is_named_with_row_and_column(file, before, after, message):
    assert before in CLEAN
    assert message in refusal(file(CLEAN.replace(before, after, 1)))


def test_an_empty_row_of_a_single_column_is_not_skipped(file):
    message = refusal(file("F\n1\n\n2\n"), {"F": "force_floor1 [N]"}, 8)
    assert message == "row 3 is empty"


def test_decimal_commas_get_a_hint(file):
    text = CLEAN.replace(",", ";").replace(".", ",")
    assert "'0,5' is not a number; decimals are written with a point" in refusal(file(text))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "the file is empty"),
        ("\n", "row 1, where the header belongs, is empty"),
        (",,,\n1,2,3,\n", "column 3 holds values but has no name"),
        ("time [s],force_floor1 [N]\n", "a header but no samples"),
        ("time [s],force_floor1 [N]\n0,1\n", "1 sample in 'time [s]', 'force_floor1 [N]'"),
        ("time [s]\n0\n1\n", "no channel but the time"),
        ("0,1\n1,2\n", "row 1 holds numbers where a header"),
        (b"\x89PNG\r\n\x1a\n\0\0\0", "this is a PNG image, not a recording (.csv, .tsv"),
        (b"\x89HDF\r\n\x1a\n\0", "this is an HDF5 file; rename it to r.h5"),
        (bytes(range(256)), "not a text file"),
        (b"\xff\xfe\xfd,\x80\n1,2", "UTF-16 text that is damaged; save it as UTF-8"),
        ("{}", "a header but no samples"),
        ("<html>\n</html>\n", "column '<html>' has no unit, so nothing says"),
    ],
)
def test_a_file_that_is_no_recording_says_so(file, content, message):
    assert message in refusal(file(content))


def test_what_is_no_readable_file_says_so(tmp_path):
    assert refusal(tmp_path / "none.csv") == "there is no such file"
    for name in ("folder.csv", "folder"):
        (tmp_path / name).mkdir()
        assert refusal(tmp_path / name) == "this is a folder, not a recording"
    for name in ("r.docx", "r"):
        (tmp_path / name).write_text(CLEAN)
    assert refusal(tmp_path / "r.docx").startswith(".docx files cannot be read; .csv, .tsv")
    assert refusal(tmp_path / "r").startswith("files without a suffix cannot be read")
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    assert "cannot be read" in refusal(tmp_path / "loop.csv")


def test_a_device_is_not_read_for_ever(tmp_path):
    (tmp_path / "zero.csv").symlink_to("/dev/zero")
    assert refusal(tmp_path / "zero.csv") == "this is not a regular file"


def test_numbers_that_overflow_in_si_are_named(file):
    text = "time [s],force_floor1 [kN]\n0,1\n1,1e308\n"
    assert "row 3, column 'force_floor1 [kN]': inf is not finite" in refusal(file(text))
