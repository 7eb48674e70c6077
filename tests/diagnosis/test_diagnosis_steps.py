"""Single steps of a diagnosis: a start from nothing, what inputs do, where a force enters."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import RATE, TWO, error, exact_trial, lumped, recorded, rng

from twin import mechanisms
from twin.diagnosis.adjusting import with_between, with_noise
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.detection import detect
from twin.diagnosis.filtering import recursion
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.locating import locate
from twin.diagnosis.motion import motion_of
from twin.diagnosis.plant import build, sampled
from twin.diagnosis.predict import ahead, from_rest, noise_floors, nrmse
from twin.diagnosis.prepare import prepare
from twin.diagnosis.refining import refined
from twin.diagnosis.scene import Scene
from twin.diagnosis.start import identified
from twin.errors import RecordingError
from twin.second_order import SecondOrderModel

ALL = mechanisms.vocabulary()
WEAK = SecondOrderModel(TWO.M / 5, TWO.R * 5, TWO.K / 5, TWO.coordinates)
INPUTS, OUTPUTS = ("force_floor1", "force_floor2"), ("acc_floor1", "acc_floor2")


def latent(place, seed=0, noise=2e-3, samples=1536):
    """A trial that a force which nobody measured pushes at one place."""
    trial = exact_trial(seed=seed, noise=noise, samples=samples)
    plant = sampled(build(TWO, (), (f"law_0_{place}",), OUTPUTS), 1 / RATE, held=True)
    u = 0.3 * rng(77 + seed).standard_normal((samples, 1))
    x = recursion(plant.A, u @ plant.B0.T)
    y = trial.y + x @ plant.plant.C.T + u @ plant.plant.D.T
    return replace(trial, y=y)


def bench_of(*trials, between="linear", model=TWO):
    return Bench(model, trials, between=between)


def edited(model, hypothesis):
    for mechanism in hypothesis.mechanisms:
        model = mechanism.edit(model)
    return model


def test_numbers_five_times_off_are_found_from_spectra_alone():
    trial = exact_trial(noise=1e-3, samples=2048, start=[1e-3, 0, 0, 0])
    bench = bench_of(trial, model=WEAK)
    found = edited(WEAK, identified(bench, base_hypothesis(WEAK)))
    for name, allowed in (("M", 0.03), ("K", 0.03), ("R", 0.3)):
        true = getattr(TWO, name)
        assert np.abs(getattr(found, name) - true).max() < allowed * true.max(), name
    assert np.abs(WEAK.K - TWO.K).max() > 0.7 * TWO.K.max()


def test_the_gentlest_recording_is_the_one_that_is_read():
    loud = exact_trial((ALL["stiffness"]("storey1", 500.0),), noise=1e-3, samples=2048, seed=1)
    loud = replace(loud, u=10 * loud.u, y=10 * loud.y)
    bench = bench_of(loud, exact_trial(noise=1e-3, samples=2048))
    found = edited(TWO, identified(bench, base_hypothesis(TWO)))
    assert np.abs(found.K - TWO.K).max() < 0.03 * TWO.K.max()


def test_a_floor_that_is_not_measured_is_named():
    trial = exact_trial()
    trial = replace(trial, outputs=OUTPUTS[:1], y=trial.y[:, :1], output_noise=[1e-3])
    with pytest.raises(RecordingError, match=r"floor2 is not measured.*there are acc_floor1"):
        identified(bench_of(trial), base_hypothesis(TWO))


def held_trial(seed, noise=1e-3, samples=1024):
    trial = exact_trial(seed=seed, samples=samples)
    u = rng(seed).standard_normal((samples, 2))
    plant = sampled(build(TWO, (), INPUTS, OUTPUTS), 1 / RATE, held=True)
    x = recursion(plant.A, u @ plant.B0.T)
    y = x @ plant.plant.C.T + u @ plant.plant.D.T + noise * rng(9).standard_normal((samples, 2))
    return replace(trial, u=u, y=y, output_noise=np.full(2, noise))


@pytest.mark.parametrize("given", ["linear", "band_limited"])
def test_a_force_that_was_held_between_samples_is_found_out(given):
    bench = bench_of(held_trial(1), held_trial(2), between=given)
    before = refined(bench, [base_hypothesis(TWO)], 3e-3, rounds=2)
    chosen, after = with_between(bench, before)
    assert chosen.between == "held"
    assert after.log_posterior > before.log_posterior + 100
    assert nrmse(chosen.trials, from_rest(chosen, after.hypothesis, after.slack)) < 5e-3


def test_what_inputs_do_stays_where_the_data_cannot_tell():
    bench = bench_of(exact_trial(noise=0.3), between="band_limited")
    fitted = refined(bench, [base_hypothesis(TWO)], 3e-3, rounds=2)
    assert with_between(bench, fitted)[0] is bench


def test_noise_that_was_told_too_small_is_put_right():
    trial = exact_trial(noise=0.02, samples=1024)
    shaken = replace(trial, u=trial.u + 0.05 * rng(4).standard_normal(trial.u.shape))
    told = replace(shaken, input_noise=np.full(2, 0.5), output_noise=np.full(2, 0.02))
    bench = bench_of(told)
    before = refined(bench, [base_hypothesis(TWO)], 1e-5, rounds=1)
    chosen, after = with_noise(bench, before)
    assert chosen.trials[0].input_noise[0] == pytest.approx(0.05)
    assert chosen.trials[0].output_noise[0] == pytest.approx(0.02)
    assert after.log_likelihood > before.log_likelihood + 15


def test_noise_read_too_high_in_one_output_is_scaled_there_alone():
    # steps of a motor's torque look like noise on the floor that it hangs from
    sound = exact_trial(noise=0.02)
    shaken = replace(sound, u=sound.u + 0.05 * rng(3).standard_normal(sound.u.shape))
    told = replace(shaken, input_noise=np.full(2, 0.05), output_noise=np.array([0.02, 0.2]))
    bench = bench_of(told)
    before = refined(bench, [base_hypothesis(TWO)], 1e-5, rounds=1)
    chosen, after = with_noise(bench, before)
    np.testing.assert_allclose(chosen.trials[0].output_noise, 0.02)
    np.testing.assert_allclose(chosen.trials[0].input_noise, 0.05)
    assert after.log_likelihood > before.log_likelihood + 15


def test_one_output_s_noise_is_not_put_right_for_what_the_model_lacks():
    sound = exact_trial(noise=0.02)
    u = sound.u + 0.05 * rng(3).standard_normal(sound.u.shape)
    late = np.column_stack([sound.y[:, 0], np.roll(sound.y[:, 1], 1)])
    told = {"input_noise": np.full(2, 0.05), "output_noise": np.full(2, 0.02)}
    bench = bench_of(replace(sound, u=u, y=late, **told))
    fitted = refined(bench, [base_hypothesis(TWO)], 1e-2, rounds=2)
    noise = with_noise(bench, fitted)[0].trials[0].output_noise
    assert noise[0] == pytest.approx(noise[1])


def scene_of(bench, slack=1e-4):
    fitted = refined(bench, [base_hypothesis(TWO, 1e-3, 1e-2)], slack, rounds=2)
    moved, known, plain = motion_of(bench, fitted)
    return Scene(known, plain, tuple(moved), {"storey1": 0.3, "storey2": 0.3})


@pytest.mark.parametrize("place", ["storey1", "storey2"])
def test_a_latent_force_is_located_where_it_enters(place):
    where = locate(scene_of(bench_of(latent(place), latent(place, 1))))
    assert set(where) == {"storey1", "storey2", "floor1", "floor2"}
    assert where[place] > 1000
    # between the ground and the first floor a storey's force is that floor's
    others = {
        p: g for p, g in where.items() if p not in (place, place.replace("storey1", "floor1"))
    }
    assert max(others.values()) < where[place] - 100


def test_where_nothing_is_missing_no_latent_force_gains_much():
    where = locate(scene_of(bench_of(exact_trial(noise=0.02), exact_trial(noise=0.02, seed=1))))
    assert max(where.values()) < 10


def test_errors_of_a_right_model_are_white_and_of_a_wrong_one_are_not():
    base = base_hypothesis(TWO, 1e-4, 1e-3)
    right = bench_of(exact_trial(noise=0.02, samples=1536))
    found = detect(right, refined(right, [base], 1e-4, rounds=1))
    assert [d.channel for d in found] == list(OUTPUTS)
    assert all(d.p_value > 1e-3 for d in found)
    assert all(0.9 < d.excess < 1.1 for d in found)
    assert all(np.isnan(d.born_s[0]) for d in found)
    soft = bench_of(exact_trial((ALL["stiffness"]("storey1", -150.0),), noise=0.02, samples=1536))
    missed = detect(soft, refined(soft, [base], 1e-4, rounds=1))
    assert all(d.p_value < 1e-9 for d in missed)
    assert all(d.excess > 1.5 for d in missed)
    assert all(d.born_s[0] < 3.0 for d in missed)


NOISE = 5e-3


@pytest.fixture(scope="module")
def consistent():
    """A rig that is as its model says, and its noise level."""
    train = [recorded(lumped(), s, noise=NOISE) for s in (1, 2)]
    ready = prepare(lumped(), train, [recorded(lumped(), 3, noise=NOISE)])
    level = NOISE / np.sqrt(np.mean([t.y**2 for t in ready.train.trials]))
    return ready, level


def test_a_consistent_rig_is_foreseen_down_to_its_noise(consistent):
    ready, level = consistent
    nothing = Hypothesis((), ())
    bench = ready.train
    assert nrmse(bench.trials, from_rest(bench, nothing, 1e-4)) == pytest.approx(level, rel=0.15)
    assert nrmse(bench.trials, ahead(bench, nothing, 1e-4)) == pytest.approx(level, rel=0.3)
    free, near = noise_floors(bench, nothing, 1e-4)
    assert free == pytest.approx(level, rel=0.15)
    assert near == pytest.approx(level, rel=0.3)


def test_a_wrong_model_is_not_foreseen_but_comes_back_in_every_window(consistent):
    ready, level = consistent
    wrong = Hypothesis((), (), (ALL["stiffness"]("storey1", 40.0),))
    free = nrmse(ready.train.trials, from_rest(ready.train, wrong, 3e-2))
    near = nrmse(ready.train.trials, ahead(ready.train, wrong, 3e-2))
    assert free > 10 * level
    assert near < 0.6 * free


def test_the_floor_grows_with_the_noise_of_the_force(consistent):
    ready, _ = consistent
    shaken = [replace(t, input_noise=t.input_noise + 0.05) for t in ready.train.trials]
    loud = noise_floors(replace(ready.train, trials=tuple(shaken)), Hypothesis((), ()), 1e-4)
    quiet = noise_floors(ready.train, Hypothesis((), ()), 1e-4)
    assert loud[0] > 1.5 * quiet[0]


def test_what_a_faulty_instrument_records_is_foreseen(consistent):
    ready, _ = consistent
    for fault in (
        ALL["sensor_gain"]("acc_floor2", 1.2), ALL["sensor_polarity"]("acc_floor1"),
        ALL["sensor_swap"]("acc_floor1+acc_floor2"),
    ):  # fmt: skip
        trials = tuple(t.with_columns(fault.distort(t.columns, RATE)) for t in ready.train.trials)
        bench = replace(ready.train, trials=trials)
        blind = nrmse(trials, from_rest(bench, Hypothesis((), ()), 1e-3))
        seen = nrmse(trials, from_rest(bench, Hypothesis((), (), (fault,)), 1e-3))
        assert seen < 0.05 < blind, fault.name


def test_smoothed_states_are_the_motion():
    trial = exact_trial(noise=0.02)
    bench = bench_of(trial)
    scene = scene_of(bench)
    plant = bench.plant(trial, ())
    after = np.vstack([trial.u[1:], trial.u[-1:]])
    true = recursion(plant.A, trial.u @ plant.B0.T + after @ plant.B1.T)
    assert error(scene.moved[0][:, :2], true[:, :2]) < 0.01
    motion = scene.motion()
    assert error(motion["storey2"], true[:, 1] - true[:, 0]) < 0.02
    assert error(motion["rate floor1"], true[:, 2]) < 0.02
