"""What straight lines between samples do to modes above half the sampling rate."""

from dataclasses import replace

import numpy as np
import pytest
from beam_support import INPUTS, OUTPUTS, RATE, SAMPLES, answer, problem_of, random_force
from diagnosis_support import lumped, rng
from scipy.signal import cont2discrete, dlsim

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.measured import Measured
from twin.diagnosis.mending import read_as_lines
from twin.diagnosis.plant import plant_of
from twin.diagnosis.predict import nrmse, predictors
from twin.diagnosis.prepare import prepare
from twin.diagnosis.problem import LINEAR_PHASE, Problem
from twin.diagnosis.straight import (
    above,
    calmed,
    hold_error,
    noise_gain,
    prefiltered,
    read_error,
)
from twin.diagnosis.trials import trial_of
from twin.estimation.fit import fit
from twin.estimation.likelihood import passes
from twin.estimation.system import sampled
from twin.laboratory import Analyser, Experiment, RandomShaking, run
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.sensor_crosstalk import SensorCrosstalk
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.sensor_resonance import SensorResonance
from twin.mechanisms.stiffness import Stiffness
from twin.mechanisms.unmeasured_force import UnmeasuredForce
from twin.model import Twin


@pytest.mark.parametrize("off", [0.0, 0.02])
def test_a_beam_whose_upper_modes_are_fast_is_predicted_to_a_thousandth(off):
    u = random_force(50.0, 1)
    model = Twin.load("cantilever").linear(INPUTS, OUTPUTS)
    assert np.sum(above(model, 1 / RATE)) == 6
    true = replace(model, K=(1 + off) * model.K)
    y = answer(true, u)
    problem = problem_of(u, y, 1e-3 * float(np.sqrt(np.mean(y**2))))
    own = replace(problem, model=true)
    trial = trial_of(problem, problem.recordings[0])
    # the twin's own upper modes are off, too; what the lines miss is taken from the nominal ones
    taken = trial_of(own, own.recordings[0]).y - trial.y
    change = np.nanstd(taken, axis=0) / np.std(y, axis=0)
    assert np.max(change) < (1e-9 if off == 0 else 2e-3)
    hypothesis = Hypothesis(own)
    quiet = np.array([-3.0 if u.name.startswith("process") else 0.0 for u in hypothesis.unknowns])
    (run,) = passes(hypothesis, quiet)
    late = slice(SAMPLES // 2, SAMPLES - 20)
    left = np.sqrt(np.mean(run.e[late] ** 2, axis=0)) / np.std(y, axis=0)
    assert np.max(left) < 2e-3


def test_a_dashpot_that_couples_modes_above_the_band_with_those_in_it_is_predicted_too():
    model = Damping("hinge3", 0.05).edit(Twin.load("cantilever").linear(INPUTS, OUTPUTS))
    shares = np.abs(model.R) / np.sqrt(np.outer(np.diag(model.R), np.diag(model.R)))
    assert np.max(shares - np.diag(np.diag(shares))) > 0.9, "the modes are coupled"
    u = random_force(50.0, 1)
    y = answer(model, u)
    hypothesis = Hypothesis(replace(problem_of(u, y, 1e-3 * float(np.std(y))), model=model))
    quiet = np.array([-3.0 if x.name.startswith("process") else 0.0 for x in hypothesis.unknowns])
    (run,) = passes(hypothesis, quiet)
    late = slice(SAMPLES // 2, SAMPLES - 20)
    assert np.max(np.std(run.e[late], axis=0) / np.std(y, axis=0)) < 2e-3


@pytest.mark.parametrize(
    ("fault", "times"),
    [
        (SensorGain("acc_tip.x", 1.2), ((1.0, 0.0), (0.0, 1.2))),
        (SensorCrosstalk("acc_mid.x+acc_tip.x", 0.1, 0.05), ((1.0, 0.1), (0.05, 1.0))),
        (SensorGain("force_tip", 1.25), ((0.8, 0.0), (0.0, 0.8))),
    ],
)
def test_what_lines_miss_is_read_by_the_instrument_too(fault, times):
    u = random_force(50.0, 1)
    problem = problem_of(u, np.ones((SAMPLES, 2)), 1e-3)
    (plain,), (read,) = problem.trials, read_as_lines(problem, problem.trials, [fault])
    assert np.max(np.abs(plain.missed)) > 0
    wanted = plain.missed @ np.array(times).T
    assert read.missed == pytest.approx(wanted, abs=1e-9 * np.max(np.abs(wanted)))
    assert np.allclose(read.y + read.missed, plain.y + plain.missed, equal_nan=True)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.45])
