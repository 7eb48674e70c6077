"""Ways in which a file comes to harm, for hypothesis."""

import string

from hypothesis import strategies as st

BAD_CELLS = [
    "",
    " ",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e999",
    "-1e308",
    "1e-400",
    "0,5",
    "1.234,5",
    "--",
    "1e",
    "0x1F",
    "1_000",
    "#N/A",
    "#REF!",
    "12:30:01",
    "2024-05-01",
    "1 2",
    "٣",
    "½",
    "∞",
    '"',
    '"1',
    "'",
    "1;2",
    "=A1",
    "true",
    "null",
    "1j",
    "+-1",
    ".",
]
BAD_NAMES = [
    "",
    "time",
    "time [s]",
    "Time [s]",
    "time [m]",
    "force_floor1",
    "force_floor1 [N]",
    "force_floor1 [kg]",
    "acc_floor1 [g]",
    "acc_floor1 []",
    "acc_floor1 [m/s^2",
    "[N]",
    "[]",
    "acc_floor0 [m/s^2]",
    "acc_storey1 [g]",
    "acc_floor1 [m/s^^2]",
    "acc_floor1 [((]",
    "angle_floor1 [rad]",
    "acc_floor1 [[g]]",
    '"acc_floor1 [g]',
    "acc_floor1 [g] [N]",
    "force_floor99999999999999999999 [N]",
    "force_floor1 [1e400 N]",
    "acc_floor1 [g**9**9]",
]
CELLS = st.one_of(
    st.sampled_from([*BAD_CELLS, "1" * 400, "9" * 5000]),
    st.floats().map(repr),
    st.text(max_size=8),
)
NAMES = st.one_of(
    st.sampled_from(BAD_NAMES),
    st.text(max_size=12),
    *(
        st.text(alphabet=string.printable, max_size=12).map(f"{name} [{{}}]".format)
        for name in ("acc_floor1", "force_floor1", "time")
    ),
)
HARM = [
    "cell",
    "cell",
    "cell",
    "name",
    "name",
    "name",
    "drop cell",
    "add cell",
    "swap cells",
    "swap rows",
    "drop row",
    "repeat row",
    "blank",
    "cut",
    "column",
    "header twice",
    "preamble",
    "units row",
    "clock",
    "print",
]
ENCODINGS = ["utf-8-sig", "utf-16", "utf-16-le", "utf-32", "cp1252", "cp037", "shift_jis"]


@st.composite
def damaged_bytes(draw, whole):
    """Flip, cut, repeat or insert bytes, one to four times."""
    data = bytearray(whole)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(len(data) - 1, 0)))
        length = draw(st.integers(0, 64))
        kind = draw(st.sampled_from(["flip", "flip", "cut", "truncate", "repeat", "insert"]))
        if kind == "flip":
            data[at : at + 1] = draw(st.binary(min_size=1, max_size=1))
        elif kind == "cut":
            del data[at : at + length]
        elif kind == "truncate":
            del data[at:]
        elif kind == "repeat":
            data[at:at] = data[at : at + length]
        else:
            data[at:at] = draw(st.binary(max_size=16))
    return bytes(data)


@st.composite
def damaged_text(draw, rows):
    """Harm a table of cells in the ways of spreadsheets, loggers and hands."""
    rows = [list(row) for row in rows]
    for _ in range(draw(st.integers(1, 3))):
        _harm(draw, rows)
    separator = draw(st.sampled_from([",", ",", ",", ";", "\t", " ", ", "]))
    text = draw(st.sampled_from(["\n", "\n", "\r\n", "\r"])).join(
        separator.join(row) for row in rows
    )
    if draw(st.integers(0, 5)) == 0:
        text = text.replace(".", ",")
    encoding = draw(st.sampled_from(["utf-8"] * 40 + ENCODINGS))
    return text.encode(encoding, errors="replace")


def _harm(draw, rows):
    """Do one thing to the rows, in place."""
    here = draw(st.integers(0, len(rows) - 1))
    there = draw(st.integers(0, len(rows) - 1))
    row = rows[here]
    cell = draw(st.integers(0, max(len(row) - 1, 0)))
    kind = draw(st.sampled_from(HARM))
    if kind == "cell" and row:
        row[cell] = draw(CELLS)
    elif kind == "name" and rows[0]:
        rows[0][cell % len(rows[0])] = draw(NAMES)
    elif kind == "drop cell" and row:
        del row[cell]
    elif kind == "add cell":
        row.insert(cell, draw(CELLS))
    elif kind == "swap cells" and row:
        row[0], row[cell] = row[cell], row[0]
    elif kind == "swap rows":
        rows[here], rows[there] = rows[there], rows[here]
    elif kind == "drop row" and len(rows) > 1:
        del rows[here]
    elif kind == "repeat row":
        rows.insert(there, list(row))
    elif kind == "blank":
        rows.insert(here, [])
    elif kind == "cut":
        del rows[max(here, 1) :]
    elif kind == "column":
        value = draw(CELLS)
        for other in rows[1:]:
            if len(other) > cell:
                other[cell] = value
    elif kind == "preamble":
        rows[0:0] = (draw(st.sampled_from([["DAQ 3"], ["sep=;"], ["a", "b"], ["# rate", "32"]])),)
    elif kind == "units row":
        rows.insert(1, draw(st.sampled_from([["s", "N", "g", "g"], ["s", "N"], ["ms", "?"]])))
    elif kind == "clock":
        for number, other in enumerate(rows[1:]):
            if other:
                other[0] = f"12:30:{number:02d}"
    elif kind == "print":
        digits = draw(st.integers(1, 7))
        for other in rows[1:]:
            if other and other[0].replace(".", "").isdigit():
                other[0] = f"{float(other[0]):.{digits}g}"
    elif kind == "header twice":
        rows.insert(here, list(rows[0]))
