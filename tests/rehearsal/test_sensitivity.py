"""Predicted limits: they follow the noise, the drawing's tolerance and what else there is."""

import numpy as np
import pytest
from rehearsal_support import SHAKEN, plan

from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.sensor_gain import SensorGain
from twin.model import Twin
from twin.rehearsal.bench import Bench
from twin.rehearsal.read_off import calibration_limit
from twin.rehearsal.recordings import recorded
from twin.rehearsal.rehearse import predicted
from twin.rehearsal.sensitivity import APART, needed_nats
from twin.rehearsal.whitening import Whitener

TWIN = Twin.load("two_storey_lumped")


def limits(**changes):
    bench = Bench.of(TWIN, plan(**changes), 0)
    return {e.label: p for e, p in zip(bench.effects, predicted(bench), strict=True)}


def concealing(*names):
    return {"conceal": {"mechanisms": list(names)}}


def test_noise_alone_is_white_with_unit_variance():
    bench = Bench.of(TWIN, plan(noise={"acc": 0.02, "force": 0.02}), 0)
    white = Whitener(bench.model, bench.trials[0])
    # what the recording has beyond the prediction from its measured force is noise
    (made,) = white([bench.trials[0].y - white.nominal]).T
    made = made[200:]
    assert np.std(made) == pytest.approx(1.0, abs=0.12)
    lagged = made[2:] @ made[:-2] / (made @ made)
    assert abs(lagged) < 5 / np.sqrt(len(made))


@pytest.mark.parametrize(
    ("mechanism", "hardly"),
    [
        (CoulombFriction("storey1", 3e-4), CoulombFriction("storey1", 1e-12)),
        (SensorGain("acc_floor1", 1.01), SensorGain("acc_floor1", 1.0)),
    ],
)
def test_what_is_predicted_to_change_is_what_changes_in_mujoco(mechanism, hardly):
    quiet = {"noise": {"acc": 0.0, "force": 0.0}}
    bench = Bench.of(TWIN, plan(**quiet), 3)
    white = Whitener(bench.model, bench.trials[0])
    # hardly any of it, so that both are simulated in equal steps
    made, without = (
        recorded(TWIN, bench.plan, 3, m)[0].matrix(bench.model.outputs) for m in (mechanism, hardly)
    )
    change = made - without
    expected = white.change(mechanism)
    assert np.sqrt(np.mean((change - expected) ** 2)) < 0.1 * np.sqrt(np.mean(change**2))


def test_twice_the_noise_is_nearly_twice_the_limit():
    # where the drawing says nothing of what friction does to the damping
    few, many = (
        limits(damping_tolerance=1.0, noise={"acc": share, "force": share})[
            "coulomb_friction", "storey1"
        ].seen
        for share in (0.02, 0.04)
    )
    assert many / few == pytest.approx(2.0, rel=0.1)


def test_a_stiffness_is_seen_only_beyond_the_drawings_tolerance():
    made = {t: limits(tolerance=t, **concealing("stiffness")) for t in (0.005, 0.02)}
    tight, loose = (made[t]["stiffness", "storey1"].seen for t in (0.005, 0.02))
    # L = (size / tolerance)^2 / 2 where the data say all: 19 nats are six tolerances
    assert loose / tight == pytest.approx(4.0, rel=0.15)
    needed = needed_nats(60)
    needed += np.log(1.5 * np.sqrt(2 * needed))
    assert loose == pytest.approx(np.sqrt(2 * needed) * 0.02 / 0.05, rel=0.1)


def test_friction_is_told_last_from_slip_that_hardly_hardens():
    prospect = limits()["coulomb_friction", "storey1"]
    assert prospect.rival == ("microslip", "storey1")
    assert prospect.named >= prospect.seen


def test_one_sensor_tells_less_than_two():
    one = limits(sensors=["acc_floor2"])["coulomb_friction", "storey1"]
    two = limits()["coulomb_friction", "storey1"]
    assert one.named > two.named


