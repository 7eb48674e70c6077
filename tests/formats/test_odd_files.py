"""Files as measuring programs and spreadsheets write them: read, or one line on what to do."""

import datetime
import gzip
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from twin.errors import RecordingError, TwinError
from twin.formats import read_recording

OPEN_FILES = Path("/proc/self/fd")

TIME = np.arange(6) / 8
FORCE = np.array([0.0, 1.5, -2.25, 3.0, 0.125, -1.0])
ACC = np.array([4.0, -5.5, 6.25, 7.5, 0.0, 1e-3])
HEADER = ["time [s]", "tip_force [N]", "A3 [m/s^2]"]
CLEAN = "time [s],tip_force [N],A3 [m/s^2]\n" + "".join(
    f"{t!r},{f!r},{a!r}\n" for t, f, a in np.column_stack([TIME, FORCE, ACC]).tolist()
)
GERMAN = CLEAN.replace(",", ";").replace(".", ",")
BODY = CLEAN.split("\n", 1)[1]
STAMPS = [f"2026-05-01T23:59:59.{n}" for n in ("5", "625", "75", "875")] + [
    "2026-05-02T00:00:00.000",
    "2026-05-02T00:00:00.125",
]


def stamped(stamps, header="timestamp"):
    rows = zip(stamps, BODY.splitlines(), strict=True)
    return f"{header},tip_force [N],A3 [m/s^2]\n" + "".join(
        f"{stamp},{row.split(',', 1)[1]}\n" for stamp, row in rows
    )


READ = {
    "semicolons and decimal commas": GERMAN,
    "tabs and decimal commas": GERMAN.replace(";", "\t"),
    "Excel's declared separator": "sep=;\n" + GERMAN,
    "UTF-16 with a mark": CLEAN.encode("utf-16"),
    "UTF-16 without a mark": CLEAN.encode("utf-16-le"),
    "UTF-16, big end first": CLEAN.encode("utf-16-be"),
    "UTF-32": CLEAN.encode("utf-32"),
    "Windows, German": GERMAN.replace("\n", "\r\n").encode("cp1252"),
    "units in parentheses": CLEAN.replace("[", "(").replace("]", ")"),
    "units in a row of their own": "Time,tip_force,A3\ns,N,m/s^2\n" + BODY,
    "units in brackets in a row of their own": "Time,tip_force,A3\n[s],[N],[m/s^2]\n" + BODY,
    "lines about the measurement": "DAQ 3000;v1.2\nOperator: me\nRate,8\n\n" + CLEAN,
    "lines about it and a row of units": "Recorder X\n\nTime,tip_force,A3\ns,N,m/s^2\n" + BODY,
    "a commented header": "# a test\n# time [s],tip_force [N],A3 [m/s^2]\n" + BODY,
    "a header that is a comment": "#" + CLEAN,
    "upright bars": CLEAN.replace(",", "|"),
    "Fortran's exponents": CLEAN.replace("0.001", "1.0D-03"),
    "spaces": CLEAN.replace(",", "   "),
    "quotes": "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in CLEAN.split("\n")[:-1]
    ),
    "another case of time": CLEAN.replace("time", "Time"),
    "another name of time": CLEAN.replace("time", "t"),
    "milliseconds": "time [ms]" + CLEAN[8:].replace(BODY, "".join(
        f"{1000 * float(row.split(',')[0])!r},{row.split(',', 1)[1]}\n" for row in BODY.splitlines()
    )),
    "dates": stamped(STAMPS),
    "dates with zone": stamped([f"{stamp}Z" for stamp in STAMPS]),
    "dates with a space": stamped([stamp.replace("T", " ") for stamp in STAMPS]),
    "times of day over midnight": stamped([stamp[11:] for stamp in STAMPS], "Time"),
    "a unit row that is partly empty": "Time,tip_force,A3\ns,N,m/s^2\n" + BODY,
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_what_others_write_is_read_to_the_last_digit(tmp_path, name):
    path = tmp_path / "r.csv"
    content = READ[name]
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    recording = read_recording(path)
    assert recording.sampling_hz == 8.0
    assert [c.title for c in recording.channels] == HEADER[1:]
    assert np.array_equal(recording.data, np.column_stack([FORCE, ACC]))


@pytest.mark.parametrize("suffix", [".csv.gz", ".txt.gz"])
def test_a_packed_text_is_read(tmp_path, suffix):
    path = tmp_path / f"r{suffix}"
    path.write_bytes(gzip.compress(CLEAN.encode()))
    assert np.array_equal(read_recording(path).column("A3"), ACC)
    path.write_bytes(gzip.compress(CLEAN.encode())[:-20])
    with pytest.raises(RecordingError, match="the archive is damaged or cut short"):
        read_recording(path)


def test_a_text_that_is_not_packed_is_to_be_renamed(tmp_path):
    path = tmp_path / "r.csv.gz"
    path.write_text(CLEAN)
    with pytest.raises(RecordingError, match=r"not packed; rename it to r\.csv$"):
        read_recording(path)


def sheet(path, rows, empty_first=False):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    if empty_first:
        book.create_sheet()
    target = book.worksheets[-1]
    for row in rows:
        target.append(row)
    book.save(path)
    return path


@pytest.mark.parametrize("empty_first", [False, True])
def test_an_excel_sheet_is_read(tmp_path, empty_first):
    rows = [HEADER, *np.column_stack([TIME, FORCE, ACC]).tolist()]
    recording = read_recording(sheet(tmp_path / "r.xlsx", rows, empty_first))
    assert recording.sampling_hz == 8.0
    assert np.array_equal(recording.data, np.column_stack([FORCE, ACC]))


