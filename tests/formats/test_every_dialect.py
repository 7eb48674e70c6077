"""Dialects of tables as instruments, spreadsheets and people write them: all combinations.

Each file holds the same three columns. It is read to the last digit, whatever separates, encodes,
packs or surrounds it; or it cannot be read, and one line says what to do.
"""

import gzip
import io
from itertools import product

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from twin.errors import TwinError
from twin.formats import read_recording

TIME = np.arange(9) / 8
FORCE = np.array([0.0, 1.5, -2.25, 3.0, 0.125, -1.0, 1e-3, 12345.5, -0.5])
ACC = np.array([4.0, -5.5, 6.25, 7.5, 0.0, 1e-3, 2.0, -3.0, 9.75])

SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t"}
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252")
LINES = {"unix": "\n", "windows": "\r\n", "old mac": "\r"}
HEADERS = {
    "ours": ([], ["time [s]", "tip_force [N]", "A3 [m/s^2]"], []),
    "parentheses": ([], ["Time (s)", "tip_force (N)", "A3 (m/s²)"], []),
    "units below": ([], ["Time", "tip_force", "A3"], ["s", "N", "m/s^2"]),
    "units below in brackets": ([], ["Time", "tip_force", "A3"], ["[s]", "[N]", "[m/s^2]"]),
    "DAQ": (
        ["Recorder 3000 v1.2", "Operator: Müller", "Date: 2026-05-01", ""],
        ["time [s]", "tip_force [N]", "A3 [m/s^2]"], []),
    "DAQ with units below": (
        ["# Messung 4", "# Abtastrate 8 Hz"], ["Time", "tip_force", "A3"], ["s", "N", "m/s²"]),
}  # fmt: skip


def table(separator=",", comma=False, header="ours", time=None, ending="\n"):
    """A table as text: its preamble, header, perhaps units, and one row a sample."""
    before, names, units = HEADERS[header]
    cells = [[f"{t!r}" for t in TIME.tolist()] if time is None else list(time)]
    cells += [[repr(v) for v in column.tolist()] for column in (FORCE, ACC)]
    if comma:
        cells = [[cell.replace(".", ",") for cell in column] for column in cells]
    rows = [names, *([units] if units else []), *zip(*cells, strict=True)]
    return ending.join([*before, *(separator.join(row) for row in rows), ""])


def assert_read(path):
    recording = read_recording(path)
    assert recording.sampling_hz == 8.0
    assert [c.unit for c in recording.channels] == ["N", "m/s^2"]
    assert np.array_equal(recording.data, np.column_stack([FORCE, ACC]))


COMMAS = [(s, c) for s, c in product(SEPARATORS, (False, True)) if not (s == "comma" and c)]


@pytest.mark.parametrize("ending", LINES)
@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize(("separator", "comma"), COMMAS)
def test_separators_decimals_encodings_and_line_ends(tmp_path, separator, comma, encoding, ending):
    text = table(SEPARATORS[separator], comma, "ours", None, LINES[ending])
    path = tmp_path / "r.csv"
    path.write_bytes(text.encode(encoding))
    assert_read(path)


@pytest.mark.parametrize("header", HEADERS)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "utf-16"])
@pytest.mark.parametrize(("separator", "comma"), COMMAS)
@pytest.mark.parametrize("suffix", [".csv", ".txt.gz"])
def test_headers_of_instruments(tmp_path, separator, comma, encoding, header, suffix):
    data = table(SEPARATORS[separator], comma, header).encode(encoding)
    path = tmp_path / f"r{suffix}"
    path.write_bytes(gzip.compress(data) if suffix.endswith("gz") else data)
    assert_read(path)


SECONDS = [59.0 + t for t in TIME.tolist()]
TIMES = {
    "milliseconds": ("time [ms]", [f"{1000 * t:g}" for t in TIME]),
    "microseconds": ("time [us]", [f"{1e6 * t:.0f}" for t in TIME]),
    "minutes": ("time [min]", [repr(t / 60) for t in TIME.tolist()]),
    "seconds of an epoch": ("time [s]", [f"{1790000000 + t:.3f}" for t in TIME]),
    "printed short": ("time [s]", [f"{t:.2f}" for t in np.arange(9) / 8]),
    "ISO": ("time", [f"2026-05-01T12:00:{10 + t:06.3f}" for t in TIME]),
    "ISO, UTC": ("time", [f"2026-05-01T12:00:{10 + t:06.3f}Z" for t in TIME]),
    "ISO, a zone": ("time", [f"2026-05-01T12:00:{10 + t:06.3f}+02:00" for t in TIME]),
    "a space for T": ("timestamp", [f"2026-05-01 12:00:{10 + t:06.3f}" for t in TIME]),
    "over a minute": (
        "time", [f"12:{5 + int(s // 60):02d}:{s % 60:06.3f}" for s in SECONDS]),
    "time of day": ("Time", [f"23:59:{10 + t:06.3f}" for t in TIME]),
    "not from zero": ("time [s]", [repr(t + 3.5) for t in TIME.tolist()]),
    "before zero": ("time [s]", [repr(t - 1.0) for t in TIME.tolist()]),
    "with exponents": ("time [s]", [f"{t:.6e}" for t in TIME]),
}  # fmt: skip


@pytest.mark.parametrize("name", TIMES)
@pytest.mark.parametrize("separator", SEPARATORS)
def test_times(tmp_path, name, separator):
    title, time = TIMES[name]
    path = tmp_path / "r.csv"
    text = table(SEPARATORS[separator], False, "ours", time)
    path.write_text(text.replace("time [s]", title, 1), encoding="utf-8")
    assert_read(path)