def test_lines_through_raised_corners_hold_a_tone_at_any_share_of_the_rate(share):
    t, finer = np.arange(SAMPLES), 32
    raised = prefiltered(np.cos(2 * np.pi * share * t)[:, None])[:, 0]
    fine = np.arange(64 * finer, (SAMPLES - 64) * finer) / finer
    lines = np.interp(fine, t, raised)
    tone = np.exp(-2j * np.pi * share * fine)
    assert abs(2 * np.mean(lines * tone)) == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize("frequency", [60.0, 110.0, 180.0])
def test_a_sensor_that_rings_reads_lines_and_what_they_miss_as_it_reads_the_signal(frequency):
    x = random_force(120.0, 5)[:, 0]
    instrument = SensorResonance("acc_tip.x", frequency, 0.03).instrument(0.0)
    w = 2j * np.pi * np.fft.rfftfreq(SAMPLES, 1 / RATE)
    read = [(instrument.C @ np.linalg.solve(s * np.eye(2) - instrument.A, instrument.B))[0, 0]
            for s in w]  # fmt: skip
    exact = np.fft.irfft(np.fft.rfft(x) * np.array(read), SAMPLES)
    # stepped over straight lines, which are exact for it (foh)
    A, B = calmed(instrument.A, instrument.B, 1 / RATE)
    lines, *matrices = prefiltered(x[:, None])[:, 0], *cont2discrete(
        (A, B, instrument.C, instrument.D), 1 / RATE, "foh")[:4]  # fmt: skip
    stepped = dlsim((*matrices, 1 / RATE), lines)[1][:, 0]
    late = slice(SAMPLES // 2, SAMPLES - 64)
    size, missed = np.std(exact[late]), read_error(instrument, x, 1 / RATE)
    assert np.std((stepped - exact)[late]) > 0.01 * size, "the test shows something"
    assert np.std((stepped + missed - exact)[late]) < 2e-3 * size


@pytest.mark.parametrize(("frequency", "rings"), [(60.0, True), (120.0, True), (235.0, False)])
@pytest.mark.parametrize("kind", ["sensor", "force", "force with edges"])
def test_above_half_the_rate_nothing_rings_and_what_is_slow_is_as_before(kind, frequency, rings):
    if kind == "sensor":
        instrument = SensorResonance("acc_tip.x", frequency, 0.01).instrument(0.0)
        A, B, C = instrument.A, instrument.B[:, 0], instrument.C[0]
    else:
        edged = float(kind == "force with edges")
        A, B, C = UnmeasuredForce("floor1", 1.0, frequency, 2.0, edged).shaping()
    stepped, enters = calmed(A, B, 1 / RATE)
    assert (stepped is A) == rings
    before = C @ np.linalg.solve(A, B)
    assert C @ np.linalg.solve(stepped, enters) == pytest.approx(before, rel=1e-9)
    # of its ringing a thousandth is left after four samples, where it would go on for many
    left = np.abs(np.exp(np.linalg.eigvals(stepped) * 4 / RATE))
    assert np.all(left > 0.5) if rings else np.all(left < 1e-3)


@pytest.mark.parametrize("highest", [40.0, 120.0])
def test_what_a_force_has_near_half_the_sampling_rate_is_predicted_too(highest):
    model = lumped().linear(("force_floor2",), ("acc_floor1", "acc_floor2"))
    model = replace(model, R=20 * model.R)
    assert not np.any(above(model, 1 / RATE))
    u = random_force(highest, 1)
    y = answer(model, u)
    levels, scale = 1e-4 * np.std(y, axis=0), np.full((1, len(model.coordinates)), 1e-6)
    measured = Measured("a", u, y, np.array([1e-9]), levels)
    problem = Problem(model, (measured,), RATE, 0.01, 0.3, ("band_limited",), scale)
    hypothesis = Hypothesis(problem)
    quiet = np.array([-3.0 if x.name.startswith("process") else 0.0 for x in hypothesis.unknowns])
    (run,) = passes(hypothesis, quiet)
    late = slice(SAMPLES // 2, SAMPLES - 20)
    left = np.sqrt(np.mean(run.e[late] ** 2, axis=0)) / np.std(y, axis=0)
    assert np.max(left) < 2e-4
    missed = hold_error(model, 1 / RATE).of(u)[late]
    assert np.max(np.std(missed, axis=0) / np.std(y, axis=0)) > (1e-3 if highest > 100 else 1e-7)


def test_a_mode_is_calmed_gradually_as_it_comes_to_half_the_sampling_rate():
    model = lumped().linear(("force_floor2",), ("acc_floor1", "acc_floor2"))
    highest = float(np.sqrt(np.max(np.diag(model.K) / np.diag(model.M)))) / (2 * np.pi)
    damping, stirred = [], []
    for share in np.linspace(0.9, 1.05, 61):
        step_s = share / (2 * highest)
        poles = np.linalg.eigvals(plant_of(model, (), (), {}, step_s=step_s).system.A)
        fastest = poles[np.argmax(np.abs(poles))]
        damping.append(-fastest.real / abs(fastest))
        stirred.append(noise_gain(model, step_s)[-1])
    own, calmed = damping[0], damping[-1]
    assert own < 0.05
    assert calmed == pytest.approx(0.7, abs=0.01)
    assert np.max(np.abs(np.diff(damping))) < 0.06
    assert np.max(np.abs(np.diff(stirred))) < 0.12
    assert stirred[-1] == 0.0


@pytest.mark.parametrize("frequency", [60.0, 110.0])
def test_a_floor_s_acceleration_is_predicted_behind_a_sensor_that_rings(frequency):
    model = lumped().linear(("force_floor2",), ("acc_floor1", "acc_floor2"))
    model = replace(model, R=20 * model.R)
    u = random_force(120.0, 6)
    y, rings = answer(model, u), SensorResonance("acc_floor2", frequency, 0.03)
    f = np.fft.rfftfreq(SAMPLES, 1 / RATE)
    r = f / frequency
    read = (1 + 0.06j * r) / (1 - r**2 + 0.06j * r)
    y[:, 1] = np.fft.irfft(np.fft.rfft(y[:, 1]) * read, SAMPLES)
    levels, scale = 1e-4 * np.std(y, axis=0), np.full((1, len(model.coordinates)), 1e-6)
    measured = Measured("a", u, y, np.array([1e-9]), levels)
    problem = Problem(model, (measured,), RATE, 0.01, 0.3, ("band_limited",), scale)
    priors = {"frequency": (np.log(frequency), 1.0), "damping_ratio": (np.log(0.03), 1.0)}
    hypothesis = Hypothesis(problem, (rings,), (priors,))
    quiet = np.array([-3.0 if x.name.startswith("process") else 0.0 for x in hypothesis.unknowns])
    (run,) = passes(hypothesis, quiet)
    late = slice(SAMPLES // 2, SAMPLES - 64)
    left = np.sqrt(np.mean(run.e[late] ** 2, axis=0)) / np.std(y, axis=0)
    assert np.max(left) < 2e-3


def test_noise_of_a_force_is_estimated_where_it_drives_fast_modes():
    u = random_force(50.0, 2)
    y = answer(Twin.load("cantilever").linear(INPUTS, OUTPUTS), u)
    level, heard = 5e-3 * float(np.std(u)), 5e-3 * float(np.sqrt(np.mean(y**2)))
    draw = rng(3)
    noisy = u + level * draw.standard_normal(u.shape)
    problem = problem_of(noisy, y + heard * draw.standard_normal(y.shape), heard)
    measured = replace(problem.recordings[0], input_noise=np.array([level]))
    hypothesis = Hypothesis(replace(problem, recordings=(measured,)))
    free = np.array([unknown.role == "noise" for unknown in hypothesis.unknowns])
    found = fit(hypothesis, free=free)
    assert found.values["noise of force_tip in a"] == pytest.approx(level, rel=0.3)
    assert found.values["noise of acc_tip.x in a"] == pytest.approx(heard, rel=0.2)


def test_held_noise_stirs_a_mode_at_its_frequency_as_band_limited_noise_does():
    model = Twin.load("cantilever").linear(INPUTS, OUTPUTS)
    plant = plant_of(model, (), (), {}, noise_gain(model, 1 / RATE))
    steps = sampled(plant.system, 1 / RATE, 1, np.zeros(1, bool))
    n = len(model.coordinates)
    for mode in np.flatnonzero(~above(model, 1 / RATE)):
        w = np.sqrt(model.K[mode, mode] / model.M[mode, mode])
        z = np.exp(1j * w / RATE)
        held = np.linalg.solve(z * np.eye(2 * n) - steps.whole, steps.entry[:, :1])[mode, 0]
        exact = model.B[mode, 0] / (1j * w * model.R[mode, mode])
        assert abs(held) == pytest.approx(abs(exact), rel=0.03)


@pytest.mark.parametrize(
    "change", [Stiffness("hinge3", 6.0), Mass("link6", 0.01), Appendage("acc_mid", 0.002, 4.0)]
)
def test_a_changed_structure_keeps_the_damping_of_its_own_modes_in_the_band(change):
    """What keeps modes above the band from ringing does not leak into those below."""
    model = Twin.load("cantilever").linear(INPUTS, OUTPUTS)
    below, calm = np.pi * RATE, []
    for step_s in (None, 1 / RATE):
        poles = np.linalg.eigvals(plant_of(model, (change,), (), {}, step_s=step_s).system.A)
        inside = poles[(poles.imag > 0) & (abs(poles) < below)]
        fast = poles[abs(poles) > below]
        calm.append((inside[np.argsort(inside.imag)], -fast.real / abs(fast)))
    assert len(calm[1][0]) >= 3
    assert calm[1][0] == pytest.approx(calm[0][0], rel=2e-4)
    assert np.all(calm[1][1] > 0.6)
    assert np.all(calm[0][1] < 0.1)


def test_modes_above_the_band_that_a_stop_stirs_ring_in_its_simulation_as_they_do(tmp_path):
    stop = Bumper("hinge3", stiffness=110.0, gap=8.5e-4)
    struck = Twin.load("cantilever").including(stop)
    shaking = Experiment(
        RandomShaking(0.03, (0.5, 70.0)), ("force_mid", "force_tip"), Analyser(192.0, 6.0)
    )
    train, test = run(shaking, struck, 1), run(shaking, struck, 2)
    own = Twin.load(str(struck.export(tmp_path / "own.xml")))
    problem = prepare(own, [train], [test], None, 0.1, None).train

    def error(low_pass):
        of = Hypothesis(replace(problem, low_pass=low_pass))
        (beside,) = predictors(of, np.zeros(len(of.unknowns)))
        return nrmse([problem.recordings[0].y], [beside.free()])

    # the steps of the predictor damp them: the stop is struck otherwise
    assert error(None) > 0.1
    assert error(LINEAR_PHASE) < 0.02
    assert Hypothesis(problem).simulated
    assert not Hypothesis(replace(problem, tolerance=1.0)).simulated
