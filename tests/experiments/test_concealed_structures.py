"""Concealed cases on structures: the hand's matrices against MuJoCo, the integrator, the seal."""

import json

import mujoco
import numpy as np
import pytest
from scipy.linalg import expm

from experiments.concealed import laws
from experiments.concealed.mechanisms import Mechanism
from experiments.concealed.score import score
from experiments.concealed.steps import Opening, open_and_score
from experiments.concealed.structures.cases import generate_structure
from experiments.concealed.structures.effects import changed, moved
from experiments.concealed.structures.frames import PORTAL, frame
from experiments.concealed.structures.kinds import KINDS, group_of, places_of
from experiments.concealed.structures.measuring import read_csv
from experiments.concealed.structures.plan import Trial, draw_trials, signals
from experiments.concealed.structures.slender import beam
from experiments.concealed.structures.stepping import simulate, system_of
from experiments.concealed.tables import STRUCTURES
from twin.linearise import linearise
from twin.model import Twin
from twin.model.free_run import free_run
from twin.model_files import shipped


def told(table):
    return mujoco.MjModel.from_xml_path(str(shipped(KINDS[table].model)))


@pytest.mark.parametrize("table", KINDS)
def test_the_hands_matrices_have_the_modes_of_the_model_that_is_told(table):
    built = KINDS[table].assemble({})
    theirs = linearise(told(table)).generalised
    n = built.size
    state = np.block([[np.zeros((n, n)), np.eye(n)],
                      [-np.linalg.solve(built.mass, built.stiffness),
                       -np.linalg.solve(built.mass, built.damping)]])  # fmt: skip
    ours = np.sort_complex(np.linalg.eigvals(state))
    np.testing.assert_allclose(ours, np.sort_complex(np.linalg.eigvals(theirs.state_matrix())),
                               rtol=1e-6, atol=1e-6)  # fmt: skip


@pytest.mark.parametrize("table", ["portal", "rotated", "beam"])
def test_forces_and_sensors_are_where_the_model_has_them(table):
    built, model = KINDS[table].assemble({}), told(table)
    data = mujoco.MjData(model)
    compliance = np.linalg.inv(built.mass)
    for name, drive in built.drives.items():
        data.ctrl[:] = np.eye(model.nu)[model.actuator(name).id]
        mujoco.mj_forward(model, data)
        for channel, sensor in built.sensors.items():
            element, _, axis = channel.partition(".")
            seen = data.sensor(element).data["xyz".index(axis)]
            assert seen == pytest.approx(sensor.acc @ compliance @ drive.row, abs=1e-7), channel


def test_a_leaning_accelerometer_sees_gravity():
    model, built = told("beam"), beam({})
    data = mujoco.MjData(model)
    data.qpos[:] = 1e-5 * np.arange(1, 11)
    mujoco.mj_inverse(model, data)
    for channel, sensor in built.sensors.items():
        seen = data.sensor(channel.partition(".")[0]).data[0]
        assert seen == pytest.approx(sensor.disp @ data.qpos, rel=1e-3)


def test_a_soft_ground_is_a_ground_that_slides():
    spec = mujoco.MjSpec.from_file(str(shipped("portal_3d")))
    body = spec.body("ground")
    body.add_joint(
        name="ground", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 1, 0],
        stiffness=[3e4, 0, 0], damping=[40.0, 0, 0],
    )  # fmt: skip
    theirs = linearise(spec.compile()).generalised
    base = Mechanism("base_compliance", "ground.y", (("stiffness", 3e4), ("damping", 40.0)))
    built = changed(frame(PORTAL, {}), [base])
    squares = np.linalg.eigvals(np.linalg.solve(theirs.M, theirs.K)).real
    np.testing.assert_allclose(built.modes()[0] ** 2, np.sort(squares), rtol=1e-6)


def test_a_table_drags_all_that_stands_on_a_soft_ground():
    base = Mechanism("base_compliance", "ground.y", (("stiffness", 3e4), ("damping", 40.0)))
    built = changed(frame(PORTAL, {}), [base])
    steady = np.linalg.solve(built.stiffness, -built.shaken["y"].coupling * 2.0)
    assert steady[-1] == pytest.approx(-built.shaken["y"].mass * 2.0 / 3e4)
    still = np.linalg.solve(built.mass, built.shaken["y"].coupling)
    np.testing.assert_allclose(still, np.eye(built.size)[-1], atol=1e-9)


