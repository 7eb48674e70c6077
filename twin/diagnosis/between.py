"""What the inputs do between samples, the analyser's filter, folding and large motion, by evidence.

What one analyser measured is alike between samples; what motors were commanded is another thing (a
computer holds its output), so the two are asked for apart.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.beginning import (
    added,
    attempted,
    by_name,
    carried,
    likeliest,
    moved_to,
    start_of,
)
from twin.diagnosis.candidates import Candidate, motions, priors_of, surroundings
from twin.diagnosis.filtering import likeliest_filter
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.large_motion import ENOUGH, along_its_motion
from twin.diagnosis.plant import structure_of
from twin.diagnosis.portion import on_a_part
from twin.diagnosis.problem import Between, Problem
from twin.estimation.fit import ENOUGH as WORTH_A_STEP
from twin.estimation.fit import WORTH, Fit, fit
from twin.estimation.trust import BESIDE_NOISE
from twin.mechanisms.sensor_delay import SensorDelay

Array = NDArray[np.float64]

FEW = 6
"""Gauss-Newton steps that tell what the inputs do between samples: they differ by thousands of
nats where it matters."""

KINDS: dict[Between, str] = {
    "band_limited": "band-limited between the samples",
    "linear": "straight lines between the samples",
    "held": "held from sample to sample",
}


def choose(problem: Problem, known: Mapping[str, float] | None = None) -> tuple[Problem, Array]:
    """Return the problem with what the inputs do between samples, and a calibration.

    Band-limited unless another is better from there on. What holds its value is half a sample late,
    and so may be a channel: another than band-limited is asked for again beside delays of all
    outputs. A calibration that runs away tells nothing of either, unless it is the inputs that it
    ran away from: they are asked for again beside what explains more.

    Args:
        problem: the estimation problem.
        known: values by name of a calibration without large motion, if there is one: the first one
            begins there, with large motion or without it, as it is likelier.
    """
    blank = Hypothesis(problem)
    start = start_of(blank)
    if known:
        start = carried(blank, known)
        without = replace(blank, problem=replace(problem, large=False))
        blank = max((blank, without), key=lambda h: likeliest(h, [start])[0])
    first = fit(blank, start)
    hypothesis, found = again(blank, first, inputs_alone=first.code == "ran away")
    if found.code == "ran away":
        return blank.problem, first.z
    if set(hypothesis.problem.between) != {"band_limited"}:
        late, z = _late(hypothesis, found)
        other, beside = again(late, fit(late, z))
        turned = other.problem.between != hypothesis.problem.between
        if turned and beside.log_evidence > found.log_evidence:
            hypothesis = replace(blank, problem=other.problem)
            found = fit(hypothesis, carried(hypothesis, by_name(late, beside.z)))
    return hypothesis.problem, found.z


def _late(hypothesis: Hypothesis, found: Fit) -> tuple[Hypothesis, Array]:
    """Return a hypothesis with a delay of every output beside, and where its fit begins, (p,)."""
    problem, grown, z = hypothesis.problem, hypothesis, found.z
    moved = motions(problem, hypothesis, z, found.averages)
    for place in problem.model.outputs:
        starts = SensorDelay.starts(place, surroundings(problem, moved, place))
        none = SensorDelay(place)
        more = added(grown, Candidate(starts, priors_of(starts)), none)
        grown, z = more, moved_to(more, grown, z, none)
    return grown, z


def again(
    hypothesis: Hypothesis, found: Fit, steps: int = FEW, enough: float = WORTH_A_STEP,
    inputs_alone: bool = False,
) -> tuple[Hypothesis, Fit]:  # fmt: skip
    """Return a fit with other inputs between the samples, or another analyser, if likelier now.

    A twin that lacks much takes them for what they are not. Others are fitted from where it is, a
    few steps each: the inputs that were measured, motors' commands, large motion and the
    analyser's filter in turn.

    Args:
        hypothesis: what was fitted.
        found: its fit.
        steps: of a fit with other inputs; with none only the likelihood at the same values counts.
        enough: gain [nat] below which a step of the fit with the likeliest is not worth another.
        inputs_alone: whether nothing but inputs and commands is asked for.
    """
    if steps and not _open(hypothesis, found, steps):
        return hypothesis, found
    for others in _of_inputs(hypothesis.problem) if inputs_alone else _groups(hypothesis):
        before = None
        while before is not hypothesis:
            before = hypothesis
            hypothesis, found = _better(hypothesis, found, others(hypothesis, found), steps, enough)
            if others not in (_otherwise_large, _otherwise_filtered, _otherwise_folded):
                break  # of few kinds the best is known; of these only where to look further
    return hypothesis, found


def _better(
    hypothesis: Hypothesis,
    found: Fit,
    problems: Sequence[Problem],
    steps: int,
    enough: float = WORTH_A_STEP,
) -> tuple[Hypothesis, Fit]:
    """Return the likeliest of a fit and fits of other problems, a few steps each.

    Others begin where it ended, and so gain something by their steps alone: not less than ``WORTH``
    counts. A fit that ended early would gain more by its own: then others take no step.
    """
    own = _odds(hypothesis.problem)
    best = hypothesis, found, found.log_evidence - own + WORTH
    for problem in problems:
        other, odds = replace(hypothesis, problem=problem), _odds(problem)
        rival = found.log_posterior - own + odds
        if not steps and likeliest(other, [found.z], found.averages)[0] <= rival:
            continue
        tried = attempted(other, found.z, steps, rival, near=found.averages)
        if tried is not None and tried.log_evidence - odds > best[2]:
            best = other, tried, tried.log_evidence - odds
    if best[0] is hypothesis:
        return hypothesis, found
    other, last, _ = best
    return other, attempted(other, last.z, enough=enough, near=last.averages) or last


def _open(hypothesis: Hypothesis, found: Fit, steps: int) -> bool:
    """Return whether a part of the samples leaves it open that others are likelier."""
    part = on_a_part(hypothesis)
    if part is None:
        return True
    own = attempted(part, found.z, steps, near=found.averages)
    if own is None:
        return True
    least = own.log_evidence - _odds(hypothesis.problem) + WORTH
    for problem in (problem for others in _groups(part) for problem in others(part, own)):
        odds = _odds(problem)
        tried = attempted(replace(part, problem=problem), own.z, steps, least + odds,
                          near=own.averages)  # fmt: skip
        if tried is not None and tried.log_evidence - odds > least:
            return True
    return False


def in_words(problem: Problem) -> str:
    """Say what the inputs are taken for between the samples."""
    names = dict.fromkeys(KINDS, "")
    for name, kind in zip(problem.model.inputs, problem.between, strict=True):
        names[kind] += f", {name}" if names[kind] else name
    if len(set(problem.between)) == 1:
        return f"the inputs are taken as {KINDS[problem.between[0]]}"
    return "; ".join(f"{who} taken as {KINDS[kind]}" for kind, who in names.items() if who)


def motion_in_words(problem: Problem) -> tuple[str, ...]:
    """Say that large motion is left out; nothing where it is not."""
    if problem.large:
        return ()
    return (
        "the recordings do not show what large motion adds by the model's kinematics: the "
        "structure is taken as linear in its geometry",
    )


def filter_in_words(hypothesis: Hypothesis) -> tuple[str, ...]:
    """Say how laws are seen of which samples do not show all; nothing where there are none."""
    if not hypothesis.stirs:
        return ()
    leaning = "laws that lean on modes above half the sampling rate"
    folded = "laws whose harmonics reach half the sampling rate"
    smooth = leaning if hypothesis.problem.rings else folded
    corners = "laws with corners" if hypothesis.blurred else smooth
    which = "laws that jump" if hypothesis.jumps else corners
    seen = hypothesis.problem.low_pass
    if seen is None:
        less = "; their jumps count for less" if hypothesis.blurred else ""
        return (f"{which} follow the estimated motion{less}",)
    kind = f"Butterworth's of order {seen.order}" if seen.order else "of linear phase"
    edge = f"{seen.cut_off / 2:g} of the sampling rate"
    return (f"{which} are simulated, and seen through a low-pass {kind}, its edge {edge}",)


def _of_inputs(problem: Problem) -> list[Callable[[Hypothesis, Fit], list[Problem]]]:
    """Return what finds other inputs, and other commands."""
    driven = sorted({_driven(problem, name) for name in problem.model.inputs})
    return [partial(_otherwise_between, driven=d) for d in driven]


def _groups(hypothesis: Hypothesis) -> list[Callable[[Hypothesis, Fit], list[Problem]]]:
    """Return what finds other problems: of inputs, commands, motion, folding and the filter."""
    problem = hypothesis.problem
    groups = _of_inputs(problem)
    if problem.kinematics is not None:
        groups.append(_otherwise_large)
    if any(np.any(blur) for blur in _folded(problem)):
        groups.append(_otherwise_folded)
    return [*groups, *([_otherwise_filtered] if hypothesis.stirs else [])]


def _otherwise_between(hypothesis: Hypothesis, found: Fit, driven: bool) -> list[Problem]:
    """Return what else measured inputs, or motors' commands, could do between samples."""
    problem = hypothesis.problem
    several = (
        tuple(
            kind if _driven(problem, name) == driven else now
            for name, now in zip(problem.model.inputs, problem.between, strict=True)
        )
        for kind in KINDS
    )
    return [replace(problem, between=b) for b in several if b != problem.between]


