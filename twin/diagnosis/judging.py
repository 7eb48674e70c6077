"""What a search comes to: findings, what else they could be, and what to do about ties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from twin.diagnosis.advise import instead, next_experiment
from twin.diagnosis.base import storey_values
from twin.diagnosis.bench import Bench
from twin.diagnosis.evidence import probabilities, probability_over
from twin.diagnosis.fitting import Fit
from twin.diagnosis.heard import even_odds
from twin.diagnosis.predict import strength_of
from twin.diagnosis.result import Finding, NextExperiment, Verdict
from twin.diagnosis.search import Found
from twin.diagnosis.stage import TIE
from twin.mechanisms.mechanism import Disturbance
from twin.mechanisms.stiffness import Stiffness
from twin.model_files import shipped_names

BESIDES = 0.03
"""Share of a storey's stiffness beyond which a difference of it is a finding of its own."""

SURE = 0.95
"""Probability from which an explanation needs no further experiment."""


def findings_of(found: Found) -> tuple[tuple[Finding, ...], tuple[Finding, ...]]:
    """Return findings in the order of what each explains, and what else could be the first."""
    best = found.best
    count = len(best.hypothesis.found)
    out, alternatives = [], []
    if found.named is not None:
        chances = probabilities([best, found.named])
        law = Finding(best.hypothesis.found[0], _std(best, 0), chances[0])
        for number, mechanism in enumerate(found.named.hypothesis.found):
            delta = float(found.named.bic - best.bic)
            alternatives.append(Finding(mechanism, _std(found.named, number), chances[1], delta))
        return (law,), tuple(alternatives)
    strengths = strength_of(found.bench, best.hypothesis, best.slack)
    for number in range(count):
        stage = found.stages[number]
        chances = even_odds(found.bench, stage.fits, probabilities(stage.fits))
        mine = best.hypothesis.found[number]
        if number in strengths:
            mine = mine.with_values({"rms": strengths[number]})
        out.append((found.lost[number], Finding(mine, _std(best, number), chances[0])))
        for other, chance in zip(stage.fits[1:], chances[1:], strict=True):
            at = instead(stage.fits[0], other)
            if at is not None:
                delta = float(other.bic - stage.fits[0].bic)
                mechanism = other.hypothesis.found[at]
                alternatives.append(Finding(mechanism, _std(other, at), chance, delta))
    out.sort(key=lambda pair: -pair[0])
    alternatives.sort(key=lambda f: -f.probability)
    parts = [part for _, f in out for part in _parted(f, found.bench)]
    return tuple(parts), tuple(alternatives)


def felt_alike(findings: Sequence[Finding], alternatives: Sequence[Finding]) -> tuple[str, ...]:
    """Say which places of an unmeasured force no sensor tells apart."""
    notes = []
    for finding in findings:
        name, odds = finding.mechanism.name, finding.probability
        alike = (a for a in alternatives if (a.mechanism.name, a.probability) == (name, odds))
        same = [a.location for a in alike]
        if isinstance(finding.mechanism, Disturbance) and same:
            places = " and ".join([finding.location, *same])
            notes.append(f"{name}: the sensors feel {places} alike; one more accelerometer tells")
    return tuple(notes)


def _parted(finding: Finding, bench: Bench) -> list[Finding]:
    """Return a joint that takes more or less stiffness than it gives back, and the difference.

    A part of the storey that has play or slips replaces its own stiffness, a brace that was added
    replaces none; between and beyond, the storey's stiffness has changed besides.
    """
    joint = finding.mechanism
    values = joint.values
    if "replaced" not in values or not joint.place.startswith("storey"):
        return [finding]
    change = values["stiffness"] - values["replaced"]
    least = BESIDES * storey_values(bench.model, bench.model.K)[joint.place]
    if abs(change) < least or abs(values["replaced"]) < least:
        return [finding]
    std = dict(finding.std)
    spread = float(np.hypot(std.pop("replaced", 0.0), std.get("stiffness", 0.0)))
    own = joint.with_values({"replaced": values["stiffness"]})
    return [
        replace(finding, mechanism=own, std=std | {"replaced": std.get("stiffness", 0.0)}),
        replace(finding, mechanism=Stiffness(joint.place, change), std={"change": spread}),
    ]


def advice(found: Found, model: str, seed: int) -> NextExperiment | None:
    """Return the test that separates the first finding from what ties with it, if anything does."""
    if found.named is not None:
        return None
    for stage in found.stages[: len(found.best.hypothesis.found)]:
        best = stage.fits[0]
        for other in stage.fits[1:]:
            if probability_over(best, other) < SURE or other.bic - best.bic < TIE:
                return next_experiment(found.bench, best, other, _short(model), seed)
    return None


def _short(source: str) -> str:
    """Return the name of a shipped model, or the file as it is."""
    path = Path(source)
    return path.stem if path.stem in shipped_names() else source


def _std(best: Fit, number: int) -> dict[str, float]:
    """Return the standard deviations of a found mechanism's parameters, in their units."""
    index = len(best.hypothesis.base) + number
    mechanism = best.hypothesis.mechanisms[index]
    out = {}
    for unknown, std in zip(best.unknowns, best.std, strict=True):
        if unknown.index == index:
            value = abs(mechanism.values[unknown.name])
            out[unknown.name] = float(std * value if unknown.log else std)
    if isinstance(mechanism, Disturbance):
        # strength and bandwidth are found by trying, the slopes that give deviations lack them
        out |= dict.fromkeys(("rms", "bandwidth"), float("nan"))
    return out


def verdict_of(findings: Sequence[Finding]) -> Verdict:
    """Return the kind of mismatch that the first finding is."""
    return findings[0].mechanism.verdict if findings else "consistent"
