"""Fit a hypothesis and the slack of its filter in turn, strengths of unmeasured forces included."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import SLACKS, Bench
from twin.diagnosis.fitting import Fit, fit, fitting_starts, gains_of, log_likelihood, log_prior
from twin.diagnosis.hypothesis import Hypothesis
from twin.mechanisms.mechanism import Disturbance, Law

Array = NDArray[np.float64]

FACTORS = (0.01, 0.1, 0.4, 2.5, 10.0)
"""By which the strength and the bandwidth of an unmeasured force are tried, and what friction's
change of sign is blurred by."""

SHARPER = 1e-3
"""Factor by which friction's change of sign is made sharper for a start of its own."""

FAR = 35.0
"""Slacks further apart than by this factor are not neighbours."""


def with_widths(bench: Bench, found: Fit) -> Fit:
    """Return the fit with what Gauss-Newton steps do not find, by trying.

    Strengths and bandwidths of unmeasured forces act on the filter's gain alone, which the steps
    hold fixed; along what blurs dry friction the likelihood has a ridge for every sign that flips.
    """
    best = found
    for index, mechanism in enumerate(found.hypothesis.found):
        names: tuple[str, ...] = ("rms", "bandwidth") if isinstance(mechanism, Disturbance) else ()
        if isinstance(mechanism, Law) and mechanism.sticks:
            names = ("regular_rate",)
        for name in names:
            here = best.hypothesis.found[index]
            for factor in FACTORS:
                changed = here.with_values({name: factor * here.values[name]})
                mechanisms = list(best.hypothesis.found)
                mechanisms[index] = changed
                hypothesis = replace(found.hypothesis, found=tuple(mechanisms))
                try:
                    gains = gains_of(bench, hypothesis, best.slack)
                except np.linalg.LinAlgError:
                    continue
                rows = bench.innovations([hypothesis], gains, best.starts)
                e = tuple(row[0] for row in rows)
                value = log_likelihood(e)
                if value > best.log_likelihood:
                    best = replace(
                        best, hypothesis=hypothesis, log_likelihood=value, gains=gains,
                        innovations=e,
                    )  # fmt: skip
    return best


def with_slack(bench: Bench, found: Fit, slacks: Sequence[float] | None = None) -> Fit:
    """Return the fit with the slack that its likelihood likes best, parameters unchanged."""
    best = found
    for slack in bench.slacks if slacks is None else slacks:
        if slack == found.slack:
            continue
        try:
            gains = gains_of(bench, found.hypothesis, slack)
        except np.linalg.LinAlgError:
            continue
        rows = bench.innovations([found.hypothesis], gains, found.starts)
        e = tuple(row[0] for row in rows)
        value = log_likelihood(e)
        if value > best.log_likelihood:
            best = replace(found, log_likelihood=value, slack=slack, gains=gains, innovations=e)
    return best


def refined(
    bench: Bench,
    starts: Sequence[Hypothesis],
    slack: float,
    states: Sequence[Array] | None = None,
    rounds: int = 6,
    iterations: int = 3,
) -> Fit:
    """Fit parameters and slack in turn until neither gains.

    A slack that falls as the fit improves is what keeps it out of local minima: the filter follows
    the data closely at first and leaves more and more to the model.

    Args:
        bench: trials and model.
        starts: the same hypothesis at one or more starting points, the neutral one last.
        slack: to begin with.
        states: initial states, one (n,) a trial.
        rounds: at most.
        iterations: Gauss-Newton steps in each.
    """
    if states is not None and starts[-1].sticks:
        # states that a poorer model asked for hold friction where it never stuck
        given = _posterior(bench, starts[-1], slack, states)
        states = states if given > _posterior(bench, starts[-1], slack, None) else None
    found = _refined(bench, starts, slack, states, rounds, iterations)
    sharp = [h for h in map(_sharpened, starts) if h is not None]
    if sharp:
        with suppress(np.linalg.LinAlgError):
            other = _refined(bench, sharp, slack, None, rounds, iterations)
            found = max(found, other, key=lambda f: f.log_posterior)
    return found