def test_the_integrator_is_that_of_the_matrix_exponential():
    built = frame(PORTAL, {})
    n = built.size
    force = np.zeros((4097, 1))
    force[:, 0] = 3.0
    row = built.drives["force_floor1_x"].row
    states, _ = simulate(system_of(built, [row], []), force, 1 / 4096)
    state = np.zeros((2 * n + 1, 2 * n + 1))
    state[:n, n : 2 * n] = np.eye(n)
    state[n : 2 * n] = np.linalg.solve(
        built.mass, np.hstack([-built.stiffness, -built.damping, 3 * row[:, None]])
    )
    exact = expm(state) @ np.r_[np.zeros(2 * n), 1.0]
    np.testing.assert_allclose(states[-1], exact[:-1], rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize(
    ("table", "kind", "inputs"),
    [
        ("portal", "random", ("force_floor1_x", "force_floor2_y")),
        ("portal", "ground", ("y",)),
        ("beam", "ground", ("x",)),
        ("rotated", "hammer", ("force_b",)),
    ],
)
def test_with_nothing_concealed_the_model_that_is_told_foresees_it_all(table, kind, inputs):
    chosen = KINDS[table]
    trial = Trial("train_1", kind, inputs, 0.2, 1.0, 3)
    driven, seen, _ = moved(chosen.assemble({}), (), trial, chosen.kit)
    model = Twin.load(chosen.model).linear(tuple(driven), tuple(seen))
    predicted = free_run(model, np.column_stack(list(driven.values())), 4096.0) - model.rest
    true = np.column_stack(list(seen.values()))
    np.testing.assert_allclose(predicted, true, atol=2e-4 * np.abs(true).max())


def test_dry_friction_along_any_row_takes_the_work_that_it_should():
    built = frame(PORTAL, {})
    place = "storey2_column3_x"
    row, push = built.drifts[place], built.drives["force_floor2_x"].row
    time = np.arange(3 * 4096) / 4096
    force = 6 * np.sin(2 * np.pi * 2.0 * time)
    law = (laws.COULOMB, [0.4], row)
    states, accelerations = simulate(system_of(built, [push], [law]), force[:, None], 1 / 4096)
    q, v = states[:, :6], states[:, 6:12]
    balance = (
        accelerations @ built.mass + v @ built.damping + q @ built.stiffness - np.outer(force, push)
    )
    # what is left over is friction, along its row only, within its bounds, against the motion
    held = -balance @ row / (row @ row)
    np.testing.assert_allclose(balance, -np.outer(held, row), atol=1e-9)
    assert np.abs(held).max() <= 0.4 + 1e-9
    sliding = np.abs(v @ row) > 1e-3
    np.testing.assert_allclose(held[sliding], 0.4 * np.sign(v @ row)[sliding], atol=1e-9)


def test_an_appendage_is_one_more_mode_near_its_own_frequency():
    built = frame(PORTAL, {})
    hung = Mechanism(
        "appendage", "floor2.x", (("mass", 1e-4), ("frequency", 6.2), ("damping_ratio", 0.01))
    )
    omega = changed(built, [hung]).modes()[0] / (2 * np.pi)
    assert np.min(np.abs(omega - 6.2)) < 1e-3


def test_several_shakers_have_signals_of_their_own():
    kit = KINDS["portal"].kit
    trial = Trial("train_1", "random", ("force_floor1_x", "force_floor2_y"), 2.0, 20.0, 3)
    both = signals(trial, kit)
    np.testing.assert_allclose(np.sqrt(np.mean(both**2, axis=0)), 2.0)
    assert abs(np.corrcoef(both.T)[0, 1]) < 0.1


@pytest.mark.parametrize("table", KINDS)
def test_each_round_conceals_every_group(table):
    kind = KINDS[table]
    count = len(kind.round_)
    assert sorted(group_of(table, 1 + i, 3) for i in range(count)) == sorted(kind.round_)
    built = kind.assemble({})
    for group in set(kind.round_) - {"two", "nothing"}:
        pairs = places_of(group, table, built)
        assert pairs
        model = told(table)
        elements = {model.joint(i).name for i in range(model.njnt)}
        elements |= {model.tendon(i).name for i in range(model.ntendon)}
        elements |= {model.body(i).name for i in range(model.nbody)}
        elements |= {model.sensor(i).name for i in range(model.nsensor)}
        elements |= {model.site(i).name for i in range(model.nsite)}
        assert {place.partition(".")[0] for _, place in pairs} <= elements


def test_plans_hold_hits_shakers_and_a_shaken_ground():
    trials = draw_trials(np.random.default_rng(1), KINDS["portal"].kit, ["a", "b"])
    assert sorted(t.kind for t in trials[:4]) == ["ground", "hammer", "multisine", "random"]
    assert [t.kind for t in trials[4:]] == ["hammer", "random"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drive")
    return folder, generate_structure("drive", 4, 7, folder, folder / "sealed")


def test_the_same_seed_gives_the_same_bytes(made, tmp_path):
    folder, digest = made
    assert generate_structure("drive", 4, 7, tmp_path, tmp_path / "sealed") == digest
    for path in (folder / "drive_0004").iterdir():
        assert path.read_bytes() == (tmp_path / "drive_0004" / path.name).read_bytes()


def test_recordings_have_the_models_names_and_the_stated_noise(made):
    folder, _ = made
    names = sorted(p.name for p in (folder / "drive_0004").iterdir())
    assert names == ["test_1.csv", "test_2.csv", *(f"train_{i}.csv" for i in range(1, 5))]
    columns = read_csv(folder / "drive_0004" / "train_1.csv")
    assert list(columns) == ["force [N]", "position [m]"]
    truth = json.loads((folder / "sealed" / "drive_0004.json").read_text())
    assert truth["model"] == "drive"
    assert truth["evidence"]["change_over_noise"] > 3


def test_a_position_loop_hides_nothing_from_the_recorded_force():
    kind = KINDS["drive"]
    built = kind.assemble({})
    trial = Trial("train_1", "motion", ("force",), 0.2, 20.0, 3)
    friction = Mechanism("coulomb_friction", "slide", (("force", 20.0),))
    for effects in ((), (friction,)):
        inputs, seen, states = moved(built, effects, trial, kind.kit)
        a = np.gradient(states[:, 1], 1 / 4096)
        missing = inputs["force"] - 80.0 * a - 150.0 * states[:, 1]
        sliding = np.abs(states[:, 1]) > 0.02
        held = 20.0 * np.sign(states[:, 1]) if effects else 0.0 * a
        assert np.abs(missing - held)[sliding].max() < 1.0
        assert np.abs(seen["position"]).max() < 0.3


def test_an_answer_is_right_under_every_name_of_a_place(made, tmp_path):
    folder, digest = made
    truth = json.loads((folder / "sealed" / "drive_0004.json").read_text())
    effect = {k: truth["effects"][0][k] for k in ("mechanism", "location")}
    answer = {
        "verdict": truth["expected"],
        "findings": [{**effect, "probability": 0.9, "parameters": {}}],
        "alternatives": [],
    }
    kept = tmp_path / "answer.json"
    kept.write_text(json.dumps(answer))
    task = Opening(folder / "sealed" / "drive_0004.json", digest, folder, kept)
    assert open_and_score(task)["score"]["right"]
    portal = {"effects": [{"mechanism": "damping", "location": "storey1_rz", "parameters": {}}],
              "alike": dict(frame(PORTAL, {}).alike), "expected": "parameter"}  # fmt: skip
    named = {"mechanism": "damping", "location": "storey1_column3_rz", "probability": 0.8}
    answer = {"verdict": "parameter", "findings": [{**named, "parameters": {}}]}
    assert score(portal, answer, {})["right"]
    other = {**named, "location": "storey1_column3_x", "parameters": {}}
    assert not score(portal, {**answer, "findings": [other]}, {})["right"]


def test_the_campaign_knows_the_tables():
    assert set(STRUCTURES) == set(KINDS)
