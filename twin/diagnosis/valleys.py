"""First guesses where the likelihood has several maxima: short fits, of which the likelier go on.

What resonates shows at strength zero that it is there, not at which frequency; what turns a phase
far, or is there or not, is no straight line in its strength.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.adjusted import Adjusted
from twin.diagnosis.beginning import added, from_nominal, likelier, likeliest, moved_to, nominal
from twin.diagnosis.candidates import Candidate
from twin.diagnosis.drawing import far_off
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.linearised import Linearised
from twin.diagnosis.portion import ROUGH, beginning_of
from twin.estimation.fit import LONGEST, Fit
from twin.estimation.fit import fit as climb
from twin.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]

FIRST, LAPS = 3, (2, 3)
"""Steps in each valley: at first of what is added alone, the others adjusted to first order, then
of all unknowns. Before the first the likelier half of the places of each mechanism goes on, before
and after each lap the likelier half of a candidate's valleys (successive halving; Jamieson and
Talwalkar 2016) and as many candidates as are fitted; the fit that follows takes the rest."""

WIDTH, ALIKE = 6, 3
"""Candidates of the screening that are fitted in a search step, and how many of them may be one
mechanism at several places: where it is not, it is likely in many. As many valleys of one that
shifts its own resonance are followed in all unknowns: neighbours lead to the same optimum."""

_Runner = tuple[float, Array, Linearised]
"""Rise of the log posterior beside the part of the samples, values, and what has them."""

_Race = tuple[Candidate, list[_Runner]]


@dataclass(frozen=True)
class Score:
    """What one first guess of a candidate promises.

    Attributes:
        candidate: whose it is.
        start: the mechanism from which a fit would begin.
        gain: expected rise of the log evidence [nat].
        shift: how the other unknowns would move with it: name -> prior deviations.
    """

    candidate: Candidate
    start: Mechanism
    gain: float
    shift: Mapping[str, float] = field(default_factory=dict)


def of_valleys(fit: Fit, linear: Linearised, candidates: Sequence[Candidate]) -> list[Score]:
    """Return what candidates with several valleys promise: short fits on a part of the samples.

    Args:
        fit: the present one.
        linear: what was fitted, with its laws linearised: they do as they did in the short fits.
        candidates: with the first guesses that the score test does not rule out; no laws.
    """
    if not candidates:
        return []
    hypothesis = linear.hypothesis
    short = beginning_of(hypothesis)
    here = climb(linear.beside(short), fit.z, free=linear.free)
    known = {u.name: z for u, z in zip(hypothesis.unknowns, fit.z, strict=True)}
    adjusted = Adjusted(linear.beside(short), here)
    gone = far_off(short.problem, here.z)
    # the nominal twin is another beginning where no step reaches it from where the fit is
    base = here.z[: len(short.problem.base_unknowns)]
    apart = gone or bool(np.max(np.abs(base), initial=0.0) > LONGEST)
    racing: list[_Race] = []
    for candidate in candidates:
        runners = []
        for start in candidate.starts:
            grown = added(short, candidate, start)
            model, z = linear.beside(grown), moved_to(grown, short, here.z, start)
            options = (z, nominal(grown, z)) if apart else (z,)
            runners.append(_nearer(adjusted, here, model, options))
        racing.append((candidate, _likelier(runners)))
    # the others adjusted, where it begins tells already which places of a mechanism are unlikely
    behind: list[_Race] = []
    racing = _halved_by_kind(racing, behind)
    racing = [(c, _likelier(_followed(adjusted, here, runners))) for c, runners in racing]
    if not hypothesis.laws and gone:
        # laws are held as they were beside the calibrated twin
        racing = _with_nominal(linear, short, here, racing)
    # what gains no more on this part than a step has to is as far as it gets
    behind += [(c, runners) for c, runners in racing if not runners[0][0] > ROUGH]
    racing = _ahead([(c, runners) for c, runners in racing if runners[0][0] > ROUGH], behind)
    for steps in LAPS:
        racing = [
            (c, _likelier([_further(here.log_posterior, r, steps) for r in runners]))
            for c, runners in racing
        ]
        racing = _ahead(racing, behind)
    scores = []
    for candidate, runners in racing + behind:
        told, z, model = runners[0]
        shift = {
            u.name: float(x) - known[u.name]
            for u, x in zip(model.unknowns, z, strict=True)
            if u.role != "noise" and u.name in known
        }
        # how much of it the other samples hold, only they can say: a blow is over in seconds; on
        # the average they do not lower what a part of them tells of what is there
        mechanism = model.at(z)[-1]
        whole = added(hypothesis, candidate, mechanism)
        posterior, _ = likelier(whole, [z, moved_to(whole, hypothesis, fit.z, mechanism)])
        gain = max(posterior - fit.log_posterior, told, 0.0)
        gain -= candidate.width(mechanism, gain)
        scores.append(Score(candidate, mechanism, gain, shift))
    return scores


def _nearer(adjusted: Adjusted, here: Fit, model: Linearised, options: Sequence[Array]) -> _Runner:
    """Return the likelier of beginnings: with the others adjusted, unless these go too far for it.

    Where the structure changes straight with what is added a calibration that stands for it is far
    from where the others are with it, and slopes there adjust them to anything.
    """
    if model.hypothesis.mechanisms[-1].valleys == 1:
        begun = [(likeliest(model, [z])[0] - here.log_posterior, z, model) for z in options]
    else:
        begun = [_begun(adjusted, (-np.inf, z, model), 0) for z in options]
    return max(begun, key=lambda runner: runner[0])


def _begun(adjusted: Adjusted, runner: _Runner, steps: int) -> _Runner:
    """Return where so many first steps lead, of what is added alone; none tell where it stands."""
    _, z, model = runner
    try:
        value, moved = adjusted.steps(model, z, steps)
    except np.linalg.LinAlgError:
        return -np.inf, z, model
    return value - adjusted.log_posterior, moved if steps else z, model


def _followed(adjusted: Adjusted, here: Fit, runners: list[_Runner]) -> list[_Runner]:
    """Return where first steps lead: of what is added alone, the others adjusted to first order.

    Where its own resonance goes with its strength, or the structure changes straight with it, the
    others move too far with it for that: of the likeliest such ones, steps of all unknowns.
    """
    last = runners[0][2].hypothesis.mechanisms[-1]
    if last.shifts_resonance or last.valleys == 1:
        return [_further(here.log_posterior, runner, FIRST) for runner in runners[:ALIKE]]
    return [_begun(adjusted, runner, FIRST) for runner in runners]


def _with_nominal(
    linear: Linearised, short: Hypothesis, here: Fit, racing: Sequence[_Race]
) -> list[_Race]:
    """Return a race with runners from the nominal twin, where a resonance goes with a strength.

    A calibration that has gone far to stand for what is missing is in another valley than it is. Of
    several places of a mechanism the likeliest ones begin there.
    """
    begun = list[_Race]()
    for candidate, _ in racing:
        runners = list[_Runner]()
        for start in candidate.starts if candidate.starts[0].shifts_resonance else ():
            grown = added(short, candidate, start)
            model = linear.beside(grown)
            z = from_nominal(grown, moved_to(grown, short, here.z, start))
            runners.append((likeliest(model, [z])[0] - here.log_posterior, z, model))
        begun.append((candidate, sorted(runners, key=lambda r: -r[0])[:ALIKE]))
    there = sorted((race for race in begun if race[1]), key=lambda race: -race[1][0][0])
    first = first_of_each([candidate.label[0] for candidate, _ in there])
    more = dict[tuple[str, str], _Runner]()
    for candidate, runners in (there[i] for i in first):
        near = [_further(here.log_posterior, runner, FIRST) for runner in runners]
        likely = max(near, key=lambda runner: runner[0])
        more[candidate.label] = _further(here.log_posterior, likely, sum(LAPS))
    return [
        (c, sorted([*runners, more[c.label]], key=lambda r: -r[0]) if c.label in more else runners)
        for c, runners in racing
    ]


def _halved_by_kind(racing: list[_Race], behind: list[_Race]) -> list[_Race]:
    """Return the likelier half of the places of every mechanism; the others are put behind."""
    names = [candidate.label[0] for candidate, _ in racing]
    ahead = half_of_each(names, [runners[0][0] for _, runners in racing])
    behind += [race for i, race in enumerate(racing) if i not in ahead]
    return [racing[i] for i in ahead]


def half_of_each(names: Sequence[str], values: Sequence[float]) -> list[int]:
    """Return where the half of each name with greater values stands, ``WIDTH`` at least."""
    out = list[int]()
    for name in dict.fromkeys(names):
        alike = [i for i, other in enumerate(names) if other == name]
        alike.sort(key=lambda i: -values[i])
        out += alike[: max((len(alike) + 1) // 2, WIDTH)]
    return out


def _ahead(racing: list[_Race], behind: list[_Race]) -> list[_Race]:
    """Return the candidates that go on, of which as many are fitted; the rest is put behind."""
    racing = sorted(racing, key=lambda race: -race[1][0][0])
    names = [candidate.label[0] for candidate, _ in racing]
    ahead = first_of_each(names)[:WIDTH]
    behind += [race for i, race in enumerate(racing) if i not in ahead]
    return [racing[i] for i in ahead]


def first_of_each(names: Sequence[str]) -> list[int]:
    """Return where the first ``ALIKE`` of each name stand, in their order."""
    return [i for i, name in enumerate(names) if names[:i].count(name) < ALIKE]


def _likelier(runners: list[_Runner]) -> list[_Runner]:
    """Return the half with the greater log posteriors, the greatest first."""
    return sorted(runners, key=lambda r: -r[0])[: (len(runners) + 1) // 2]


def _further(without: float, runner: _Runner, steps: int) -> _Runner:
    """Return where so many steps lead from a runner; the log posterior without it is known."""
    _, z, model = runner
    try:
        found = climb(model, z, most=steps, free=model.free, curved=False)
    except np.linalg.LinAlgError:
        return runner
    return found.log_posterior - without, found.z, model