def _otherwise_large(hypothesis: Hypothesis, found: Fit) -> list[Problem]:
    """Return without what large motion adds by the model's kinematics, or with it.

    And with that along the motion of this very fit: where the twin lacked something, or was not
    calibrated yet, it had been that along another motion.
    """
    with_it = along_its_motion(hypothesis, found.z, found.averages)
    if hypothesis.problem.large:
        return [replace(hypothesis.problem, large=False), with_it]
    return [replace(with_it, large=True)]


def _otherwise_folded(hypothesis: Hypothesis, found: Fit) -> list[Problem]:
    """Return with what the structure as it stands makes of what is folded, if it is another.

    A dashpot that the nominal twin lacks damps modes above the band, too.
    """
    problem = hypothesis.problem
    base = problem.base(found.z[: len(problem.base_unknowns)])
    other = replace(problem, folding=structure_of(base, hypothesis.at(found.z)))
    pairs = zip(_folded(problem), _folded(other), problem.recordings, strict=True)
    same = all(np.all(np.abs(before - after) <= BESIDE_NOISE * recording.output_noise**2)
               for before, after, recording in pairs)  # fmt: skip
    return [] if same else [other]


def _folded(problem: Problem) -> list[Array]:
    """Return the variances of outputs by what is folded, (samples, m), in each recording."""
    return [np.zeros_like(t.y) if t.blur is None else t.blur for t in problem.trials]


def _otherwise_filtered(hypothesis: Hypothesis, found: Fit) -> list[Problem]:
    """Return with the likeliest filter where a fit is, and with none.

    With none a law follows the estimated motion, as where forces act that nobody measured.
    """
    options = (likeliest_filter(hypothesis, found), None)
    problem = hypothesis.problem
    return [replace(problem, low_pass=f) for f in options if f != problem.low_pass]


def _driven(problem: Problem, name: str) -> bool:
    return name in problem.model.driven


def _odds(problem: Problem) -> float:
    """Return the log odds against kinds of inputs, and a motion that its model does not have."""
    unlikely = len(set(problem.between) - {"band_limited"})
    return ENOUGH * (unlikely + (not problem.large))
