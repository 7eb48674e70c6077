"""What a search comes to: findings with probabilities, what else they could be, and the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.dropping import lost
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.left import law_whose_form, left_share
from twin.diagnosis.predict import Predictor
from twin.diagnosis.read_off import ReadOff
from twin.diagnosis.result import Finding, Verdict
from twin.diagnosis.search import Found
from twin.diagnosis.sizes import forces, negligible
from twin.mechanisms import vocabulary
from twin.mechanisms.mechanism import Disturbance, Mechanism

Array = NDArray[np.float64]
Label = tuple[str, str]

TIE = 0.05
"""Probability from which an alternative is worth a word: one in twenty."""


@dataclass(frozen=True)
class Judgement:
    """What the best explanation says.

    Attributes:
        verdict: what kind of mismatch there is.
        findings: in the order of what each explains.
        alternatives: what else each could be, the most probable first.
        negligible: mechanisms of the best explanation whose effect is smaller than what is left.
        notes: ties, and what is negligible.
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    alternatives: tuple[Finding, ...]
    negligible: tuple[Finding, ...]
    notes: tuple[str, ...]


def none_of_these() -> float:
    """Return the probability that something is at work that is not in the vocabulary.

    By the rule of succession (Laplace 1814): of V mechanisms that are known the next one is a new
    one with probability 1 / (V + 2). It may look like the best of them, so it keeps its share.
    """
    return 1 / (len(vocabulary()) + 2)


def judge(found: Found, beside: Sequence[Predictor], faults: Sequence[ReadOff] = ()) -> Judgement:
    """Judge the explanations of a search.

    Args:
        found: what it found.
        beside: the best explanation beside the training recordings.
        faults: of instruments, read off the samples.
    """
    best = found.best
    sizes = forces(best.hypothesis, best.fit.z, beside)
    small = negligible(best.hypothesis, best.fit, beside, sizes, bool(faults))
    everything = (found.nothing, best, *found.others)
    judged = []
    for index, mechanism in enumerate(best.hypothesis.at(best.fit.z)):
        rivals, loss = _rivals(best, everything, index)
        finding = _finding(best, index, mechanism, 0.0, 0.0)
        own = left_share(best.hypothesis, best.fit, index, sizes)
        finding = replace(finding, explained=None if own is None else 1 - own, unexplained=own)
        finding = replace(finding, gain=loss if loss else None)
        law = law_whose_form(best.hypothesis, best.fit.z, sizes, index)
        judged.append((loss, small[index], finding, rivals, law))
    judged.sort(key=lambda entry: -entry[0])
    findings, trifles, notes, alternatives = [], [], [], []
    for loss, trifling, finding, rivals, law in judged:
        chances = _chances([0.0, *(delta for _, delta in rivals)])
        here = replace(finding, probability=chances[0])
        if trifling:
            trifles.append(here)
            notes.append(_trifle(here, None if law is None else best.hypothesis.mechanisms[law]))
            continue
        findings.append(here)
        for (rival, delta), chance in zip(rivals, chances[1:], strict=True):
            other = _newcomer(rival, best)
            if other is not None:
                mechanism = rival.hypothesis.at(rival.fit.z)[other]
                entry = _finding(rival, other, mechanism, chance, delta)
                gain = loss + delta if loss else None
                alternatives.append(replace(entry, gain=gain))
    findings = _with_read_off(findings, _read_off(faults, best))
    alternatives.sort(key=lambda f: (-f.probability, -f.delta_log_evidence))
    return Judgement(
        _verdict(findings), tuple(findings), tuple(alternatives), tuple(trifles),
        (*notes, *_felt_alike(findings, alternatives)),
    )  # fmt: skip


def _trifle(finding: Finding, law: Mechanism | None) -> str:
    """Say why a mechanism is no finding.

    Args:
        finding: the mechanism.
        law: whose form it stands for, if it does.
    """
    name = f"{finding.mechanism.name} at {finding.location}"
    if law is None:
        return f"{name} is negligible: smaller than what is left unexplained"
    return f"{name} stands for what {law.name} at {law.place} leaves of the force there"


