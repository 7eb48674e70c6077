"""A motor in the bench: its torque is held between samples, known as commanded, delivered late."""

import numpy as np
import pytest
from diagnosis_support import RATE, error, motion, rng, tones

from twin import mechanisms
from twin.diagnosis.base import surroundings
from twin.diagnosis.bench import Bench
from twin.diagnosis.channels import corrected
from twin.diagnosis.filtering import Gain
from twin.diagnosis.fitting import fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.trials import trial
from twin.second_order import SecondOrderModel

ALL = mechanisms.vocabulary()
ABSORBER = SecondOrderModel(
    [[1.5, 0.02], [0.02, 0.004]], [[1.5, 0.0], [0.0, 2e-3]], [[600.0, 0.0], [0.0, 0.2]],
    ("floor1", "pendulum"),
)  # fmt: skip
SAMPLES, LATE = 768, 3


def recording(late=0, noise=0.0):
    """Floor and pendulum under a smooth force and a torque that jumps every eighth sample."""
    force = tones(SAMPLES, seed=1, scale=0.2)
    command = np.repeat(0.02 * rng(2).standard_normal(SAMPLES // 8), 8)
    command[:8] = 0.0
    given = np.concatenate([np.zeros(late), command[: SAMPLES - late]])
    none = np.zeros(SAMPLES)
    smooth = motion(ABSORBER, np.column_stack([force, none]))
    jumps = motion(ABSORBER, np.column_stack([none, given]), held=True)
    x, _, acc = (a + b for a, b in zip(smooth, jumps, strict=True))
    floor, angle = acc[:, 0], x[:, 1]
    draw = rng(3)
    columns = {
        "force_floor1": force,
        "torque_pendulum": command,
        "acc_floor1": floor + noise * floor.std() * draw.standard_normal(SAMPLES),
        "angle_pendulum": angle + noise * angle.std() * draw.standard_normal(SAMPLES),
    }
    names = list(columns)
    return trial("run", RATE, columns, names[:2], names[2:])


def bench_of(one):
    return Bench(ABSORBER, (one,), between="linear")


def deaf(bench):
    none = np.zeros((4, 2))
    return [Gain(none, none, np.zeros((4, 4)), np.eye(2))]


def test_a_torque_is_held_and_a_force_is_a_straight_line():
    bench = bench_of(recording())
    e = bench.innovations([Hypothesis((), ())], deaf(bench))[0][0]
    assert error(bench.trials[0].y - e, bench.trials[0].y) < 1e-6
    assert bench.held.tolist() == [False, True]


def test_it_stays_held_within_a_sample_that_laws_cut_in_pieces():
    bench = bench_of(recording())
    none = Hypothesis((), (), (ALL["cubic_stiffness"]("storey1", 0.0),))
    e = bench.innovations([none], deaf(bench))[0][0]
    assert error(bench.trials[0].y - e, bench.trials[0].y) < 1e-6


def test_a_command_has_no_noise_however_it_jumps():
    assert recording().input_noise.tolist()[1] == 0.0
    assert recording(noise=0.01).output_noise[0] > 0.0


def test_a_motor_s_fault_is_done_to_its_command_and_not_taken_back():
    one = recording()
    delivered = corrected(one, [ALL["motor_delay"]("pendulum", LATE / RATE)]).u[:, 1]
    np.testing.assert_allclose(delivered[LATE:], one.u[:-LATE, 1], atol=1e-12)


def test_a_motor_s_delay_is_found():
    bench = bench_of(recording(LATE, noise=0.003))
    start = Hypothesis((), (), (ALL["motor_delay"]("pendulum", 2 / RATE),))
    found = fit(bench, start, 1e-3, iterations=12).hypothesis.found[0]
    assert found.delay == pytest.approx(LATE / RATE, rel=0.02)


def test_a_motor_s_first_guesses_go_by_its_command():
    bench = bench_of(recording())
    still = {"pendulum": np.zeros(8), "rate pendulum": np.zeros(8)}
    around = surroundings(bench, still, {}, "pendulum")
    np.testing.assert_array_equal(around.reading, bench.trials[0].u[:, 1])
    starts = ALL["motor_deadband"].starts("pendulum", around)
    assert all(start.torque > 0 for start in starts)
