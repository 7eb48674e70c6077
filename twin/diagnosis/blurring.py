"""Where dry friction jumps, recordings are blurred: there they are not compared.

Every instrument filters what it samples. Equations that are linear hold between filtered channels
as they do between true ones, but friction's jumps are blurred over some samples, with ringing, and
the twin's are not. Strong friction leaves more of that than another effect beside it does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twin.diagnosis.bench import Bench, distorted
from twin.diagnosis.fitting import Fit
from twin.diagnosis.plant import laws_of
from twin.diagnosis.refining import refined

JUMP = 0.3
"""Change of a friction force within a sample, as a share of its sliding force, that is a jump."""

BLURRED = 3
"""Samples before and after a jump that a filter's step response takes to rise and ring out."""

MOST = 0.5
"""Share of the samples that may be left out, at most."""


def without_jumps(bench: Bench, current: Fit) -> tuple[Bench, Fit]:
    """Return the bench without the samples at which the fit's friction jumps, and the fit anew.

    Laws are not compared there; what is linear finds the fit's own predictions, which say nothing.
    Both are unchanged where nothing sticks and slips, or does so all the time.
    """
    laws = laws_of(current.hypothesis.mechanisms)
    sticks = [j for j, law in enumerate(laws) if law.sticks]
    if not sticks:
        return bench, current
    sliding = np.array([laws[j].numbers[0] for j in sticks])
    around = np.ones(2 * BLURRED + 1)
    whole = replace(bench, trials=tuple(t.with_outputs(t.y) for t in bench.trials))
    stepped = whole.stepped([current.hypothesis], current.gains, current.starts)
    trials, left_out = [], 0
    for trial, (e, _, memories) in zip(bench.trials, stepped, strict=True):
        moved = np.abs(np.diff(memories[0][:, sticks], axis=0, prepend=memories[0][:1, sticks]))
        jumps = np.any(moved > JUMP * sliding, axis=1)
        near = np.convolve(jumps, around)[BLURRED:-BLURRED] > 0
        if trial.blurred is not None:
            near |= trial.blurred
        missed = np.where(near[:, None], e[0], 0.0)
        y = trial.y - distorted(trial, current.hypothesis.mechanisms, missed)
        trials.append(trial.with_outputs(y, near))
        left_out += int(near.sum())
    if not 0 < left_out < MOST * bench.samples:
        return bench, current
    rest = replace(bench, trials=tuple(trials))
    try:
        return rest, refined(rest, [current.hypothesis], current.slack, current.starts)
    except np.linalg.LinAlgError:
        return bench, current


def with_recorded_outputs(bench: Bench, recorded: Bench) -> Bench:
    """Return a bench with the outputs of another one of the same trials."""
    pairs = zip(bench.trials, recorded.trials, strict=True)
    return replace(bench, trials=tuple(one.with_outputs(other.y) for one, other in pairs))
