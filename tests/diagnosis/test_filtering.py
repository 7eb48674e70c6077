"""The analyser's filter is found in what it makes of a law's jumps."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from beam_support import problem_of, random_force
from diagnosis_support import RATE, lumped, recorded, rng
from scipy.signal import butter, firwin, sosfilt

from twin.diagnosis.beginning import as_sharp, start_of
from twin.diagnosis.candidates import priors_of
from twin.diagnosis.filtering import COARSE, EDGES, ORDERS, likeliest_filter
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.estimation.low_pass import LowPass
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.stiffness_drift import StiffnessDrift
from twin.recording import Recording

EDGE, ORDER, TIMES = 0.74, 5, 16
"""Of the filter, none of which the search begins with, and how much faster it is simulated."""


def seen_through(analyser, law, rate, seconds, highest, seed):
    """A recording of a frame with a law, all channels behind an analyser's filter.

    Args:
        analyser: what it makes of a channel that is sampled ``TIMES`` as fast.
        law: what the frame has.
        rate: at which it samples [Hz].
        seconds: of the recording.
        highest: frequency of the force [Hz].
        seed: of force and noise.
    """
    samples = round(seconds * rate)
    t = np.arange(samples * TIMES) / (rate * TIMES)
    draw = rng(seed)
    f = np.linspace(0.3, highest, 160)
    phase = draw.uniform(0, 2 * np.pi, len(f))
    force = 0.3 * np.sqrt(2 / len(f)) * np.cos(2 * np.pi * f * t[:, None] + phase).sum(axis=1)
    force *= 1 - np.exp(-t / 0.2)
    twin = lumped().including(law)
    moved = twin.simulate({"force_floor2": force}, rate * TIMES, len(force)).columns
    columns = {"force_floor2": force} | {f"acc_{floor}": moved[f"acc_{floor}"]
                                         for floor in twin.floors}  # fmt: skip
    seen = {name: analyser(x)[::TIMES] for name, x in columns.items()}
    noisy = {name: x + 2e-3 * draw.standard_normal(samples) * name.startswith("acc")
             for name, x in seen.items()}  # fmt: skip
    return Recording.build(rate, noisy, f"seed{seed}.csv")


def filtered(seed):
    """A recording of a frame that rubs, behind Butterworth's filter."""
    sections = butter(ORDER, EDGE / 2 * RATE, fs=RATE * TIMES, output="sos")
    law = CoulombFriction("storey2", 0.1)
    return seen_through(partial(sosfilt, sections), law, RATE, 10.0, 12.0, seed)


@pytest.fixture(scope="module")
def rubbing():
    law = CoulombFriction("storey2", 0.1, 1e-3)
    problem = prepare(lumped(), [filtered(1)], [filtered(2)]).train
    return Hypothesis(problem, (law,), (priors_of([law]),), Scales({"storey2": (1.0, 1e-3, 0.05)}))


def test_edge_and_order_are_found_between_those_that_the_search_begins_with(rubbing):
    assert rubbing.problem.low_pass == LowPass(1.0)
    found = fit(rubbing, as_sharp(rubbing, start_of(rubbing)), most=12)
    here = rubbing
    for _ in range(2):
        low_pass = likeliest_filter(here, found)
        here = replace(rubbing, problem=replace(rubbing.problem, low_pass=low_pass))
        found = fit(here, found.z, most=12, near=found.averages)
    assert low_pass.order in (ORDER - 1, ORDER, ORDER + 1)
    assert low_pass.cut_off == pytest.approx(EDGE, abs=COARSE)
    true = replace(rubbing, problem=replace(rubbing.problem, low_pass=LowPass(EDGE, ORDER)))
    same = evaluate(true, found.z, False, found.averages).log_likelihood
    assert found.log_likelihood > same - 3


def test_filters_stay_those_that_analysers_have(rubbing):
    found = fit(rubbing, as_sharp(rubbing, start_of(rubbing)), most=2)
    for extreme in (LowPass(EDGES[1]), LowPass(EDGES[0], ORDERS[0]), LowPass(1.0, ORDERS[-1])):
        here = replace(rubbing, problem=replace(rubbing.problem, low_pass=extreme))
        low_pass = likeliest_filter(here, found)
        assert EDGES[0] <= low_pass.cut_off <= EDGES[1]
        assert low_pass.order in (0, *ORDERS)


SLOW = 24.0
"""Sampling rate at which a cubic spring's third harmonics of the second mode are folded [Hz]."""


def sprung(strength, seed):
    """A slow recording of a frame with a cubic spring, behind a filter of linear phase."""
    taps = firwin(128 * TIMES + 1, SLOW / 2, fs=SLOW * TIMES)
    law = CubicStiffness("storey2", strength)
    return seen_through(lambda x: np.convolve(x, taps, "same"), law, SLOW, 40.0, 9.0, seed)


def test_harmonics_that_an_analyser_takes_are_not_folded():
    law = CubicStiffness("storey2", 1e6)
    problem = prepare(lumped(), [sprung(law.stiffness, 1)], [sprung(law.stiffness, 2)]).train
    scales = Scales({"storey2": (1.0, 1e-3, 0.05)})
    through = Hypothesis(problem, (law,), (priors_of([law]),), scales)
    folded = replace(through, problem=replace(problem, low_pass=None))
    assert (through.simulated, folded.simulated) == (True, False)
    assert not replace(through, problem=replace(problem, tolerance=1.0)).simulated, "not known"
    fits = [fit(h, start_of(h), most=8) for h in (through, folded)]
    assert fits[0].log_evidence > fits[1].log_evidence + 100
    values = {u.name: u.value(z) for u, z in zip(through.unknowns, fits[0].z, strict=True)}
    assert values["cubic_stiffness storey2 stiffness"] == pytest.approx(1e6, rel=0.01)


def test_a_law_that_leans_on_modes_above_half_the_rate_is_simulated_with_them():
    beam = problem_of(random_force(60.0, 1), random_force(60.0, 2)[:, [0, 0]], 0.01)
    problem = replace(beam, low_pass=LowPass(1.0))
    law = StiffnessDrift("hinge3", 0.01, 20.0)
    h = Hypothesis(problem, (law,), (priors_of([law]),))
    assert problem.rings
    assert not problem.folds(law.harmonics)
    assert h.simulated
    assert not Hypothesis(problem).simulated, "nothing leans on them"


def test_harmonics_below_half_the_rate_need_no_simulation():
    law = CubicStiffness("storey2", 4e7)
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    assert not Hypothesis(problem, (law,), (priors_of([law]),)).simulated
    assert problem.folds(12)
    assert not problem.folds(3)
