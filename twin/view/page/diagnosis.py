"""A diagnosis as one HTML file, in the order in which one asks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from twin.diagnosis.result import Diagnosis, Finding
from twin.diagnosis.verdict import none_of_these
from twin.provenance import Provenance, provenance
from twin.view.colours import MEASURED, TRUE
from twin.view.diagnosis_words import (
    DETECTION_HEADERS,
    FINDING_HEADERS,
    FIT_HEADERS,
    detection_rows,
    finding_rows,
    fit_rows,
    log_odds,
    named,
    printable,
    proof_sentence,
    quantity,
    share_sentence,
    verdict_sentence,
    where_words,
)
from twin.view.located import regions, shares
from twin.view.page import diagnosis_plots as plots
from twin.view.page.blocks import Block, Command, Items, Page, Plot, Section, Table, Text
from twin.view.page.render import render, write_page
from twin.view.page.structure import sketch

SHOWN_TESTS = 2
"""Unseen recordings that are drawn above the fold."""


def write_report(diagnosis: Diagnosis, path: Path, made: Provenance | None = None) -> Path:
    """Write the report whole or not at all.

    Args:
        diagnosis: what was found.
        path: the .html file.
        made: where it comes from; date and versions alone without.
    """
    return write_page(page(diagnosis, made or provenance()), path)


def report(diagnosis: Diagnosis) -> str:
    """Return the report as HTML text."""
    return render(page(diagnosis, provenance()))


def page(diagnosis: Diagnosis, made: Provenance) -> Page:
    """Return the report: verdict, before and after, where, the force, what else, what next."""
    lead = " ".join(filter(None, [proof_sentence(diagnosis), share_sentence(diagnosis)]))
    tests = [trace for trace in diagnosis.traces if trace.role == "test"]
    others = [trace for trace in diagnosis.traces if trace.role != "test"] + tests[SHOWN_TESTS:]
    sections = [
        Section("What was left out", _findings(diagnosis)),
        Section(
            "Before and after, on recordings it has not seen",
            [plots.before_after(trace, "unseen") for trace in tests[:SHOWN_TESTS]],
        ),
        Section("Where", _where(diagnosis)),
        Section("The missing force", _forces(diagnosis)),
        Section("What else it could be", _others(diagnosis)),
        Section("What to test next", _next(diagnosis)),
        Section("Errors of the twins", [
            plots.errors(diagnosis), Table(FIT_HEADERS, fit_rows(diagnosis))], folded=True),
        Section("Other recordings", [
            plots.before_after(trace, "other") for trace in others], folded=True),
        Section("Other places", _innocent(diagnosis), folded=True),
        Section("How it was noticed", _detection(diagnosis), folded=True),
        Section("What was screened", [plots.screening(diagnosis)] if diagnosis.screening else [],
                folded=True),
        Section("Calibration", _calibration(diagnosis), folded=True),
        Section("Notes", _notes(diagnosis)),
        Section("How long it took", _steps(diagnosis), folded=True),
    ]  # fmt: skip
    filled = [section for section in sections if section.blocks]
    return Page(verdict_sentence(diagnosis), lead, filled, made)


def _findings(diagnosis: Diagnosis) -> list[Block]:
    if not diagnosis.findings:
        return []
    rows = finding_rows(diagnosis.findings)
    if len(rows) == 1:
        return [Table(FINDING_HEADERS, rows)]
    headers = (*FINDING_HEADERS, "share of what is missing")
    parts = shares(diagnosis)
    shared = [
        (*cells, f"{100 * parts[f.location]:.0f} %")
        for cells, f in zip(rows, diagnosis.findings, strict=True)
    ]
    return [Table(headers, shared)]


def _where(diagnosis: Diagnosis) -> list[Block]:
    parts = shares(diagnosis)
    trace = diagnosis.traces[0] if diagnosis.traces else None
    inputs, outputs = (trace.inputs, trace.outputs) if trace else ((), ())
    found = regions(diagnosis, [*parts, *inputs, *outputs])
    lit = {place: (found[place], share) for place, share in parts.items() if place in found}
    drawn = sketch(diagnosis.nominal, lit, inputs, outputs, found)
    if parts:
        caption = "What was found lights up, by its share of the missing force."
    else:
        caption = "Nothing is out of place."
    keys = [("sensor", TRUE), ("driven", MEASURED)]
    out: list[Block] = [Plot(drawn, caption, keys, wide=False)]
    if diagnosis.where:
        out.append(plots.where(diagnosis))
    return out


def _forces(diagnosis: Diagnosis) -> list[Block]:
    out: list[Block] = []
    by_place = {f.location: f for f in reversed(diagnosis.findings)}
    for picture in diagnosis.force:
        if picture.place in by_place:
            finding = by_place[picture.place]
            of_law = picture.law is not None or picture.cycle is not None
            out += plots.force(picture, finding if of_law else None)
    if out:
        out.insert(0, Text(
            "Points: what the estimated motion needs beyond the measured forces, the calibrated "
            "masses, stiffnesses and dampings and what was found elsewhere. Curve: the law, "
            "relative to the same twin, with its 95 % band."
        ))  # fmt: skip
    return out


def _innocent(diagnosis: Diagnosis) -> list[Block]:
    located = {f.location for f in diagnosis.findings}
    pictures = [p for p in diagnosis.force if p.place not in located]
    blocks: list[Block] = [plot for picture in pictures for plot in plots.force(picture)[:1]]
    if blocks:
        blocks.insert(0, Text(
            "The same where nothing was found. Where the samples are coarse, below some twenty a "
            "period of the highest mode, what they leave out of the acceleration looks like a law."
        ))  # fmt: skip
    return blocks


def _others(diagnosis: Diagnosis) -> list[Block]:
    if not (diagnosis.findings and diagnosis.alternatives):
        return []
    rivals = sorted(diagnosis.alternatives, key=lambda f: -f.probability)
    kept = Text(
        f"Of every probability {100 * none_of_these():.1f} % is kept for a mechanism that is not "
        "among those that a diagnosis can name."
    )
    return [plots.alternatives(diagnosis), Table(FINDING_HEADERS, finding_rows(rivals)), kept]


def _next(diagnosis: Diagnosis) -> list[Block]:
    advice = diagnosis.next_experiment
    if advice is None:
        return [Text("Nothing ties: no further experiment is needed to tell explanations apart.")]
    sentence = printable(advice.reason).rstrip(".")
    out: list[Block] = [
        Text(f"{sentence}. Expected log odds: {log_odds(advice.expected_log_odds)}."),
        Command(printable(advice.command)),
    ]
    if advice.options:
        ordered = sorted(advice.options, key=lambda option: -option[1])
        out.append(
            Table(("test", "expected log odds [nat]"), [(t, log_odds(g)) for t, g in ordered])
        )
    return out


def _detection(diagnosis: Diagnosis) -> list[Block]:
    if not diagnosis.detection:
        return []
    return [
        Text("One-step errors of the calibrated twin against the noise of each channel."),
        plots.detection(diagnosis.detection),
        Table(DETECTION_HEADERS, detection_rows(diagnosis.detection)),
    ]


def _calibration(diagnosis: Diagnosis) -> list[Block]:
    rows = [
        (named(f.mechanism), where_words(f.mechanism), _change(f)) for f in diagnosis.calibration
    ]
    text = "How far the best twin without new physics is from the model."
    return [Text(text), Table(("parameter", "place", "change"), rows)] if rows else []


def _change(finding: Finding) -> str:
    mechanism = finding.mechanism
    return ", ".join(
        quantity(value, finding.std.get(name, float("nan")), mechanism.parameters[name].unit)
        for name, value in mechanism.values.items()
    )


def _notes(diagnosis: Diagnosis) -> Sequence[Block]:
    out: list[Block] = []
    if diagnosis.notes:
        out.append(Items([printable(note) for note in diagnosis.notes]))
    return out


def _steps(diagnosis: Diagnosis) -> Sequence[Block]:
    out: list[Block] = []
    if diagnosis.steps:
        rows = [(name, f"{s:.1f}") for name, s in diagnosis.steps.items()]
        out.append(Table(("step", "seconds"), [*rows, ("all", f"{diagnosis.seconds:.1f}")]))
    return out