def test_what_is_not_concealed_is_a_rival_all_the_same():
    alone = limits(**concealing("cubic_stiffness"))["cubic_stiffness", "storey1"]
    beside = limits(**concealing("cubic_stiffness", "clearance"))["cubic_stiffness", "storey1"]
    assert alone == beside


def test_what_has_no_size_is_seen_or_not():
    made = limits(**concealing("sensor_polarity", "sensor_gain"))
    assert made["sensor_polarity", "acc_floor1"].seen == 1.0
    assert made["sensor_gain", "acc_floor1"].rival != ("sensor_polarity", "acc_floor1")


def test_what_is_read_off_needs_spikes_beyond_the_noise():
    made = [
        limits(noise={"acc": share}, **concealing("sensor_spikes"))["sensor_spikes", "acc_floor1"]
        for share in (0.002, 0.05)
    ]
    assert made[0].seen < made[1].seen < np.inf


def test_a_force_that_nobody_measures_is_seen_above_the_noise():
    seen = [
        limits(noise={"acc": s, "force": s}, **concealing("unmeasured_force"))[
            "unmeasured_force", "floor1"
        ].seen
        for s in (0.005, 0.05)
    ]
    assert seen[0] < seen[1]


def test_needed_nats_are_those_that_nine_of_ten_tests_have():
    rng = np.random.default_rng(1)
    mean = needed_nats(40)
    ratio = mean + np.sqrt(2 * mean) * rng.standard_normal(200_000)
    assert np.mean(ratio > np.log(40 / 0.01)) == pytest.approx(0.9, abs=0.005)
    apart = APART + np.sqrt(2 * APART) * rng.standard_normal(200_000)
    assert np.mean(apart > 0) == pytest.approx(0.9, abs=0.005)


def test_what_takes_stiffness_away_is_no_rival_of_what_adds_it():
    made = limits(**concealing("stiffness", "p_delta"))
    assert made["stiffness", "storey1"].named < np.inf
    assert made["stiffness", "storey1"].rival != ("p_delta", "storey1")


def test_a_gap_in_between_is_a_rival_too():
    made = limits(**concealing("cubic_stiffness"))["cubic_stiffness", "storey1"]
    assert made.rival == ("clearance", "storey1")
    assert made.named > made.seen


def test_an_instrument_is_no_better_than_its_calibration():
    quiet = {"noise": {"acc": 1e-5, "force": 1e-5}, **concealing("sensor_gain", "sensor_drift")}
    bench = Bench.of(TWIN, plan(**quiet), 0)
    for effect, prospect in zip(bench.effects, predicted(bench), strict=True):
        least = calibration_limit(effect, bench.recordings)
        if effect.label[0] == "sensor_drift":
            assert least == 0.0
        else:
            assert effect.size(least) == pytest.approx(1.005, abs=4e-4)
            assert prospect.named >= prospect.seen >= least


def test_a_fault_of_a_channel_that_some_recordings_lack_is_in_the_others():
    other = {**SHAKEN, "at": "floor1"}
    mixed = plan(recordings=[SHAKEN, other, {**SHAKEN, "use": "test"}])
    sound = recorded(TWIN, mixed, 1)
    faulty = recorded(TWIN, mixed, 1, SensorGain("force_floor2", 2.0))
    assert np.allclose(faulty[0].column("force_floor2"), 2 * sound[0].column("force_floor2"))
    assert np.array_equal(faulty[1].data, sound[1].data)


def test_a_hysteresis_that_is_concealed_is_one_that_mujoco_has():
    made = plan(**concealing("hysteresis"))
    effect = Bench.of(TWIN, made, 1).effects[0]
    pairs = zip(recorded(TWIN, made, 1, effect.at(0.1)), recorded(TWIN, made, 1), strict=True)
    assert all(np.any(a.data != b.data) for a, b in pairs)
