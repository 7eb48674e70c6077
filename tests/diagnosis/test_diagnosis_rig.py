"""Hypotheses as MuJoCo twins: the same matrices, and free runs that are plain simulations."""

import numpy as np
import pytest
from diagnosis_support import RATE, TWO, error, exact_trial, lumped, recorded, tones

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.plant import build
from twin.diagnosis.predict import nrmse
from twin.diagnosis.prepare import prepare
from twin.diagnosis.rig import free_run, free_runs, heights_of, merged, twin_with
from twin.diagnosis.trials import trial

ALL = mechanisms.vocabulary()
CHANGES = {
    "stiffness": ALL["stiffness"]("storey1", -50.0),
    "damping": ALL["damping"]("floor1", 0.3),
    "mass": ALL["mass"]("floor2", 1.0),
    "appendage": ALL["appendage"]("floor2", 0.1, 2.0, 0.02),
    "base_compliance": ALL["base_compliance"]("ground", 5e4, 10.0, 2.5),
    "p_delta": ALL["p_delta"]("storey1", 1.0, 0.3),
}
PAIRS = [(a, b) for a in CHANGES for b in CHANGES if a != b]


@pytest.mark.parametrize("pair", PAIRS, ids=["+".join(p) for p in PAIRS])
def test_the_plant_and_the_mujoco_twin_are_one_whatever_the_order_of_changes(pair):
    both = [CHANGES[name] for name in pair]
    planned = build(lumped().second_order(), both, ("force_floor1",), ("acc_floor1",)).model
    rig = twin_with(lumped(), both).second_order()
    at = np.ix_(*2 * ([rig.coordinates.index(c) for c in planned.coordinates],))
    for name in "MRK":
        wanted = getattr(rig, name)[at]
        np.testing.assert_allclose(getattr(planned, name), wanted, atol=1e-9 * np.abs(wanted).max())


def test_changes_of_one_kind_at_one_place_add_up_and_others_stay():
    spring, dashpot = ALL["stiffness"], ALL["damping"]
    friction = ALL["coulomb_friction"]("storey1", 0.1)
    found = merged(
        [spring("storey1", 5.0), dashpot("storey1", 0.1), spring("storey2", 1.0), friction,
         spring("storey1", -7.0), dashpot("storey1", 0.2)]
    )  # fmt: skip
    assert [(m.name, m.place) for m in found] == [
        ("stiffness", "storey1"), ("damping", "storey1"), ("stiffness", "storey2"),
        ("coulomb_friction", "storey1"),
    ]  # fmt: skip
    assert [m.values["change"] for m in found[:3]] == pytest.approx([-2.0, 0.3, 1.0])
    assert found[3] == friction


def test_a_twin_with_nothing_changed_is_the_twin():
    base = base_hypothesis(lumped().second_order())
    assert twin_with(lumped(), base.mechanisms).mechanisms == ()


def test_a_twin_keeps_what_it_had_and_adds_to_it():
    had = lumped(ALL["stiffness"]("storey1", 30.0), ALL["cubic_stiffness"]("storey2", 1e5))
    found = twin_with(had, [ALL["stiffness"]("storey1", 12.0)])
    assert found.mechanisms[0].change == pytest.approx(42.0)
    assert found.mechanisms[1] == had.mechanisms[1]
    assert twin_with(had, [ALL["stiffness"]("storey1", -30.0)]).mechanisms == had.mechanisms[1:]


def test_heights_are_those_of_the_storeys():
    heights = heights_of(lumped())
    assert list(heights) == ["storey1", "storey2"]
    assert heights["storey1"] == pytest.approx(0.3089, abs=1e-4)
    assert sum(heights.values()) == pytest.approx(0.6078, abs=0.02)


def test_a_free_run_is_the_simulation_at_the_samples():
    samples = 768
    force = tones(samples, scale=0.2)
    motion = lumped().simulate({"force_floor2": force}, RATE, samples).columns
    names = ("acc_floor1", "disp_floor2")
    laid = trial(
        "x", RATE, {"force_floor2": force, **{n: motion[n] for n in names}}, ("force_floor2",),
        names,
    )  # fmt: skip
    lines = free_run(lumped(), laid, "linear")
    np.testing.assert_array_equal(lines, laid.y)
    band = free_run(lumped(), laid, "band_limited")
    assert 1e-6 < error(band[64:-64], laid.y[64:-64]) < 0.02


@pytest.mark.parametrize(
    ("between", "allowed"), [("linear", 1e-4), ("held", 0.01), ("band_limited", 2e-3)]
)
def test_what_inputs_do_between_samples_is_played_back(between, allowed):
    """The linear plant, and MuJoCo, from the same samples."""
    record = recorded(lumped(), 1, seconds=8.0, noise=0.0)
    ready = prepare(lumped(), [record], [recorded(lumped(), 2, seconds=8.0)])
    bench = Bench(ready.train.model, ready.train.trials, between)
    found = free_runs(lumped(), bench)[0]
    plant = bench.plant(bench.trials[0], ())
    u = bench.trials[0].u
    smooth = bench.smooth(u)
    x, states = np.zeros(len(plant.A)), []
    for k in range(len(u)):
        states.append(x)
        x = plant.A @ x + plant.B0 @ smooth[k] + plant.B1 @ smooth[min(k + 1, len(u) - 1)]
    wanted = np.array(states) @ plant.plant.C.T + u @ plant.plant.D.T
    # a held force is a staircase of ramps that begin a little early
    assert error(found[64:-64], wanted[64:-64]) < allowed
    if between == "band_limited":
        assert nrmse(bench.trials, [found]) < 2e-3, "as the record was made"


def test_a_free_run_carries_its_recording_s_added_mass_and_its_channels_faults():
    bolted = lumped(ALL["mass"]("floor2", 0.4))
    record = recorded(bolted, 1, seconds=8.0, noise=0.0)
    test = recorded(lumped(), 2, seconds=8.0)
    ready = prepare(lumped(), [record], [test], {record.source: {"floor2": 0.4}})
    found = free_run(lumped(), ready.train.trials[0], "band_limited")
    assert nrmse(ready.train.trials, [found]) < 2e-3
    half = lumped(ALL["sensor_gain"]("acc_floor1", 0.5))
    faulty = free_run(half, ready.train.trials[0], "band_limited")
    np.testing.assert_allclose(faulty[:, 0], 0.5 * found[:, 0], atol=1e-12)
    np.testing.assert_allclose(faulty[:, 1], found[:, 1], atol=1e-12)


def test_a_motion_that_diverges_is_no_number():
    wild = lumped(ALL["damping"]("storey1", -60.0))
    ready = prepare(
        lumped(), [recorded(lumped(), 1, seconds=8.0)], [recorded(lumped(), 2, seconds=8.0)]
    )
    run = free_run(wild, ready.train.trials[0], "linear")
    assert np.isnan(run).all()
    assert not np.isfinite(nrmse(ready.train.trials, [run]))


def test_the_error_is_pooled_over_channels_and_recordings():
    trials = [exact_trial(seed=i, model=TWO) for i in range(2)]
    assert nrmse(trials, [t.y for t in trials]) == 0.0
    assert nrmse(trials, [0 * t.y for t in trials]) == pytest.approx(1.0)
    assert nrmse(trials, [1.1 * t.y for t in trials]) == pytest.approx(0.1)