def _refined(
    bench: Bench,
    starts: Sequence[Hypothesis],
    slack: float,
    states: Sequence[Array] | None,
    rounds: int,
    iterations: int,
) -> Fit:
    """Return what one set of starting points leads to."""
    # the last start is the neutral one: not the best to begin with, but without a bent base
    others = sorted(starts[:-1], key=lambda h: -_posterior(bench, h, slack, states))[:1]
    tried = [_begun(bench, h, slack, states, iterations) for h in (*others, starts[-1])]
    own = max(bench.slacks, key=lambda s: _posterior(bench, starts[-1], s, states))
    if own < slack / FAR:
        # where the model before was wrong by far, its slack hides what the new one is good for
        tried.append(_begun(bench, starts[-1], own, states, iterations))
    best = max(tried, key=lambda f: f.log_posterior)
    for _ in range(rounds):
        near = [s for s in bench.slacks if best.slack / FAR < s < best.slack * FAR]
        moved = with_widths(bench, with_slack(bench, best, near))
        before = best.log_posterior
        try:
            best = fit(bench, moved.hypothesis, moved.slack, moved.starts, iterations)
        except np.linalg.LinAlgError:
            return moved
        if moved.slack == best.slack and best.log_posterior - before < 1.0:
            tightened = _tightened(bench, best, iterations)
            if tightened.log_posterior - best.log_posterior < 1.0:
                return best
            best = tightened
    return best


def _sharpened(start: Hypothesis) -> Hypothesis | None:
    """Return a start whose last finding, if it sticks, changes its sign at once.

    Blurred as the screening likes it, friction that holds the frame for most of a recording looks
    like damping, and its fit may go astray; sharp, it may be stuck where it begins.
    """
    last = start.found[-1] if start.found else None
    if not isinstance(last, Law) or not last.sticks:
        return None
    sharp = last.with_values({"regular_rate": SHARPER * last.values["regular_rate"]})
    return replace(start, found=(*start.found[:-1], sharp))


def _begun(
    bench: Bench,
    hypothesis: Hypothesis,
    slack: float,
    states: Sequence[Array] | None,
    iterations: int,
) -> Fit:
    """Return the first few steps from one start, with the slack they like."""
    try:
        found = fit(bench, hypothesis, slack, states, iterations)
    except np.linalg.LinAlgError:
        # with no noise to speak of the Riccati equation can be too stiff
        found = fit(bench, hypothesis, max(100 * slack, SLACKS[2]), states, iterations)
    return with_slack(bench, found)


def _tightened(bench: Bench, best: Fit, iterations: int) -> Fit:
    """Fit with much less slack from where the fit rests, where it has slack to lose.

    At a large slack the filter follows the data whatever the parameters are, and the likelihood is
    flat; at a small one the way to the right values may go on.
    """
    if best.slack < 1e-3:
        return best
    less = max((s for s in bench.slacks if s <= best.slack / 10), default=bench.slacks[0])
    try:
        found = fit(bench, best.hypothesis, less, best.starts, 3 * iterations)
    except np.linalg.LinAlgError:
        return best
    return with_slack(bench, found)


def _posterior(
    bench: Bench, hypothesis: Hypothesis, slack: float, states: Sequence[Array] | None
) -> float:
    """Return the log posterior of a hypothesis as it stands."""
    try:
        gains = gains_of(bench, hypothesis, slack)
    except np.linalg.LinAlgError:
        return -np.inf
    begin = fitting_starts(states, len(gains[0].filtered), len(bench.trials))
    unknowns = hypothesis.unknowns()
    rows = bench.innovations([hypothesis], gains, begin)
    return log_likelihood([r[0] for r in rows]) + log_prior(unknowns, hypothesis.vector(unknowns))
