"""Where dry friction jumps, recordings are blurred: there they are not compared.

Every instrument filters what it samples. Equations that are linear hold between filtered channels
as they do between true ones, but friction's jumps are blurred over some samples, with ringing, and
the twin's are not. Strong friction leaves more of that than another effect beside it does.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench
from twin.diagnosis.channels import distorted
from twin.diagnosis.fitting import Fit
from twin.diagnosis.plant import laws_of
from twin.diagnosis.refining import refined

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

JUMP = 0.3
"""Change of a friction force within a sample, as a share of its sliding force, that is a jump."""

LEAVES = 0.03
"""The same of one that has slid until then: it sticks with a jump, however small."""

SLIDES = 0.99
"""Share of its sliding force from which on friction slides."""

BLURRED = 3
"""Samples before and after a jump that a filter's step response takes to rise and ring out."""

MOST = 0.5
"""Share of the samples that may be left out, at most."""


def without_jumps(bench: Bench, current: Fit) -> tuple[Bench, Fit]:
    """Return the bench without the samples at which the fit's friction jumps, and the fit anew.

    Laws are not compared there; what is linear finds the fit's own predictions, which say nothing.
    Both are unchanged where nothing sticks and slips, or does so all the time.
    """
    rest = _left_out(bench, [current])
    if rest is bench:
        return bench, current
    try:
        return rest, _anew(rest, current)
    except np.linalg.LinAlgError:
        return bench, current


def without_any_jumps(
    bench: Bench, current: Fit, fits: Sequence[Fit]
) -> tuple[Bench, Fit, tuple[Fit, ...]]:
    """Return the bench without the samples at which friction jumps in any of the fits, all anew.

    What is found beside friction moves its jumps. Compared where only the jumps of the fit before
    are left out, what is right has jumps of its own to answer for.

    Returns:
        The bench, the current fit, and the others, the best first; those that fail are missing.
    """
    rest = _left_out(bench, [current, *fits])
    if rest is bench:
        return bench, current, tuple(fits)
    again = []
    try:
        mine = _anew(rest, current)
    except np.linalg.LinAlgError:
        return bench, current, tuple(fits)
    for fit in fits:
        with suppress(np.linalg.LinAlgError):
            again.append(_anew(rest, fit))
    return rest, mine, tuple(sorted(again, key=lambda f: f.bic))


def _anew(bench: Bench, fit: Fit) -> Fit:
    return refined(bench, [fit.hypothesis], fit.slack, fit.starts)


def _left_out(bench: Bench, fits: Sequence[Fit]) -> Bench:
    """Return the bench without the samples at which friction jumps in any of the fits.

    Predictions of the first fit stand there. The same bench where none sticks, where nothing more
    is left out, or where too much would be.
    """
    if not any(fit.hypothesis.sticks for fit in fits):
        return bench
    whole = replace(bench, trials=tuple(t.with_outputs(t.y) for t in bench.trials))
    moved = [whole.stepped([fit.hypothesis], fit.gains, fit.starts) for fit in fits]
    before = [np.zeros(t.samples, bool) if t.blurred is None else t.blurred for t in bench.trials]
    near = before
    for fit, trials in zip(fits, moved, strict=True):
        jumps = [_near_jumps(fit, memories[0]) for _, _, memories in trials]
        more = [a | b for a, b in zip(near, jumps, strict=True)]
        if _count(more) < MOST * bench.samples:
            near = more
    if _count(near) == _count(before):
        return bench
    mechanisms = fits[0].hypothesis.mechanisms
    rest = []
    for trial, its, (e, _, _) in zip(bench.trials, near, moved[0], strict=True):
        missed = np.where(its[:, None], e[0], 0.0)
        rest.append(trial.with_outputs(trial.y - distorted(trial, mechanisms, missed), its))
    return replace(bench, trials=tuple(rest))


def _near_jumps(fit: Fit, memories: Array) -> Mask:
    """Return which samples are near a jump of the fit's friction, of its laws' (samples, laws)."""
    laws = laws_of(fit.hypothesis.mechanisms)
    sticks = [j for j, law in enumerate(laws) if law.sticks]
    sliding = np.array([laws[j].numbers[0] for j in sticks])
    force = memories[:, sticks]
    before = np.vstack([force[:1], force[:-1]])
    least = np.where(np.abs(before) > SLIDES * sliding, LEAVES, JUMP)
    jumps = np.any(np.abs(force - before) > least * sliding, axis=1)
    return np.asarray(np.convolve(jumps, np.ones(2 * BLURRED + 1))[BLURRED:-BLURRED] > 0)


def _count(masks: Sequence[Mask]) -> int:
    return sum(int(mask.sum()) for mask in masks)


def with_recorded_outputs(bench: Bench, recorded: Bench) -> Bench:
    """Return a bench with the outputs of another one of the same trials."""
    pairs = zip(bench.trials, recorded.trials, strict=True)
    return replace(bench, trials=tuple(one.with_outputs(other.y) for one, other in pairs))
