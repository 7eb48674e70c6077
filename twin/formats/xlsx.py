"""Recordings as Excel sheets, through openpyxl: the first sheet that holds numbers."""

from __future__ import annotations

import csv
import io
from datetime import datetime, time
from pathlib import Path
from typing import Any

from twin.errors import RecordingError
from twin.formats.csv import table_of_text
from twin.formats.table import Table, decoding, library


def read(path: Path) -> Table:
    """Read the sheet as the text it would be: header, perhaps units, then one row a sample.

    Raises:
        RecordingError: damaged, or without a sheet that holds anything.
    """
    openpyxl = library("openpyxl", path)
    # Opened here: openpyxl leaves a file open that it cannot read.
    with decoding(path, "Excel"), path.open("rb") as file:
        book = openpyxl.load_workbook(file, read_only=True, data_only=True)
        try:
            for sheet in book.worksheets:
                rows = [list(row) for row in sheet.iter_rows(values_only=True)]
                while rows and all(cell is None for cell in rows[-1]):
                    rows.pop()
                if len(rows) > 1:
                    break
            else:
                raise RecordingError(f"{path}: no sheet holds a header and samples")
        finally:
            book.close()
    width = max(len(row) - next((i for i, c in enumerate(row[::-1]) if c is not None), len(row))
                for row in rows)  # fmt: skip
    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n")
    for row in rows:
        writer.writerow([_text(cell) for cell in row[:width]])
    return table_of_text(text.getvalue().rstrip("\n"), str(path))


def _text(cell: Any) -> str:
    if cell is None:
        return ""
    if isinstance(cell, datetime | time):
        return cell.isoformat()
    return " ".join(str(cell).split()) if isinstance(cell, str) else repr(cell)
