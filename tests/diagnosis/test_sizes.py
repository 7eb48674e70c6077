"""How large an effect is, beside what is left without a name."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.candidates import motions, scales_of
from twin.diagnosis.discrepancy import DISCREPANCY_SHARE
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.left import left_share
from twin.diagnosis.predict import predictors
from twin.diagnosis.prepare import prepare
from twin.diagnosis.pushes import pushes
from twin.diagnosis.readings import read_of, read_of_disturbance
from twin.diagnosis.sizes import SPECTRUM_SHARE, forces, negligible, of_known
from twin.estimation.fit import fit
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.damping import Damping
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.sensor_hum import SensorHum
from twin.mechanisms.sensor_unexplained import SensorUnexplained
from twin.mechanisms.stiffness import Stiffness
from twin.mechanisms.unmeasured_force import UnmeasuredForce


@pytest.fixture(scope="module")
def problem():
    ready = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)])
    return ready.train


def hypothesis(problem, *mechanisms):
    blank = Hypothesis(problem)
    moved = motions(problem, blank, np.zeros(len(blank.unknowns)))
    priors = []
    for m in mechanisms:
        own = {}
        for name, parameter in m.parameters.items():
            value = m.values[name]
            own[name] = (np.log(abs(value)), 0.1) if parameter.scale == "log" else (value, 1.0)
        priors.append(own)
    return replace(blank, mechanisms=mechanisms, priors=tuple(priors),
                   scales=scales_of(problem, moved))  # fmt: skip


def is_negligible(h, found, shown=False):
    beside = predictors(h, found.z)
    return negligible(h, found, beside, forces(h, found.z, beside), shown)


def sizes(problem, *mechanisms):
    h = hypothesis(problem, *mechanisms)
    z = np.zeros(len(h.unknowns))
    return forces(h, z, predictors(h, z))


def test_the_force_of_a_spring_is_its_stiffness_times_the_motion(problem):
    h = hypothesis(problem, Stiffness("storey2", 5.0))
    z = np.zeros(len(h.unknowns))
    beside = predictors(h, z)
    row = problem.model.port("storey2")
    drift = beside[0].followed.x[:, : len(row)] @ row
    expected = 5.0 * np.linalg.norm(row) * np.sqrt(np.mean(drift**2))
    assert forces(h, z, beside)[0] == pytest.approx(expected)


def test_an_effect_twice_as_strong_is_twice_as_large(problem):
    for weak, strong in (
        (Stiffness("storey1", 1.0), Stiffness("storey1", 2.0)),
        (Damping("storey1", 0.01), Damping("storey1", 0.02)),
        (SensorGain("force_floor2", 1.01), SensorGain("force_floor2", 1.02)),
    ):
        one, two = sizes(problem, weak)[0], sizes(problem, strong)[0]
        assert two == pytest.approx(2 * one, rel=0.05), weak.name


def test_beside_a_law_a_hundredth_of_it_is_negligible_and_a_tenth_is_not(problem):
    problem = replace(problem, damping_tolerance=1e-6)
    law = CubicStiffness("storey2", 1e6)
    size, damper = sizes(problem, law, Damping("storey1", 0.01))
    for share, small in ((0.5 * DISCREPANCY_SHARE, True), (10 * DISCREPANCY_SHARE, False)):
        change = 0.01 * share * size / damper
        h = hypothesis(problem, law, Damping("storey1", change))
        found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
        level = {u.name: u for u in h.unknowns}["discrepancy storey2"]
        quiet = replace(found, z=np.where([u is level for u in h.unknowns], -3.0, found.z))
        assert is_negligible(h, quiet) == [False, small]


def test_a_force_that_stays_is_no_discrepancy(problem):
    law = CubicStiffness("storey2", 1e6)
    h = hypothesis(problem, law)
    found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
    names = [u.name for u in h.unknowns]
    at = [names.index(f"discrepancy storey2 {name}") for name in ("frequency", "bandwidth")]

    def left(hz):
        z = found.z.copy()
        logs = np.log([hz, 2 * hz])
        z[at] = [(x - h.unknowns[i].mean) / h.unknowns[i].deviation
                 for x, i in zip(logs, at, strict=True)]  # fmt: skip
        share = left_share(h, replace(found, z=z), 0, sizes(problem, law))
        return share / np.sqrt(1 - share**2)

    longest = len(problem.recordings[0].y) * problem.step_s
    assert left(1e-5 / longest) < 0.01 * left(1e3)
    # critically damped at 1/T [rad/s], of the variance the mean keeps 2 int_0^1 (1 - x^2) e^-x dx
    varies = np.sqrt(1 - (8 / np.e - 2))
    assert left(1 / (2 * np.pi * longest)) == pytest.approx(varies * left(1e3), rel=1e-3)


def test_a_damping_within_the_tolerance_of_the_structures_is_negligible(problem):
    own = float(np.sum(np.diag(problem.model.R)))
    for change, small in ((1e-3 * own, True), (10 * own, False)):
        h = hypothesis(problem, Damping("storey1", change))
        found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
        assert is_negligible(h, found) == [small]
        sure = replace(h, problem=replace(problem, damping_tolerance=1e-6))
        assert is_negligible(sure, found) == [False]


def test_without_a_law_a_weak_spring_is_not_negligible(problem):
    h = hypothesis(problem, Stiffness("storey1", 1e-6))
    found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
    assert is_negligible(h, found) == [False]


def test_beside_something_else_an_instrument_is_as_good_as_its_calibration(problem):
    spring = Stiffness("storey1", 20.0)
    for gain, small in ((1.004, True), (0.996, True), (1.006, False)):
        for channel in ("acc_floor1", "force_floor2"):
            h = hypothesis(problem, spring, SensorGain(channel, gain))
            found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
            assert is_negligible(h, found) == [False, small], (gain, channel)
            alone = hypothesis(problem, SensorGain(channel, gain))
            found = fit(alone, most=1, free=np.zeros(len(alone.unknowns), bool))
            assert is_negligible(alone, found) == [False], (gain, channel)
            assert is_negligible(alone, found, shown=True) == [small], (gain, channel)


def test_of_two_faults_the_one_within_its_calibration_is_negligible_and_of_two_such_none(problem):
    small, great = SensorGain("acc_floor1", 1.004), SensorGain("acc_floor2", 1.05)
    for pair, expected in (((small, great), [True, False]), ((great, small), [False, True]),
                           ((small, SensorGain("acc_floor2", 1.003)), [False, False])):  # fmt: skip
        h = hypothesis(problem, *pair)
        found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
        assert is_negligible(h, found) == expected


def test_an_error_added_to_a_channel_is_measured_by_its_reading(problem):
    level = problem.readings["acc_floor2"]
    for share, small in ((0.004, True), (0.006, False)):
        error = SensorUnexplained("acc_floor2", share * level, 1.0)
        h = hypothesis(problem, Stiffness("storey1", 20.0), error)
        found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
        assert is_negligible(h, found) == [False, small]


def read(problem, *mechanisms):
    """Return the RMS that outputs read of every mechanism, (mechanisms, outputs)."""
    h = hypothesis(problem, *mechanisms)
    z = np.zeros(len(h.unknowns))
    beside = predictors(h, z)
    lengths = [len(s.trial.y) for s in beside]
    found = []
    for m, push in zip(mechanisms, pushes(h, z, beside), strict=True):
        if isinstance(m, UnmeasuredForce):
            found.append(read_of_disturbance(m, lengths, problem.model, problem.step_s))
        else:
            parts = np.split(push, np.cumsum(lengths)[:-1])
            found.append(read_of(parts, problem.model, problem.step_s))
    return np.array(found)


def test_beside_an_unmeasured_force_what_its_spectrum_may_hide_is_negligible(problem):
    force = UnmeasuredForce("floor1", 0.02, 7.0, 5.0)
    of_force, of_spring = read(problem, force, Stiffness("storey2", 1.0))
    for share, small in ((0.3, True), (0.6, False)):
        # more of it than the share is read by no output, or by the one that sees most of it
        h = hypothesis(problem, force, Stiffness("storey2", share / np.max(of_spring / of_force)))
        found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
        assert is_negligible(h, found) == [False, small]


def test_a_great_force_that_outputs_hardly_read_hides_no_small_one_that_they_do(problem):
    natural = np.sqrt(np.diag(problem.model.K) / np.diag(problem.model.M)) / (2 * np.pi)
    shaken = UnmeasuredForce("ground", 0.04, 6 * np.max(natural), 1.0)
    pushed = UnmeasuredForce("floor1", 0.01, np.max(natural), 1.0)
    great, small = sizes(problem, shaken, pushed)
    assert small < SPECTRUM_SHARE * great
    of_great, of_small = read(problem, shaken, pushed)
    assert np.all(of_great < SPECTRUM_SHARE * of_small)
    h = hypothesis(problem, shaken, pushed)
    found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
    assert is_negligible(h, found) == [True, False]


def test_a_channel_that_sees_a_law_jump_is_no_better_than_its_discrepancy(problem):
    for gain, small in ((1.0005, True), (1.2, False)):
        h = hypothesis(
            problem, CoulombFriction("storey2", 0.02, 1e-4), SensorGain("acc_floor2", gain)
        )
        found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
        assert is_negligible(h, found)[1] is small


def test_a_channel_is_no_better_than_what_it_reads_of_what_a_law_leaves(problem):
    spring = CubicStiffness("storey2", 1e5)
    for gain, level, small in ((1.01, 1.0, True), (1.01, -8.0, False), (1.3, 1.0, False)):
        h = hypothesis(problem, spring, SensorGain("acc_floor2", gain))
        names = [u.name for u in h.unknowns]
        z = np.zeros(len(names))
        z[names.index("discrepancy storey2")] = level
        found = fit(h, z, most=1, free=np.zeros(len(z), bool))
        assert is_negligible(h, found)[1] is small


def test_a_line_that_an_instrument_adds_is_not_lost_in_what_a_law_leaves(problem):
    spring = CubicStiffness("storey2", 1e5)
    humming = SensorHum("acc_floor2", amplitude=0.02 * problem.readings["acc_floor2"])
    error = SensorUnexplained("acc_floor2", humming.amplitude, 5.0)
    for fault, small in ((humming, False), (error, True)):
        h = hypothesis(problem, spring, fault)
        names = [u.name for u in h.unknowns]
        z = np.zeros(len(names))
        z[names.index("discrepancy storey2")] = 2.0
        found = fit(h, z, most=1, free=np.zeros(len(z), bool))
        assert is_negligible(h, found)[1] is small


def test_a_law_of_the_models_own_scatters_by_as_much_as_a_damping_does(problem):
    held = replace(problem, known=(CoulombFriction("storey2", 0.1),))
    here, there = CoulombFriction("storey2", 0.01), CoulombFriction("storey1", 0.01)
    assert of_known(held, here, [2.0]) == pytest.approx(2.0 * problem.damping_tolerance)
    assert of_known(held, there, [2.0]) == 0.0
    assert of_known(held, CubicStiffness("storey2", 1.0), [2.0]) == 0.0
    assert of_known(problem, here, []) == 0.0


def test_what_outputs_read_less_of_than_of_what_no_name_explains_is_nobodys_finding(problem):
    hung = Appendage("floor1", 2e-4, 27.0, 0.5)
    for places, level, small in (
        (("acc_floor1", "acc_floor2"), 1.0, True),
        (("acc_floor1", "acc_floor2"), 1e-6, False),
        (("acc_floor2",), 1.0, False),  # the other channel hears it, and is believed
    ):
        errors = [SensorUnexplained(place, level, 1.0) for place in places]
        h = hypothesis(problem, hung, *errors)
        found = fit(h, most=1, free=np.zeros(len(h.unknowns), bool))
        assert is_negligible(h, found)[0] == small
