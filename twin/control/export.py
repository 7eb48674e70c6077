"""The controller to the lab computer: matrices as MAT and CSV, the whole of it as one C file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import io

from twin.control.c_source import c_source
from twin.control.controller import Controller
from twin.files import folder, write_whole

Array = NDArray[np.float64]


def matrices(controller: Controller) -> dict[str, Array]:
    """Return the matrices by name, each with two dimensions, vectors as columns or rows."""
    c = controller
    return {
        "A": c.A,
        "B_y": c.B_y,
        "B_f": c.B_f[:, None],
        "B_u": c.B_u[:, None],
        "C": c.C[None],
        "D_y": c.D_y[None],
        "D_f": np.array([[c.D_f]]),
        "E": c.E,
    }


def settings(controller: Controller) -> dict[str, float]:
    """Return the numbers beside the matrices, in SI units."""
    c = controller
    return {
        "dt_s": c.dt,
        "torque_limit_nm": c.torque_limit,
        "ramp_samples": float(c.ramp_samples),
        "design_delay_samples": c.delay,
    }


def export(controller: Controller, target: Path, stem: str = "controller") -> tuple[Path, ...]:
    """Write ``stem``.mat, ``stem``.c and one ``stem``_NAME.csv a matrix; return their paths.

    The MAT file holds the matrices, the settings and the names of the channels; CSV rows are
    matrix rows, with all digits, and ``stem``_settings.csv has one ``name,value`` a line.

    Raises:
        TwinError: the folder cannot be written.
    """
    target = folder(target)
    numbers, found = settings(controller), matrices(controller)
    content = {
        **found,
        **numbers,
        "measurements": np.array(controller.measurements, object),
        "known_input": controller.known_input,
        "estimates": np.array(controller.estimates, object),
    }
    text = {f"{stem}_{name}.csv": _csv(values) for name, values in found.items()}
    lines = [f"{name},{value!r}" for name, value in numbers.items()]
    lines += [f"known_input,{controller.known_input}"]
    lines += [f"y{i},{name}" for i, name in enumerate(controller.measurements)]
    lines += [f"estimate{i},{name}" for i, name in enumerate(controller.estimates)]
    text[f"{stem}_settings.csv"] = "\n".join(lines) + "\n"
    text[f"{stem}.c"] = c_source(controller)
    paths = [write_whole(target / f"{stem}.mat", lambda part: io.savemat(part, content))]
    paths += [write_whole(target / name, _writer(body)) for name, body in text.items()]
    return tuple(paths)


def _csv(values: Array) -> str:
    return "".join(",".join(repr(float(x)) for x in row) + "\n" for row in values)


def _writer(body: str) -> Callable[[Path], object]:
    return lambda part: part.write_text(body, encoding="utf-8", newline="\n")
