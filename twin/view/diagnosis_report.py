"""A diagnosis as one HTML file: no network, pictures inside."""

from __future__ import annotations

import base64
from io import BytesIO
from pathlib import Path

import jinja2
from matplotlib.figure import Figure

from twin.diagnosis.result import Diagnosis, Finding
from twin.files import write_whole
from twin.view import diagnosis_figures, diagnosis_place
from twin.view.diagnosis_words import (
    DETECTION_HEADERS,
    FINDING_HEADERS,
    FIT_HEADERS,
    detection_rows,
    finding_rows,
    fit_rows,
    named,
    place_words,
    printable,
    proof_sentence,
    quantity,
    verdict_sentence,
)

MOST_FORCES = 2
DPI = 110


def write_report(diagnosis: Diagnosis, path: Path) -> Path:
    """Write the report whole or not at all.

    Args:
        diagnosis: what was found.
        path: the .html file.
    """
    html = report(diagnosis)
    return write_whole(path, lambda part: part.write_text(html, encoding="utf-8"))


def report(diagnosis: Diagnosis) -> str:
    """Return the report as HTML text."""
    loader = jinja2.PackageLoader("twin.view", "templates")
    environment = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined
    )
    tests = [trace for trace in diagnosis.traces if trace.role == "test"]
    pictures = {
        "before_after": [_png(diagnosis_figures.before_after(trace)) for trace in tests],
        "errors": [_png(diagnosis_figures.errors(diagnosis))],
        "where": [_png(diagnosis_place.where(diagnosis))],
        "force": [_png(diagnosis_place.force(p)) for p in diagnosis.force[:MOST_FORCES]],
        "ranking": [_png(diagnosis_figures.ranking(diagnosis))],
        "detection": [_png(diagnosis_figures.detection(diagnosis))],
    }
    advice = diagnosis.next_experiment
    calibration = [
        (named(f.mechanism), place_words(f.location), _change(f)) for f in diagnosis.calibration
    ]
    return environment.get_template("diagnosis.html").render(
        verdict=verdict_sentence(diagnosis),
        proof=proof_sentence(diagnosis),
        findings=finding_rows(diagnosis.findings),
        finding_headers=FINDING_HEADERS,
        alternatives=finding_rows(diagnosis.alternatives),
        fits=fit_rows(diagnosis),
        fit_headers=FIT_HEADERS,
        detection=detection_rows(diagnosis.detection),
        detection_headers=DETECTION_HEADERS,
        pictures=pictures,
        advice=advice,
        options=[(text, f"{gain:.3g}") for text, gain in advice.options] if advice else [],
        calibration=calibration,
        notes=[printable(note) for note in diagnosis.notes],
        steps=[(name, f"{s:.2f}") for name, s in diagnosis.steps.items()],
        seconds=diagnosis.seconds,
    )


def _change(finding: Finding) -> str:
    mechanism = finding.mechanism
    return ", ".join(
        quantity(value, finding.std.get(name, float("nan")), mechanism.parameters[name].unit)
        for name, value in mechanism.values.items()
    )


def _png(figure: Figure) -> str:
    data = BytesIO()
    figure.savefig(data, format="png", dpi=DPI)
    return base64.b64encode(data.getvalue()).decode()
