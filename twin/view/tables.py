"""Tables of what was identified, for the terminal (rich) and for Rerun (Markdown)."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import JustifyMethod
from rich.markup import escape
from rich.table import Table

from twin.recording import Recording
from twin.view.comparison import Row

REDUCTIONS = {
    "whole": "peak reduction from switching on",
    "steady": "peak reduction, steady",
    "rms": "RMS reduction, steady",
}
"""What the windows of eq. (60) are for: the whole of both halves of a run, or their last halves."""

BOUND_NOTE = "CR bound: the Cramér-Rao bound, the smallest standard deviation the data allow."

HEADERS = (
    "parameter",
    "identified",
    "std",
    "CR bound",
    "true",
    "error",
    "error/std",
)

NEGLIGIBLE = 1e-9
"""Errors below this many per cent are rounding and shown as zero."""


def cells(row: Row) -> tuple[str, ...]:
    """Return a row as text, one entry for each of ``HEADERS``; "" for what is not known."""
    decimals = _decimals(row)
    bound = "" if row.bound is None else _short(row.bound)
    return (
        f"{row.quantity} [{row.unit}]" if row.unit else row.quantity,
        _fixed(row.identified, decimals),
        "" if row.std is None else _short(row.std),
        bound,
        "" if row.true is None else _fixed(row.true, decimals),
        "" if row.error is None else f"{_signed(100 * row.error)} %",
        "" if row.error_in_std is None else f"{row.error_in_std:+.2f}",
    )


def table_columns(rows: Sequence[Row]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the headers and the cells of all rows, without columns that are empty throughout."""
    body = [cells(row) for row in rows]
    used = [c for c in range(len(HEADERS)) if any(line[c] for line in body)]
    return tuple(HEADERS[c] for c in used), [tuple(line[c] for c in used) for line in body]


def parameter_table(rows: Sequence[Row], title: str) -> Table:
    """Return a table for the terminal of identified against true parameters."""
    headers, body = table_columns(rows)
    table = _plain(title)
    for header in headers:
        justify: JustifyMethod = "left" if header == HEADERS[0] else "right"
        # the last head on two lines: the widest table fits eighty columns
        table.add_column(header.replace("/", "\n/"), justify=justify, no_wrap=True)
    for line in body:
        table.add_row(*map(escape, line))
    if HEADERS[3] in headers:
        table.caption, table.caption_justify = BOUND_NOTE, "left"
    return table


def mode_table(rows: Sequence[Row], title: str) -> Table:
    """Return a table for the terminal with a line for each mode; by parameter where some are known.

    Args:
        rows: the frequency [Hz] and the damping ratio [%] of every mode, in the order of modes.
        title: what the modes are of.
    """
    if not rows or any(row.true is not None for row in rows):
        return parameter_table(rows, title)
    table = _plain(title)
    both = [[cells(row) for row in rows if row.unit == unit] for unit in ("Hz", "%")]
    used = [[c for c in (1, 2, 3) if c == 1 or any(line[c] for line in part)] for part in both]
    table.add_column("mode", justify="right", no_wrap=True)
    for part, columns in zip(both, used, strict=True):
        for c in columns:
            header = re.sub(r" \d+", "", part[0][0]) if c == 1 else HEADERS[c]
            table.add_column(escape(header), justify="right", no_wrap=True)
    for k, lines in enumerate(zip(*both, strict=True)):
        line = [part[c] for part, columns in zip(lines, used, strict=True) for c in columns]
        table.add_row(str(k + 1), *map(escape, line))
    if 3 in used[0]:
        table.caption, table.caption_justify = BOUND_NOTE, "left"
    return table


def markdown_table(rows: Sequence[Row]) -> str:
    """Return the same table as Markdown; an empty text where there are no rows."""
    if not rows:
        return ""
    headers, body = table_columns(rows)
    aligned = tuple("---" if header == HEADERS[0] else "---:" for header in headers)
    lines = [headers, aligned, *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def channel_table(recording: Recording) -> Table:
    """Return a table for the terminal of a recording's channels: role, unit, RMS and peak."""
    seconds = f"{recording.samples} samples at {recording.sampling_hz:g} Hz"
    title = f"{recording.source}: {seconds}"
    table = _plain(title)
    for header in ("channel", "role", "unit"):
        table.add_column(header, no_wrap=True)
    for header in ("RMS", "peak"):
        table.add_column(header, justify="right", no_wrap=True)
    inputs, outputs = recording.inputs, recording.outputs
    for index, channel in enumerate(recording.channels):
        x = recording.data[:, index]
        role = {True: "input", False: "output" if channel.name in outputs else "silent"}
        rms, peak = np.sqrt(np.mean(x**2)), np.abs(x).max()
        table.add_row(
            channel.name, role[channel.name in inputs], channel.unit, f"{rms:.4g}", f"{peak:.4g}"
        )
    return table


def _plain(title: str) -> Table:
    """Return an empty table with a title and a line below its head."""
    return Table(
        title=title,
        title_justify="left",
        box=SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        collapse_padding=True,
    )


def _decimals(row: Row) -> int:
    """Decimals that show two digits of the standard deviation, or five digits of the value."""
    if not row.unit:
        return 6
    if row.std:
        return min(max(1 - math.floor(math.log10(row.std)), 0), 9)
    size = abs(row.identified)
    return min(max(4 - math.floor(math.log10(size)), 0), 9) if size > 0 else 4


def _fixed(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}"


def _short(value: float) -> str:
    """Two significant digits, without an exponent where that stays readable."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    decimals = 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(decimals, 0)}f}" if decimals <= 6 else f"{value:.1e}"


def _signed(value: float) -> str:
    if abs(value) < NEGLIGIBLE:
        return "0"
    decimals = 1 - math.floor(math.log10(abs(value)))
    return f"{value:+.{max(decimals, 0)}f}" if decimals <= 6 else f"{value:+.0e}"
