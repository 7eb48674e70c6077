"""A narrow unmeasured force: its place is found from the band that it has."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import RATE, TWO, exact_trial, rng
from scipy.signal import butter, sosfilt

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.filtering import recursion
from twin.diagnosis.heard import alike, best_of_each, elsewhere, even_odds
from twin.diagnosis.judging import felt_alike
from twin.diagnosis.plant import build, sampled
from twin.diagnosis.refining import refined
from twin.diagnosis.result import Finding

Force = mechanisms.vocabulary()["unmeasured_force"]
CUBIC = mechanisms.vocabulary()["cubic_stiffness"]
OUTPUTS = ("acc_floor1", "acc_floor2")
BAND_HZ = (2.0, 2.4)


def pushed(place, seed, samples=3072):
    """A trial that a band of noise pushes at a place; nobody measured it."""
    trial = exact_trial(seed=seed, noise=2e-3, samples=samples)
    plant = sampled(build(TWO, (), (f"force_{place}",), OUTPUTS), 1 / RATE)
    sections = butter(8, BAND_HZ, btype="bandpass", fs=RATE, output="sos")
    u = sosfilt(sections, 3.0 * rng(70 + seed).standard_normal((samples, 1)), axis=0)
    after = np.concatenate([u[1:], u[-1:]])
    x = recursion(plant.A, u @ plant.B0.T + after @ plant.B1.T)
    return replace(trial, y=trial.y + x @ plant.plant.C.T + u @ plant.plant.D.T)


@pytest.fixture(scope="module")
def bench():
    return Bench(TWO, (pushed("floor2", 1), pushed("floor2", 2)), between="linear")


def fitted(bench, force):
    return refined(bench, [base_hypothesis(TWO).including(force)], 1e-4, rounds=3)


def test_a_force_that_was_looked_for_at_the_wrong_place_is_found_at_its_own(bench):
    wrong = fitted(bench, Force("floor1", 0.3, 2.2, 0.1))
    fits = best_of_each([wrong, *elsewhere(bench, wrong)])
    assert fits[0].hypothesis.labels == (("unmeasured_force", "floor2"),)
    assert fits[0].bic < wrong.bic - 100
    labels = [fit.hypothesis.labels for fit in fits]
    assert len(labels) == len(set(labels)) == 3


def test_a_band_with_edges_is_likelier_than_an_oscillator_s(bench):
    right = fitted(bench, Force("floor2", 0.3, 2.2, 0.1))
    best = best_of_each([right, *elsewhere(bench, right)])[0]
    found = best.hypothesis.found[-1]
    assert found.edged == 1.0
    assert found.frequency - found.bandwidth / 2 == pytest.approx(BAND_HZ[0], abs=0.1)
    assert found.frequency + found.bandwidth / 2 == pytest.approx(BAND_HZ[1], abs=0.1)


def test_a_broad_force_is_left_where_it_was_found(bench):
    broad = base_hypothesis(TWO).including(Force("floor2", 0.3, 2.2, 3.0))
    found = replace(refined(bench, [broad], 1e-4, rounds=0), hypothesis=broad)
    assert elsewhere(bench, found) == []


def at(bench, place, *before):
    base = base_hypothesis(TWO).including(*before, Force(place, 0.3, 2.2, 0.1))
    return refined(bench, [base], 1e-4, rounds=0)


def test_a_force_on_the_lowest_floor_and_a_shaken_ground_are_the_same_to_sensors_above(bench):
    fits = [at(bench, place) for place in ("floor1", "floor2", "ground")]
    assert alike(bench, fits[0], fits[2])
    assert not alike(bench, fits[0], fits[1])
    assert even_odds(bench, fits, [0.9, 0.08, 0.02]) == pytest.approx([0.46, 0.08, 0.46])


def test_dashpots_to_the_rest_frame_do_not_tell_them_apart_either(bench):
    # whether they move with the ground is an assumption of the model, not a finding
    airy = replace(TWO, R=TWO.R + np.diag([0.5, 4.0]))
    other = replace(bench, model=airy)
    assert alike(other, at(bench, "floor1"), at(bench, "ground"))
    assert not alike(other, at(bench, "floor1"), at(bench, "floor2"))


def test_one_sensor_does_not_tell_where_an_unmeasured_force_acts(bench):
    one = [replace(t, outputs=t.outputs[1:], y=t.y[:, 1:], output_noise=[2e-3])
           for t in bench.trials]  # fmt: skip
    lone = replace(bench, trials=tuple(one))
    assert alike(lone, at(lone, "floor1"), at(lone, "floor2"))


def test_other_mechanisms_keep_their_odds(bench):
    plain = refined(bench, [base_hypothesis(TWO).including(CUBIC("storey1", 5.0))], 1e-4, rounds=0)
    fits = [plain, at(bench, "floor1"), at(bench, "ground")]
    assert even_odds(bench, fits, [0.9, 0.08, 0.02]) == [0.9, 0.08, 0.02]


def test_places_that_are_felt_alike_are_said_together():
    first = Finding(Force("floor1", 0.3, 2.2, 0.1), {}, 0.46)
    others = (Finding(Force("ground", 0.3, 2.2, 0.1), {}, 0.46, 3.0),
              Finding(Force("floor2", 0.3, 2.2, 0.1), {}, 0.08, 9.0))  # fmt: skip
    assert felt_alike((first,), others) == (
        "unmeasured_force: the sensors feel floor1 and ground alike; one more accelerometer tells",
    )
    assert felt_alike((first,), others[1:]) == ()
    spring = Finding(CUBIC("storey1", 5.0), {}, 0.46)
    assert felt_alike((spring,), others) == ()