CLEAN = table()
ROWS = CLEAN.splitlines()
UNREADABLE = {
    "milliseconds without a unit": (CLEAN.replace("time [s]", "ms"), "has no unit"),
    "no unit of a force": (CLEAN.replace(" [N]", ""), "has no unit"),
    "a wrong unit": (CLEAN.replace("[N]", "[kgf/x]"), "unknown unit"),
    "a unit of another quantity": (CLEAN.replace("tip_force [N]", "force_floor1 [m]"), "[m]"),
    "a missing row": ("\n".join([*ROWS[:4], *ROWS[5:]]), "row 5: time is not uniform"),
    "two missing rows": ("\n".join([*ROWS[:4], *ROWS[6:]]), "2 samples are missing"),
    "a doubled row": ("\n".join([*ROWS[:4], ROWS[3], *ROWS[4:]]), "row 5: time does not incr"),
    "rows backwards": ("\n".join([ROWS[0], *ROWS[:0:-1]]), "row 3: time does not increase"),
    "an empty cell": (CLEAN.replace("1.5,-5.5", ",-5.5"), "row 3, column 'tip_force [N]'"),
    "a word": (CLEAN.replace("-2.25", "overload"), "row 4, column 'tip_force [N]': 'overload'"),
    "a spreadsheet's error": (CLEAN.replace("-2.25", "#DIV/0!"), "row 4"),
    "infinity": (CLEAN.replace("-2.25", "inf"), "row 4, column 'tip_force [N]': inf"),
    "not a number": (CLEAN.replace("-2.25", "NaN"), "row 4, column 'tip_force [N]': nan"),
    "a number of Arabic digits": (CLEAN.replace("-2.25", "٣"), "row 4"),
    "a formula": (CLEAN.replace("-2.25", "=A1"), "row 4"),
    "a row too long": (CLEAN.replace("-2.25,", "-2.25,7,"), "row 4"),
    "a row too short": (CLEAN.replace("-2.25,6.25", "-2.25"), "row 4"),
    "a row cut off": (CLEAN[:-8], "row 10"),
    "a column twice": (CLEAN.replace("A3 [m/s^2]", "tip_force [N]"), "appears twice"),
    "no header": ("\n".join(ROWS[1:]), "where a header such as"),
    "a header alone": (ROWS[0] + "\n", "a header but no samples"),
    "one sample": ("\n".join(ROWS[:2]), "1 sample"),
    "nothing": ("", "the file is empty"),
    "blank lines": ("\n\n\n", "empty"),
    "prose": ("It was a dark and stormy night.\nThe rain fell.\n", "r.csv"),
    "HTML": ("<html><body>404 Not Found</body></html>\n", "r.csv"),
    "JSON": ('{"time": [0, 1], "force": [1, 2]}\n', "r.csv"),
    "a zero byte": (CLEAN.replace("-2.25", "\0"), "byte 0x00"),
    "thousands": (
        CLEAN.replace(",", ";").replace("12345.5", "12.345,5"), "'12.345,5' is not a number"),
    "half of a row of units": (
        table(header="units below").replace("s,N,m/s^2", ",N,"), "has no unit"),
    "times of day out of order": (
        table(time=["12:00:02", "12:00:01", *[f"12:00:{k:02d}" for k in range(3, 10)]]).replace(
            "time [s]", "time"), "row 3"),
    "a date that is none": (
        table(time=[f"2026-13-01T00:00:{k:02d}" for k in range(9)]).replace("time [s]", "time"),
        "2026-13-01"),
    "a time only": ("time [s]\n0\n1\n2\n", "no channel but the time"),
    "two times": (CLEAN.replace("A3 [m/s^2]", "time [s]"), "appears twice"),
}  # fmt: skip


@pytest.mark.parametrize("name", UNREADABLE)
def test_what_is_wrong_is_said_in_one_line_with_its_place(tmp_path, name):
    text, message = UNREADABLE[name]
    path = tmp_path / "r.csv"
    path.write_bytes(text.encode("utf-8"))
    with pytest.raises(TwinError) as caught:
        read_recording(path)
    said = str(caught.value)
    assert message in said
    assert said.isprintable()
    assert said.startswith(str(path))


dialects = st.fixed_dictionaries(
    {
        "pair": st.sampled_from(COMMAS),
        "header": st.sampled_from(sorted(HEADERS)),
        "encoding": st.sampled_from(ENCODINGS),
        "ending": st.sampled_from(sorted(LINES)),
        "packed": st.booleans(),
        "trailing": st.booleans(),
        "blank": st.integers(0, 3),
        "quoted": st.booleans(),
    }
)


@settings(
    max_examples=150, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(dialect=dialects)
def test_any_dialect_is_read_to_the_last_digit(tmp_path, dialect):
    separator, comma = dialect["pair"]
    mark = SEPARATORS[separator]
    lines = table(mark, comma, dialect["header"]).splitlines()
    first = next(i for i, line in enumerate(lines) if line.count(mark) == 2)
    body = lines[first:]
    if dialect["quoted"]:
        body = [mark.join(f'"{cell}"' for cell in line.split(mark)) for line in body]
    if dialect["trailing"]:
        body = [line + mark for line in body]
    text = LINES[dialect["ending"]].join([*lines[:first], *body, *[""] * (1 + dialect["blank"])])
    data = io.BytesIO(text.encode(dialect["encoding"])).getvalue()
    path = tmp_path / ("r.csv.gz" if dialect["packed"] else "r.csv")
    path.write_bytes(gzip.compress(data) if dialect["packed"] else data)
    assert_read(path)