def _read_off(faults: Sequence[ReadOff], best: Explanation) -> list[Finding]:
    """Return what the samples show by themselves, one finding a channel and fault.

    Where a law jumps, what looks like it is the law's.
    """
    worst: dict[Label, ReadOff] = {}
    for found in faults:
        key = (found.fault.name, found.fault.place)
        if found.fault.like_jumps and best.hypothesis.blurred:
            continue
        if key not in worst or found.share > worst[key].share:
            worst[key] = found
    return [Finding(f.fault, {}, _chances([0.0])[0]) for f in worst.values()]


def _with_read_off(findings: Sequence[Finding], faults: Sequence[Finding]) -> list[Finding]:
    """Return findings with the faults that were read off the samples.

    An error without a name in the same channel comes behind: it is what is left of the named one.
    """
    out = list(findings)
    for fault in faults:
        rest = (i for i, f in enumerate(out)
                if f.mechanism.generic and f.location == fault.location)  # fmt: skip
        out.insert(next(rest, len(out)), fault)
    return out


def _verdict(findings: Sequence[Finding]) -> Verdict:
    """Return the kind of mismatch: that of the first finding, unless it explains less than half."""
    if not findings:
        return "consistent"
    first = findings[0]
    told, left = first.explained, first.unexplained
    if told is not None and left is not None and left > told:
        return "unexplained"
    return first.mechanism.verdict


def _rivals(
    best: Explanation, everything: Sequence[Explanation], index: int
) -> tuple[list[tuple[Explanation, float]], float]:
    """Return explanations with something else, or nothing, in place of one mechanism.

    Each with its log odds over the explanation with it; and the log odds that are lost without it.
    Those of the whole set come before those of the set as it was when the mechanism was added.
    """
    labels = best.labels
    rivals: dict[Label | None, tuple[Explanation, float]] = {}
    for kept, reference in (
        (set(labels[:index]), _with(everything, set(labels[: index + 1]))),
        (set(labels) - {labels[index]}, best),
    ):
        if reference is None:
            continue
        for other in everything:
            has = set(other.labels)
            # what the best one has besides is no rival of what it has here, though found later
            if kept <= has and len(has - kept) <= 1 and not (has - kept) & set(labels):
                key = next(iter(has - kept), None)
                # what is likelier than the mechanism alone stands for what came to it later, too
                likelier = other.log_odds > reference.log_odds
                rivals[key] = other, other.log_odds - (best if likelier else reference).log_odds
    loss = -rivals[None][1] if None in rivals else lost(best, index)
    return sorted(rivals.values(), key=lambda pair: -pair[1]), loss


def _with(everything: Sequence[Explanation], labels: set[Label]) -> Explanation | None:
    return next((e for e in everything if set(e.labels) == labels), None)


def _newcomer(rival: Explanation, best: Explanation) -> int | None:
    return next((i for i, x in enumerate(rival.labels) if x not in best.labels), None)


def _chances(log_odds: Sequence[float]) -> list[float]:
    """Return probabilities of explanations, what is in no vocabulary keeping its share."""
    weights = np.exp(np.array(log_odds) - max(log_odds))
    return list((1 - none_of_these()) * weights / weights.sum())


def _finding(
    explanation: Explanation, index: int, mechanism: Mechanism, chance: float, delta: float
) -> Finding:
    """Return a mechanism of an explanation with deviations and correlations of its parameters."""
    names = list(mechanism.parameters)
    titles = [f"{mechanism.name} {mechanism.place} {name}" for name in names]
    known = explanation.fit.deviations
    std = {name: known[title] for name, title in zip(names, titles, strict=True)}
    for name, (whole, _, _) in mechanism.shares.items():
        std[name] *= mechanism.values[whole]
    return Finding(mechanism, std, chance, delta)


def _felt_alike(findings: Sequence[Finding], alternatives: Sequence[Finding]) -> tuple[str, ...]:
    """Say which places of an unmeasured force no sensor tells apart."""
    notes = []
    for finding in findings:
        name = finding.mechanism.name
        same = [a.location for a in alternatives
                if a.mechanism.name == name and a.probability >= TIE]  # fmt: skip
        if isinstance(finding.mechanism, Disturbance) and same:
            there = " and ".join([finding.location, *same])
            notes.append(f"{name}: the sensors feel {there} alike; one more accelerometer tells")
    return tuple(notes)
