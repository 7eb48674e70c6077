"""Candidates as they are screened, and what is chosen by trying, on small rigs."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import RATE, TWO, concealed, exact_trial, lumped, rng

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis, bent, surroundings
from twin.diagnosis.bench import Bench
from twin.diagnosis.estimator import foreseeing
from twin.diagnosis.fitting import fit
from twin.diagnosis.motion import motion_of
from twin.diagnosis.prepare import prepare
from twin.diagnosis.refining import refined, with_slack, with_widths
from twin.diagnosis.scene import Scene
from twin.diagnosis.screen import screen
from twin.diagnosis.stage import next_stage
from twin.diagnosis.unnamed import foresees_off

ALL = mechanisms.vocabulary()
HEIGHTS = {"storey1": 0.3, "storey2": 0.3}
BASE = ALL["base_compliance"]("ground", 9000.0, 4.0, 3.0, 3.0)
FORCE, BLUR = 0.05, 1e-4


def scene_of(bench, nothing):
    moved, known, plain = motion_of(bench, nothing)
    return Scene(known, with_slack(known, plain), tuple(moved), HEIGHTS)


@pytest.fixture(scope="module")
def on_a_base():
    """A frame on a base that gives way and resonates, and what calibrating makes of it."""
    trials = [exact_trial((BASE,), noise=2e-3, samples=1536, seed=s) for s in (0, 1)]
    bench = Bench(TWO, tuple(trials), between="linear", ground_mass=3.0)
    return bench, refined(bench, [base_hypothesis(TWO)], 3e-3)


def test_a_base_is_tried_at_what_resonates(on_a_base):
    scene = scene_of(*on_a_base)
    around = surroundings(scene.bench, scene.motion(), HEIGHTS, "ground", (8.0,))
    start = type(BASE).starts("ground", around)[0]
    resonance = np.sqrt((start.stiffness + around.stiffness) / start.mass) / (2 * np.pi)
    assert resonance == pytest.approx(8.0)


def test_recordings_of_any_length_are_screened_together():
    trials = tuple(
        exact_trial((BASE,), noise=2e-3, samples=samples, seed=seed)
        for seed, samples in enumerate((1536, 2560))
    )
    bench = Bench(TWO, trials, between="linear", ground_mass=3.0)
    nothing = fit(bench, base_hypothesis(TWO), 3e-3)
    peaks = Scene(bench, nothing, (), HEIGHTS).peaks()
    alone = Scene(Bench(TWO, trials[:1], between="linear", ground_mass=3.0), nothing, (), HEIGHTS)
    assert peaks[0] == pytest.approx(alone.peaks()[0], abs=RATE / 1536)


def test_a_base_is_found_though_calibrating_bent_the_first_storey_for_it(on_a_base):
    bench, nothing = on_a_base
    assert bent(nothing.hypothesis), "the test shows something"
    found = {c.label[0]: c for c in screen(scene_of(bench, nothing))}
    assert found["base_compliance"].mechanism.stiffness == pytest.approx(9000.0, rel=0.03)
    best = max(c.gain for c in found.values())
    assert found["base_compliance"].gain > 0.9 * best


def test_a_stiff_base_that_is_well_damped_is_not_taken_for_an_appendage():
    base = ALL["base_compliance"]("ground", 33000.0, 63.0, 3.0, 3.0)
    trials = [exact_trial((base,), noise=1e-3, samples=3072, seed=s) for s in (0, 1)]
    bench = Bench(TWO, tuple(trials), between="linear", ground_mass=3.0)
    nothing = refined(bench, [base_hypothesis(TWO)], 3e-3)
    gains = {c.label: c.gain for c in screen(scene_of(bench, nothing))}
    assert gains["base_compliance", "ground"] > 1.1 * gains["appendage", "floor1"]
    assert gains["base_compliance", "ground"] == max(gains.values())


@pytest.fixture(scope="module")
def rubbing():
    """Dry friction in storey 1 and nothing else."""

    def law(drift, rate):
        return FORCE * np.tanh(rate / 2e-4)

    train = [concealed(law, np.array([1.0, 0.0]), seed) for seed in (1, 2)]
    return prepare(lumped(), train, [concealed(law, np.array([1.0, 0.0]), 3)]).train


def test_what_blurs_friction_is_found_by_trying(rubbing):
    base = base_hypothesis(rubbing.model)
    friction = ALL["coulomb_friction"]("storey1", FORCE, 100 * BLUR)
    blurred = fit(rubbing, base.including(friction), 1e-3, iterations=1)
    sharper = with_widths(rubbing, blurred)
    assert sharper.hypothesis.found[0].regular_rate < 10 * BLUR
    assert sharper.log_likelihood > blurred.log_likelihood + 100


def test_beside_a_law_nothing_is_promised_that_the_base_alone_would_gain(rubbing):
    friction = ALL["coulomb_friction"]("storey1", FORCE, BLUR)
    found = refined(rubbing, [base_hypothesis(rubbing.model).including(friction)], 1e-3)
    stage = next_stage(rubbing, found, HEIGHTS, lambda message: None)
    promised = [c.gain for c in stage.candidates]
    assert np.median(promised or [0.0]) < 0.01 * rubbing.samples


def test_broad_noise_is_not_foreseen_a_sinusoid_is():
    force = ALL["unmeasured_force"]
    t = np.arange(1536) / RATE
    line = exact_trial(noise=2e-3, samples=1536)
    swing = 0.2 * np.sin(2 * np.pi * 3.3 * t)
    hidden = replace(line, u=line.u - np.column_stack([np.zeros(1536), swing]))
    noise = 0.2 * rng(5).standard_normal(1536)
    rough = replace(line, u=line.u - np.column_stack([np.zeros(1536), noise]))
    for trial, mechanism, foreseen in (
        (hidden, force("floor2", 0.15, 3.3, 1e-3), True),
        (rough, force("floor2", 0.2, 4.0, 30.0), False),
    ):
        bench = Bench(TWO, (trial,), between="linear")
        nothing = refined(bench, [base_hypothesis(TWO)], 3e-3, rounds=2)
        best = refined(bench, [nothing.hypothesis.including(mechanism)], 3e-3, rounds=2)
        estimator = foreseeing(bench, best, nothing)
        hypothesis, slack = estimator.hypothesis, estimator.slack
        assert bool(hypothesis.found) == foreseen
        chosen = replace(best, hypothesis=hypothesis, slack=slack, starts=())
        assert foresees_off(bench, chosen) <= foresees_off(bench, replace(best, starts=()))
