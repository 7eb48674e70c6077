"""Recordings as universal files, dataset 58 (function at nodal DOF), through pyuff.

Written in binary (58b) and double precision. The header keeps six digits of the time axis, so
rate and start stand in the fifth ID line too.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from twin.channel import AXES, Channel
from twin.errors import RecordingError
from twin.formats.table import Column, Table, decoding, library, samples_of
from twin.formats.time_axis import roundest, uniform
from twin.place import split_channel
from twin.recording import Recording
from twin.units import split_name

Array = NDArray[np.float64]

TIME_RESPONSE = 1
"""Function type of a time history."""

ABSCISSA_DIGITS = 5e-6
"""Relative rounding of the time step in the header (E13.5)."""

SPECIFIC_TYPE = {
    **{"disp": 8, "angle": 8, "vel": 11, "rate": 11, "acc": 12, "angacc": 12},
    **{"force": 13, "torque": 13, "strain": 3, "pressure": 15},
}
"""Specific data type of each kind of channel; 1 is a general one, 17 is time."""

LONGEST_NAME, LONGEST_UNIT = 80, 20
"""Letters that the format has for an ID line and for the label of a unit."""

ROTATIONS = ("angle", "rate", "angacc", "torque")

_NUMBER = r"(-?[0-9.]+(?:e[-+]?[0-9]+)?)"
_AXIS = re.compile(rf"sampling_hz={_NUMBER} start_s={_NUMBER}")
_DIRECTION = {0: "", 1: "X", 2: "Y", 3: "Z", 4: "RX", 5: "RY", 6: "RZ"}


def read(path: Path) -> Table:
    """List the time histories by their first ID line, or by node and direction without one.

    Raises:
        RecordingError: damaged, or without time histories.
    """
    pyuff = library("pyuff", path)
    with decoding(path, "UFF"):
        file = pyuff.UFF(str(path))
        kinds = [int(kind) for kind in file.get_set_types()]
        sets = [file.read_sets(n) for n, kind in enumerate(kinds) if kind == 58]
        histories = [s for s in sets if s["func_type"] == TIME_RESPONSE]
        if histories:
            names = _names(histories)
            made = [_column(h, name) for h, name in zip(histories, names, strict=True)]
    if not histories:
        raise RecordingError(
            f"{path}: no time histories (dataset 58 of function type 1) among {len(kinds)} datasets"
        )
    for history, name in zip(histories, names, strict=True):
        if len(history["data"]) != history["num_pts"]:
            raise RecordingError(
                f"{path}: '{name}' has {len(history['data'])} of {history['num_pts']} samples; "
                "the file is cut short or damaged"
            )

    def load(indices: Sequence[int]) -> list[Array]:
        return [
            samples_of(histories[index]["data"], f"{path}: column '{names[index]}'")
            for index in indices
        ]

    return Table(str(path), tuple(made), load)


def write(recording: Recording, path: Path) -> None:
    """Write one binary dataset 58 a channel."""
    pyuff = library("pyuff", path)
    sets = []
    for index, channel in enumerate(recording.channels):
        if len(channel.name) > LONGEST_NAME or not channel.title.isascii():
            raise RecordingError(
                f"{path}: a universal file cannot hold the name '{channel.name[:LONGEST_NAME]}': "
                f"at most {LONGEST_NAME} letters, ASCII; write CSV, HDF5 or NPZ"
            )
        sets.append(
            {
                **_REFERENCE,
                "type": 58,
                "binary": 1,
                "id1": channel.name,
                "id2": "frame-twin",
                "id5": f"sampling_hz={float(recording.sampling_hz)!r} "
                f"start_s={float(recording.start_s)!r}",
                "func_type": TIME_RESPONSE,
                "rsp_node": _node(channel, index),
                "rsp_dir": 1 + _axis(channel) + 3 * (channel.kind in ROTATIONS),
                "abscissa_spacing": 1,
                "abscissa_spec_data_type": 17,
                "abscissa_axis_units_lab": "s",
                "ordinate_spec_data_type": SPECIFIC_TYPE.get(channel.kind, 1),
                "ordinate_axis_units_lab": channel.unit,
                "x": recording.time,
                "data": np.array(recording.data[:, index]),
            }
        )
    try:
        # not "overwrite": with binary data pyuff then overwrites its own header
        path.write_bytes(b"")
        with catch_warnings():
            simplefilter("ignore", ResourceWarning)  # pyuff leaves a file to the collector
            pyuff.UFF(str(path)).write_sets(sets, mode="add")
    except Exception as error:  # pyuff hides a full disk behind a plain Exception
        raise OSError(str(error)) from None


_REFERENCE = {
    "ref_node": 0,
    "ref_dir": 0,
    "orddenom_spec_data_type": 0,
    "z_axis_spec_data_type": 0,
    "z_axis_value": 0.0,
}


def _node(channel: Channel, index: int) -> int:
    """Return the floor of a frame's channel, or a number of its own beyond them."""
    parts = split_channel(channel.element)
    return parts[1].number if parts else 1001 + index


def _axis(channel: Channel) -> int:
    """Return 0, 1, 2 for x, y, z; a pendulum swings about y, what has no axis is along x."""
    pendulum = split_channel(channel.element) and channel.kind in ROTATIONS
    return AXES.index(channel.axis) if channel.axis else int(bool(pendulum))


def _names(histories: list[dict[str, Any]]) -> list[str]:
    described = [split_name(str(h["id1"]))[0] for h in histories]
    usable = all(described) and "NONE" not in described and len(set(described)) == len(described)
    return described if usable else [_degree_of_freedom(h) for h in histories]


def _degree_of_freedom(history: dict[str, Any]) -> str:
    direction = int(history["rsp_dir"])
    sign = "-" if direction < 0 else ""
    return f"{history['rsp_node']}{sign}{_DIRECTION.get(abs(direction), direction)}"


def _column(history: dict[str, Any], name: str) -> Column:
    label = str(history.get("ordinate_axis_units_lab", "")).strip()
    unit = split_name(str(history["id1"]))[1] or (None if label in ("", "NONE") else label)
    if history["abscissa_spacing"] != 1:
        try:
            axis = uniform(np.asarray(history["x"], float), "sample {}".format)
        except RecordingError as error:
            return Column(name, unit, problem=f"is not uniform: {error}")
        return Column(name, unit, axis.sampling_hz, axis.start_s)
    start, step = float(history["abscissa_min"]), float(history["abscissa_inc"])
    if not (np.isfinite(step) and step > 0 and np.isfinite(start)):
        return Column(name, unit, problem=f"starts at {start} s with steps of {step} s")
    written = _AXIS.search(str(history["id5"]))
    if written:
        exact = float(written[1])
        if abs(exact * step - 1) <= 2 * ABSCISSA_DIGITS:
            return Column(name, unit, exact, float(written[2]))
    return Column(name, unit, roundest(1 / step, ABSCISSA_DIGITS), start)