def test_an_excel_sheet_with_dates_a_title_and_a_row_of_units_is_read(tmp_path):
    start = datetime.datetime(2026, 5, 1, 23, 59, 59)
    stamps = [start + datetime.timedelta(milliseconds=125 * k) for k in range(6)]
    rows = [["Messung 4"], ["when", "tip_force", "A3"], ["s", "N", "m/s^2"]]
    rows += [list(row) for row in zip(stamps, FORCE.tolist(), ACC.tolist(), strict=True)]
    recording = read_recording(sheet(tmp_path / "r.xlsx", rows))
    assert recording.sampling_hz == 8.0
    assert [c.title for c in recording.channels] == HEADER[1:]


@pytest.mark.skipif(not OPEN_FILES.is_dir(), reason="this system does not list open files")
def test_a_damaged_sheet_is_not_left_open(tmp_path):
    """openpyxl leaves a sheet with damaged styles open; it could not be deleted on Windows."""
    path = sheet(tmp_path / "r.xlsx", [HEADER, [0, 1, 2], [1, 2, 3]])
    with zipfile.ZipFile(path) as whole:
        parts = {name: whole.read(name) for name in whole.namelist()}
    with zipfile.ZipFile(path, "w") as harmed:
        for name, content in parts.items():
            harmed.writestr(name, content[:200] if name == "xl/styles.xml" else content)
    with pytest.raises(RecordingError, match=r"r\.xlsx: damaged, or no Excel file"):
        read_recording(path)
    assert path.resolve() not in [entry.resolve() for entry in OPEN_FILES.iterdir()]


def test_a_missing_reader_of_sheets_is_said(tmp_path, monkeypatch):
    path = sheet(tmp_path / "r.xlsx", [HEADER, [0, 1, 2], [1, 2, 3]])
    monkeypatch.setitem(__import__("sys").modules, "openpyxl", None)
    with pytest.raises(TwinError, match=r"need openpyxl; pip install 'frame-twin\[formats\]'"):
        read_recording(path)


def zipped(*names):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in names:
            archive.writestr(name, "x")
    return buffer.getvalue()


REFUSED = {
    "milliseconds without a unit": (
        CLEAN.replace("time [s]", "time"), "'time' has no unit; write [s], [ms]"),
    "an unnamed quantity": (
        CLEAN.replace("A3 [m/s^2]", "A3"), "--map 'A3=A3 [m/s^2]'"),
    "a unit nobody knows": (CLEAN.replace("[N]", "[LSB]"), "unknown unit [LSB]; units are writ"),
    "thousands and decimals": (
        "time [s];F [N]\n0;1.000,5\n1;2.000,5\n", "'1.000,5' is not a number; write it without se"),
    "an empty cell": ("time [s],F [N]\n0,1\n1,\n2,1\n", "the cell is empty; cut the file there"),
    "no number": ("time [s],F [N]\n0,1\n1,nan\n2,1\n", "nan is not finite; cut the file there"),
    "decimal commas between commas": (
        "time [s],F [N]\n0,0,1,0\n1,0,2,0\n", "decimal commas need semicolons"),
    "a gap": (
        "time [s],F [N]\n0,1\n1,2\n2,1\n6,2\n7,1\n", "row 5: time is not uniform: a step of 4 s "
        "where steps are 1 s (off by 300 %): 3 samples are missing; cut the file there"),
    "time that goes back": ("time [s],F [N]\n0,1\n1,2\n1,2\n0,1\n", "row 5: time does not incr"),
    "no time": ("F [N],a [g]\n1,2\n2,3\n", "give the sampling rate (--rate HZ)"),
    "no header": (BODY, "row 1 holds numbers where a header such as"),
    "a bad time of day": (stamped([*STAMPS[:-1], "25:00:00"]), "row 7, column 'timestamp [s]': "
                          "'25:00:00' is not a time such as 12:30:01.25"),
    "UTF-16 cut in a letter": (CLEAN.encode("utf-16")[:-5], "UTF-16 text that is damaged"),
    "a name twice": (CLEAN.replace("A3 [m/s^2]", "tip_force [N]"), "'tip_force' appears twice"),
    "an axis twice": (
        CLEAN.replace("A3 [m/s^2]", "tip_force.x [N]"), "'tip_force' appears twice"),
    "a sheet under another name": (zipped("xl/workbook.xml"), "an Excel sheet; rename it"),
    "arrays under another name": (zipped("a.npy"), "these are NumPy arrays; rename it to r.npz"),
    "another archive": (zipped("readme.md"), "a zip archive, not a recording"),
    "an old sheet": (b"\xd0\xcf\x11\xe0" + bytes(600), "an old Office document; save the sheet as"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_says_in_one_line_what_to_do(tmp_path, name):
    content, message = REFUSED[name]
    path = tmp_path / "r.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(RecordingError) as caught:
        read_recording(path)
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


def test_an_archive_of_anything_but_text_is_to_be_unpacked(tmp_path):
    (tmp_path / "r.mat.gz").write_bytes(gzip.compress(b"MATLAB"))
    with pytest.raises(RecordingError, match=r"only text is read from a \.gz archive; unpack"):
        read_recording(tmp_path / "r.mat.gz")


def test_letters_that_number_sensors_are_no_units(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text("time (s),sensor (A) [g],sensor (B) [g]\n0,1,2\n1,2,3\n")
    assert read_recording(path).names == ("sensor (A)", "sensor (B)")


def test_a_rate_beats_a_time_column_without_a_unit(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text(CLEAN.replace("time [s]", "time"))
    assert read_recording(path, None, 400.0).sampling_hz == 400.0
