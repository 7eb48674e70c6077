"""How nouns and results draw, list and save themselves: behind ``twin.presentable``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twin.control.controller import Controller
from twin.diagnosis.result import Diagnosis
from twin.errors import TwinError
from twin.files import write_whole
from twin.identification.result import Identification
from twin.model import Twin
from twin.presentable import Presentable
from twin.recording import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot(thing: Presentable) -> Figure:
    """Return a figure: samples over time, frequency responses, mode shapes, or before and after."""
    if isinstance(thing, Recording):
        from twin.view.recording_figures import samples

        return samples(thing)
    if isinstance(thing, Identification):
        from twin.view.figures import frequency_responses

        return frequency_responses(thing)
    if isinstance(thing, Diagnosis):
        from twin.view.diagnosis_figures import before_after, errors

        unseen = [trace for trace in thing.traces if trace.role == "test"]
        traces = unseen or list(thing.traces)
        return before_after(traces[0]) if traces else errors(thing)
    if isinstance(thing, Twin):
        from twin.view.deflection import mode_shapes
        from twin.view.recording_figures import shapes

        return shapes(mode_shapes(thing.modes()))
    raise TwinError(f"a {type(thing).__name__} has no figure of its own")


def to_dict(thing: Presentable) -> dict[str, Any]:
    """Return everything as plain Python."""
    if isinstance(thing, Recording):
        return {
            "source": thing.source,
            "sampling_hz": thing.sampling_hz,
            "start_s": thing.start_s,
            "channels": {c.title: thing.column(c.name).tolist() for c in thing.channels},
            "notes": list(thing.notes),
        }
    if isinstance(thing, Identification):
        from twin.identification.as_json import as_json

        return as_json(thing)
    if isinstance(thing, Diagnosis):
        from twin.diagnosis.result import as_json as diagnosis_json

        return diagnosis_json(thing, None)
    if isinstance(thing, Controller):
        from twin.control.export import matrices, settings

        parts = {name: value.tolist() for name, value in matrices(thing).items()}
        return {"settings": dict(settings(thing)), "matrices": parts}
    if isinstance(thing, Twin):
        return {
            "source": thing.source,
            "mjcf": thing.mjcf,
            "mechanisms": [mechanism.as_json() for mechanism in thing.mechanisms],
        }
    raise TwinError(f"a {type(thing).__name__} has no dictionary")


def save(thing: Presentable, path: Path) -> Path:
    """Write a noun or a result in the format of the suffix."""
    suffix = path.suffix.lower()
    if isinstance(thing, Recording):
        from twin.formats import write_recording

        return write_recording(thing, path)
    if suffix == ".json":
        text = json.dumps(to_dict(thing), indent=1, allow_nan=False) + "\n"
        return write_whole(path, lambda part: part.write_text(text))
    if isinstance(thing, Twin) and suffix == ".xml":
        return thing.export(path)
    if isinstance(thing, Identification) and suffix == ".html":
        from twin.view.page.identification import write_identification_page

        return write_identification_page(path, thing)
    if isinstance(thing, Identification) and suffix == ".rrd":
        from twin.view.rrd import write_rrd

        return write_rrd(path, thing)
    if isinstance(thing, Diagnosis) and suffix in (".html", ".rrd", ".xml"):
        if suffix == ".xml":
            return thing.explained.export(path)
        if suffix == ".html":
            from twin.view.page.diagnosis import write_report

            return write_report(thing, path)
        from twin.view.diagnosis_rrd import write_diagnosis_rrd

        return write_diagnosis_rrd(thing, path)
    if isinstance(thing, Controller) and suffix in (".c", ".mat"):
        from twin.control.export import export

        written = export(thing, path.parent, path.stem)
        return next(each for each in written if each.suffix == suffix)
    can = {Twin: ".xml, .json", Identification: ".json, .html, .rrd", Controller: ".json, .mat, .c"}
    raise TwinError(
        f"{path}: a {type(thing).__name__} is not written as '{suffix}'; "
        f"{can.get(type(thing), '.json, .html, .rrd, .xml')} are"
    )
