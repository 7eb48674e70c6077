"""A part of the samples settles how laws are seen before all of them are fitted."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis import explanation
from twin.diagnosis.beginning import likeliest, start_of
from twin.diagnosis.between import again
from twin.diagnosis.candidates import priors_of
from twin.diagnosis.explanation import (
    Explanation,
    analyser_known,
    converged,
    explained,
    in_every_form,
    seen_otherwise,
    settled,
    within_reach,
)
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.portion import SURE, on_a_part
from twin.diagnosis.prepare import prepare
from twin.diagnosis.problem import LINEAR_PHASE
from twin.diagnosis.scales import Scales
from twin.estimation.fit import fit
from twin.estimation.low_pass import LowPass
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.unmeasured_force import UnmeasuredForce


@cache
def rubbing(seconds):
    law = CoulombFriction("storey2", 0.1, 1e-3)
    twin = lumped().including(CoulombFriction("storey2", 0.1))
    train, test = [recorded(twin, 1, seconds=seconds)], [recorded(twin, 2)]
    problem = prepare(lumped(), train, test).train
    return Hypothesis(problem, (law,), (priors_of([law]),), Scales({"storey2": (1.0, 1e-3, 0.05)}))


def test_what_a_part_of_the_samples_rules_out_all_of_them_would():
    options = seen_otherwise(rubbing(24.0))
    assert [option.simulated for option in options] == [True, False]
    left = within_reach(options, start_of(options[0]))
    ends = []
    for option in options:
        ((_, z),) = within_reach([option], start_of(option))
        ends.append(again(option, fit(option, z), steps=0))
    values = [found.log_evidence for _, found in ends]
    assert abs(values[0] - values[1]) > SURE
    (only,) = left
    # one that ends as the other is seen speaks for that one
    assert only[0].simulated is ends[values.index(max(values))][0].simulated


def test_laws_that_follow_the_motion_come_first_and_simulated_ones_must_get_as_far(monkeypatch):
    asked, own = [], explanation.attempted

    def heard(h, z, **how):
        found = own(h, z, **how)
        asked.append((h.simulated, how["hopeless"], found.log_evidence))
        return found

    monkeypatch.setattr(explanation, "attempted", heard)
    options = seen_otherwise(rubbing(24.0))
    within_reach(options, start_of(options[0]))
    (first, any_at_all, reached), (second, least, _) = asked
    assert (first, second) == (False, True)
    assert any_at_all == -np.inf
    assert least >= reached - SURE


def test_a_recording_that_is_hardly_longer_than_the_part_rules_out_none():
    options = seen_otherwise(rubbing(8.0))
    assert on_a_part(options[0]) is None
    z = start_of(options[0])
    assert [option for option, _ in within_reach(options, z)] == list(options)


def test_what_ends_with_laws_seen_as_another_option_has_them_speaks_for_that_one(monkeypatch):
    simulated, followed = seen_otherwise(rubbing(24.0))
    z, own = start_of(simulated), explanation.again

    def turned(h, found, steps, enough):
        if h.problem.low_pass is not None:
            return own(h, found, steps, enough)
        there = replace(h, problem=replace(h.problem, low_pass=simulated.problem.low_pass))
        return there, replace(found, log_evidence=1e9)  # far better than anything that follows

    monkeypatch.setattr(explanation, "again", turned)
    ((kept, _),) = within_reach([simulated, followed], z)
    assert kept.simulated


def test_all_samples_begin_with_the_filter_that_the_part_led_to(monkeypatch):
    simulated, followed = seen_otherwise(rubbing(24.0))
    found_there = LowPass(0.8, 6)

    def turned(h, found, steps, enough):
        seen = None if h.problem.low_pass is None else found_there
        there = replace(h, problem=replace(h.problem, low_pass=seen))
        return there, replace(found, log_evidence=0.0)  # the part rules out neither

    monkeypatch.setattr(explanation, "again", turned)
    begun = within_reach([simulated, followed], start_of(simulated))
    assert all(h.problem.samples == simulated.problem.samples for h, _ in begun)
    assert found_there in {h.problem.low_pass for h, _ in begun} <= {found_there, None}
    for h, z in begun:
        assert likeliest(h, [z])[0] > likeliest(h, [start_of(h)])[0]


@pytest.mark.parametrize(
    ("first", "filtered", "known"),
    [
        ("rubs", LowPass(0.8, 6), True),
        ("rubs", None, True),  # laws follow the motion
        ("rubs", LINEAR_PHASE, False),  # nothing was found of it yet
        ("smooth", LowPass(0.8, 6), False),  # what is smooth tells nothing of it
    ],
)
def test_the_analyser_is_known_once_a_law_was_found_that_shows_its_filter(first, filtered, known):
    alone = rubbing(8.0)
    assert not analyser_known(replace(alone, problem=replace(alone.problem, low_pass=filtered)))
    rubs, smooth = alone.mechanisms[0], CubicStiffness("storey2", 1e5)
    both = (rubs, smooth) if first == "rubs" else (smooth, rubs)
    h = replace(alone, mechanisms=both, problem=replace(alone.problem, low_pass=filtered))
    assert analyser_known(h) is known


def test_behind_a_filter_that_was_found_no_other_is_asked_for():
    rubs, wrong = rubbing(4.0), LowPass(0.4, 2)
    problem = replace(rubs.problem, low_pass=wrong)
    mechanisms = (*rubs.mechanisms, CubicStiffness("storey2", 1e5))
    h = Hypothesis(problem, mechanisms, tuple(priors_of([m]) for m in mechanisms), rubs.scales)
    blank = Hypothesis(problem)
    found = explained(h, start_of(h), 3.0, Explanation(blank, fit(blank), -np.inf))
    assert found.hypothesis.problem.low_pass in (wrong, None)


def test_one_alone_is_never_ruled_out():
    option, _ = seen_otherwise(rubbing(24.0))
    ((kept, _),) = within_reach([option], start_of(option))
    assert kept is option


def test_a_force_that_nobody_measured_is_fitted_with_edges_and_without():
    force = UnmeasuredForce("floor1", 0.1, 2.0, 1.0)
    rubs = rubbing(8.0)
    both = in_every_form(replace(rubs, mechanisms=(force,)))
    assert [h.mechanisms[-1].edged for h in both] == [0.0, 1.0]
    assert all(h.mechanisms[-1].values == force.values for h in both)
    assert [h.mechanisms for h in in_every_form(rubs)] == [rubs.mechanisms]


def test_a_fit_from_whose_end_laws_run_away_is_left_as_it_was():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    blank = Hypothesis(problem)
    sound = Explanation(blank, fit(blank), 0.0)
    assert converged(sound).fit.log_evidence >= sound.fit.log_evidence
    gone = replace(sound.fit, z=np.full(len(blank.unknowns), np.nan))
    assert converged(replace(sound, fit=gone)).fit is gone


@pytest.mark.parametrize(("thought", "most"), [(60.0, 0.0), (120.0, 20.0)])
def test_what_is_told_is_the_likeliest_of_all_as_likely_as_its_fit_ends(thought, most):
    """A fit that went on may be less likely than it was thought, and than what it came from."""
    law = CubicStiffness("storey2", 1e5)
    train, test = ([recorded(lumped(), seed, seconds=4.0)] for seed in (1, 2))
    bare = Hypothesis(prepare(lumped(), train, test).train)
    scales = Scales({"storey2": (1.0, 1e-3, 0.05)})
    more = Hypothesis(bare.problem, (law,), (priors_of([law]),), scales)
    alone, beside = (fit(h, start_of(h)) for h in (bare, more))
    first = Explanation(bare, alone, 0.0)
    overrated = replace(beside, log_evidence=beside.log_evidence + 100.0)
    chosen = Explanation(more, overrated, thought)
    tried = {first.labels: first, chosen.labels: chosen}
    best = settled(chosen, tried)
    assert best.log_odds == pytest.approx(most, abs=1.0)
    assert best.labels == (() if thought < 100.0 else chosen.labels)
    assert best.log_odds == max(e.log_odds for e in tried.values())
