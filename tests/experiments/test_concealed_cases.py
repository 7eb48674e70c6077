"""Concealed cases: same seed, same bytes; physical, visible, sealed."""

import json
import os

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from experiments.concealed import absorbed, outside, pairs
from experiments.concealed import case as cases
from experiments.concealed.case import from_truth, generate, moved
from experiments.concealed.chain import Chain, at_sensor, delayed, highpass
from experiments.concealed.columns import change, columns
from experiments.concealed.distinct import evidence
from experiments.concealed.drawing import VISIBLE
from experiments.concealed.frames import model_of, tall, write_model
from experiments.concealed.likelihood import Likelihood, nats
from experiments.concealed.mechanisms import Mechanism, build, places
from experiments.concealed.plans import draw_plan
from experiments.concealed.reference import reference
from experiments.concealed.rehearsal import Rehearsal
from experiments.concealed.rig import TWO_STOREY
from experiments.concealed.seal import open_seal, write_manifest
from experiments.concealed.steps import Concealing, conceal
from experiments.concealed.tables import (
    TABLES,
    case_name,
    combination_of,
    combinations,
    expected,
)
from twin.errors import TwinError
from twin.formats import read_recording
from twin.model import Twin

FILES = [*(f"train_{i}.csv" for i in range(1, 5)), "test_1.csv", "test_2.csv"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("case")
    return folder, generate(4, 1, folder, folder / "sealed")


def test_the_same_seed_gives_the_same_bytes(made, tmp_path):
    folder, digest = made
    assert generate(4, 1, tmp_path, tmp_path / "sealed") == digest
    for name in FILES:
        path = f"case_0004/{name}"
        assert (folder / path).read_bytes() == (tmp_path / path).read_bytes()


@pytest.mark.skipif(os.cpu_count() == 1, reason="one core: BLAS has no second thread")
def test_the_same_truth_is_sealed_however_many_threads_there_are(tmp_path):
    digests = []
    for threads in (1, 2):
        out = tmp_path / str(threads)
        (out / "sealed").mkdir(parents=True)
        with threadpool_limits(threads, "blas"):
            digests.append(conceal(Concealing("pairs", 3, 2034, out, out / "sealed"))["sha256"])
    assert digests[0] == digests[1]


def test_six_recordings_and_nothing_else_lie_where_a_diagnosis_reads(made):
    folder, _ = made
    assert sorted(p.name for p in (folder / "case_0004").iterdir()) == sorted(FILES)
    for name in FILES:
        recording = read_recording(folder / "case_0004" / name)
        assert recording.sampling_hz == pytest.approx(256)
        assert 24 <= recording.duration_s <= 30
        assert len(recording.inputs) == 1
        assert recording.outputs == ("acc_floor1", "acc_floor2")


def test_the_recordings_are_the_rigs_motion_with_the_stated_noise(made):
    folder, digest = made
    truth = open_seal(folder / "sealed" / "case_0004.json", digest)
    assert ((truth["mechanism"], truth["location"]),) == combination_of("single", 4, 1)
    effect = {key: truth[key] for key in ("mechanism", "location", "parameters", "form")}
    assert truth["effects"] == [effect]
    assert (truth["table"], truth["model"]) == ("single", "two_storey_lumped")
    case = from_truth(truth)
    assert truth == case.truth(4, 1)
    drive, seen, _ = moved(case, case.plan[0])
    both = np.column_stack([drive, at_sensor(seen, *case.effects)])
    exact = case.chain.sampled(both)
    noise = read_recording(folder / "case_0004" / "train_1.csv").data - exact
    share = noise.std(axis=0) / np.sqrt(np.mean(exact**2, axis=0))
    assert share == pytest.approx(np.full(3, truth["noise"]), rel=0.05)


def test_a_touched_truth_is_refused(made, tmp_path):
    folder, digest = made
    write_manifest(tmp_path, {"case_0004": digest}, "twin concealed", {})
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["sha256"] == {"case_0004": digest}
    copy = tmp_path / "case_0004.json"
    copy.write_bytes((folder / "sealed" / "case_0004.json").read_bytes().replace(b"1", b"2", 1))
    with pytest.raises(TwinError, match="the seal is broken"):
        open_seal(copy, digest)
    with pytest.raises(TwinError, match="cannot read this truth"):
        open_seal(tmp_path / "case_0005.json", digest)


def test_each_round_goes_through_every_place_once():
    pairs = places(2)
    for first in (1, 1 + len(pairs)):
        drawn = {combination_of("single", first + i, 9)[0] for i in range(len(pairs))}
        assert drawn == set(pairs)
    one, other = ([combination_of("single", i, seed) for i in range(1, 42)] for seed in (9, 10))
    assert one != other


def test_a_table_names_its_cases():
    assert [case_name(7, table) for table in ("single", "none")] == ["case_0007", "none_0007"]
    with pytest.raises(TwinError, match=r"no table 'hard' .* none"):
        generate(1, 1, None, None, table="hard")


@pytest.mark.parametrize("pair", places(2)[::7])
def test_strengths_are_visible_and_physical(pair):
    case = cases.draw_case(np.random.default_rng(5), "case", (pair,))
    assert case.effect > VISIBLE * case.chain.noise
    training = [test for test in case.plan if test.name.startswith("train")]
    assert {test.floor for test in training} == {1, 2}
    assert len({round(test.level, 6) for test in training}) == 4
    assert {test.kind for test in case.plan[4:]} == {"hammer", "random"}


def test_a_base_that_is_too_hard_is_a_softer_storey_to_the_recordings():
    tests = [t for t in draw_plan(np.random.default_rng(2), 2) if t.name.startswith("train")]

    def nats(stiffness):
        parameters = (("stiffness", stiffness), ("damping", 0.0))
        base = Mechanism("base_compliance", "ground", parameters)
        return evidence(TWO_STOREY, build(TWO_STOREY, base), tests, True, 0.02)

    assert nats(1e4) > 100
    assert nats(1e5) < 10


@pytest.mark.parametrize("table", TABLES)
def test_every_table_says_what_it_conceals(table):
    storeys = {"three_storeys": 3, "five_storeys": 5}.get(table, 2)
    every = combinations(table, storeys)
    assert len(every) == len(set(every))
    assert all(len(found) == {"none": 0, "pairs": 2}.get(table, 1) for found in every)
    round_ = [combination_of(table, 1 + i, 3, storeys) for i in range(len(every))]
    assert set(round_) == set(every)
    assert len(combinations("pairs")) >= 12


def test_an_absorbed_effect_leaves_a_calibration_little():
    case = drawn("absorbed", ("coulomb_friction", "storey1"))
    weighed = dict(case.evidence)
    assert absorbed.LEFT_NATS[0] < weighed["left_nats"] < 1.4 * absorbed.LEFT_NATS[1]
    assert absorbed.ABSORBED < weighed["absorbed_share"] < 1
    assert expected("absorbed", case.effects) == "missing_physics"


def test_each_of_a_pair_is_demanded():
    case = drawn("pairs", ("clearance", "storey1"), ("sensor_gain", "acc_floor2"))
    assert [m.name for m in case.effects] == ["clearance", "sensor_gain"]
    weighed = dict(case.evidence)
    assert min(weighed[f"nats_of_{m.name}"] for m in case.effects) > pairs.APART_NATS
    assert min(weighed[f"change_over_noise_of_{m.name}"] for m in case.effects) > pairs.VISIBLE


def test_no_mechanism_stands_in_for_what_is_outside_the_vocabulary():
    case = drawn("outside", ("magnet", "storey2"))
    left = {k: v for k, v in case.evidence if k.startswith("left_by")}
    assert min(left.values()) > outside.LEFT_NATS
    assert expected("outside", case.effects) == "unexplained"


def drawn(table, *combination):
    return cases.draw_case(np.random.default_rng(11), "case", combination, table)


def test_likelihood_is_that_of_white_noise_on_the_outputs():
    tests = tuple(t for t in draw_plan(np.random.default_rng(2), 2) if t.name.startswith("train"))
    chain = Chain("filtered", 6, 0.01)
    rehearsal = Rehearsal.of(TWO_STOREY, tests, chain, (1, 2))
    likelihood = Likelihood(rehearsal)
    gain = Mechanism("sensor_gain", "acc_floor1", (("gain", 1.001),))
    found = nats(change(likelihood, [gain], rehearsal.healthy))
    # without the input's noise it would be half the sum of squares over the noise's variance
    loudest = sum(t.samples for t in tests) / 2 * (0.001 / 0.01) ** 2
    assert 0.02 * loudest < found < loudest


def test_a_mechanisms_column_is_what_it_does_while_it_is_weak():
    tests = tuple(t for t in draw_plan(np.random.default_rng(2), 2) if t.name.startswith("train"))
    rehearsal = Rehearsal.of(TWO_STOREY, tests, Chain("filtered", 6, 0.01), (1, 2))
    likelihood = Likelihood(rehearsal)
    for name, place, parameters in (
        ("mass", "floor1", {"change": 1e-4}),
        ("cubic_stiffness", "storey2", {"stiffness": 1e3}),
        ("quadratic_drag", "floor2", {"coefficient": 1e-3}),
        ("appendage", "floor1", {"mass": 1e-5, "frequency": 4.0, "damping_ratio": 0.02}),
        ("sensor_delay", "acc_floor2", {"delay": 1e-4}),
    ):
        m = Mechanism(name, place, tuple(parameters.items()))
        runs = rehearsal.moved([m])
        done = change(likelihood, [m], runs)
        column = columns(likelihood, m, runs)
        assert np.linalg.norm(done - column) < 0.02 * np.linalg.norm(done)


def test_one_sensor_is_all_that_is_recorded(tmp_path):
    generate(2, 3, tmp_path, tmp_path / "sealed", table="one_sensor")
    recording = read_recording(tmp_path / "one_sensor_0002" / "train_1.csv")
    assert len(recording.outputs) == len(recording.inputs) == 1


def test_a_shaken_ground_is_the_only_input(tmp_path):
    digest = generate(2, 3, tmp_path, tmp_path / "sealed", table="ground")
    recording = read_recording(tmp_path / "ground_0002" / "train_1.csv")
    assert recording.inputs == ("acc_ground",)
    assert recording.outputs == ("acc_floor1", "acc_floor2")
    truth = open_seal(tmp_path / "sealed" / "ground_0002.json", digest)
    assert reference(truth, tmp_path)["fit_ahead"] < 3 * truth["noise"]


def test_the_model_of_a_tall_frame_lies_beside_its_recordings(tmp_path):
    write_model(tall(3), tmp_path)
    model = Twin.load(model_of("three_storeys", tmp_path)).second_order()
    rig = tall(3)
    assert model_of("single", tmp_path) == "two_storey_lumped"
    floors = [model.coordinates.index(f"floor{i}") for i in (1, 2, 3)]
    take = np.ix_(floors, floors)
    assert np.diag(model.M)[floors] == pytest.approx(rig.masses)
    assert model.K[take] == pytest.approx(rig.stiffness, rel=1e-6, abs=1e-6)
    assert model.R[take] == pytest.approx(rig.damping, rel=1e-4, abs=1e-6)


def test_faults_of_a_sensor_touch_their_channel_only():
    time = np.arange(4096) / 4096
    clean = np.column_stack([np.sin(2 * np.pi * 3 * time), np.cos(2 * np.pi * 2 * time)])

    def given(name, location="acc_floor2", **parameters):
        fault = Mechanism(name, location, tuple(parameters.items()))
        return at_sensor(clean, fault)

    for name, parameters in {
        "sensor_gain": {"gain": 0.9}, "sensor_polarity": {}, "sensor_clipping": {"level": 0.5},
        "sensor_highpass": {"corner": 1.0}, "sensor_delay": {"delay": 0.01},
    }.items():  # fmt: skip
        assert np.array_equal(given(name, **parameters)[:, 0], clean[:, 0])
        assert not np.allclose(given(name, **parameters)[:, 1], clean[:, 1])
    assert np.array_equal(given("sensor_swap", "acc_floor1+acc_floor2"), clean[:, ::-1])
    late = delayed(clean[:, 0], 0.01, 4096)
    assert late[100:] == pytest.approx(np.sin(2 * np.pi * 3 * (time[100:] - 0.01)), abs=1e-9)
    back = highpass(highpass(clean[:, 1], 1.0, 4096), 1.0, 4096, inverse=True)
    assert back == pytest.approx(clean[:, 1], abs=1e-9)
