"""Forced motion against closed forms and tight reference integrations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from twin import rolling
from twin.errors import ModelError
from twin.model import Twin


def reference(model, forces, t):
    """Accelerations and displacements of M x'' + R x' + K x = f, f linear between samples."""
    n = len(model.M)
    A, inverse = model.state_matrix(), np.linalg.inv(model.M)

    def rate(time, state, at, f, slope):
        state_rate = A @ state
        state_rate[n:] += inverse @ (f + slope * (time - at))
        return state_rate

    states = [np.zeros(2 * n)]
    slopes = np.diff(forces, axis=0) / np.diff(t)[:, None]
    # One call per sample: the integrator never steps over a corner of the force.
    for k, slope in enumerate(slopes):
        span, extra = (t[k], t[k + 1]), (t[k], forces[k], slope)
        done = solve_ivp(rate, span, states[-1], "DOP853", args=extra, rtol=1e-10, atol=1e-14)
        states.append(done.y[:, -1])
    states = np.array(states)
    return states @ A[n:].T + forces @ inverse.T, states[:, :n]


@pytest.mark.parametrize(("name", "error"), [("two_storey_lumped", 1e-6), ("two_storey", 5e-5)])
def test_forces_are_linear_between_samples_and_sample_n_belongs_to_n_over_the_rate(name, error):
    rng = np.random.default_rng(1)
    rate, samples = 100, 300
    twin, t = Twin.load(name), np.arange(samples) / rate
    forces = 1e-3 * rng.standard_normal((samples, 2))
    inputs = {"force_floor1": forces[:, 0], "force_floor2": forces[:, 1]}
    columns = twin.simulate(inputs, rate, samples).columns
    acceleration, displacement = reference(twin.second_order(), forces, t)
    for i in range(2):
        for kind, true in (("acc", acceleration[:, i]), ("disp", displacement[:, i])):
            found = columns[f"{kind}_floor{i + 1}"]
            assert np.abs(found - true).max() < error * np.abs(true).max()


def test_the_first_sample_feels_the_first_force():
    columns = Twin.load("two_storey_lumped").simulate({"force_floor1": [2.0, 0]}, 100, 2).columns
    assert columns["acc_floor1"][0] == pytest.approx(2.0 / 0.65, rel=1e-12)
    assert columns["disp_floor1"][0] == 0


def test_a_clamped_ground_does_not_move():
    columns = Twin.load("two_storey").simulate({"force_floor1": np.ones(200)}, 200, 200).columns
    assert not columns["acc_ground"].any()
    assert not columns["disp_ground"].any()


def test_a_released_ground_moves_with_its_suspension_as_the_matrices_say():
    twin = Twin.load("two_storey_lumped").released()
    forces = np.zeros((200, 3))
    forces[1:100, 2] = 0.1
    columns = twin.simulate({"force_ground": forces[:, 2]}, 100, 200).columns
    _, displacement = reference(twin.second_order(), forces, np.arange(200) / 100)
    found = np.column_stack([columns[f"disp_{p}"] for p in ("floor1", "floor2", "ground")])
    assert np.abs(displacement[:, 2]).max() > 1e-3
    assert np.abs(found - displacement).max() < 1e-6 * np.abs(displacement).max()


def test_the_whole_frame_on_its_suspension_has_the_frequency_of_one_body():
    model = Twin.load("two_storey_lumped").released().second_order()
    together = np.ones(3)
    omega = np.sqrt(together @ model.K @ together / (together @ model.M @ together))
    assert omega == pytest.approx(2 * np.pi * 0.5, rel=1e-9)


@pytest.mark.parametrize("released", [False, True])
def test_a_shaken_ground_drives_the_frame_as_minus_m_times_its_acceleration(released):
    rng = np.random.default_rng(2)
    rate, samples = 100, 300
    twin = Twin.load("two_storey_lumped")
    ground = rng.standard_normal(samples)
    model = twin.second_order()
    t = np.arange(samples) / rate
    relative, _ = reference(model, np.outer(-ground, model.M.sum(axis=1)), t)
    shaken = twin.released() if released else twin
    columns = shaken.simulate({}, rate, samples, ground_acceleration=ground).columns
    np.testing.assert_allclose(columns["acc_ground"], ground, atol=1e-7)
    for i in range(2):
        true = relative[:, i] + ground
        assert np.abs(columns[f"acc_floor{i + 1}"] - true).max() < 1e-6 * np.abs(true).max()


def test_same_inputs_same_motion_bit_for_bit():
    rng = np.random.default_rng(3)
    force = {"force_floor2": rng.standard_normal(9000)}
    first, second = (Twin.load("two_storey_absorber").simulate(force, 1000, 9000) for _ in "12")
    assert first.qpos.tobytes() == second.qpos.tobytes()
    for name, values in first.columns.items():
        assert values.tobytes() == second.columns[name].tobytes()


def test_the_error_falls_with_the_fourth_power_of_the_step():
    forces = 1e-3 * np.random.default_rng(4).standard_normal((300, 2))
    forces[:, 1] = 0
    twin = Twin.load("two_storey_lumped")
    _, true = reference(twin.second_order(), forces, np.arange(300) / 100)
    error = []
    for step in ("0.002", "0.001", "0.0005"):
        mjcf = twin.mjcf.replace('timestep="0.001"', f'timestep="{step}"')
        found = Twin(mjcf).simulate({"force_floor1": forces[:, 0]}, 100, 300).columns
        error.append(np.abs(found["disp_floor1"] - true[:, 0]).max())
    np.testing.assert_allclose(np.divide(error[:-1], error[1:]), 16, rtol=0.1)


def test_a_run_in_several_chunks_has_no_seam_and_tells_its_progress(monkeypatch):
    force = np.random.default_rng(4).standard_normal(1000)
    twin = Twin.load("two_storey_lumped")
    whole = twin.simulate({"force_floor1": force}, 250, 1000)
    monkeypatch.setattr(rolling, "CHUNK", 900)
    told = []
    pieces = twin.simulate({"force_floor1": force}, 250, 1000, progress=told.append)
    np.testing.assert_array_equal(pieces.qpos, whole.qpos)
    np.testing.assert_array_equal(pieces.columns["acc_floor2"], whole.columns["acc_floor2"])
    assert told == pytest.approx([0.225, 0.45, 0.675, 0.9, 1.0])


def test_short_runs_are_the_beginning_of_longer_ones():
    force = np.random.default_rng(5).standard_normal(9000)
    twin = Twin.load("two_storey_lumped")
    long = twin.simulate({"force_floor1": force}, 1000, 9000).columns["acc_floor1"]
    short = twin.simulate({"force_floor1": force[:100]}, 1000, 100).columns["acc_floor1"]
    np.testing.assert_array_equal(short, long[:100])


def test_shipped_models_are_found_from_any_working_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert Twin.load("two_storey").floors == ("floor1", "floor2")
    assert Twin.load("one_storey.xml").floors == ("floor1",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hello", "XML parse error"),
        ("", "empty"),
        ("<mujoco><worldbody><body><geom/></body></worldbody>", "XML"),
        ("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>", "does not compile"),
    ],
)
def test_an_mjcf_that_does_not_compile_gets_one_line(tmp_path, text, message):
    path = tmp_path / "mine.xml"
    path.write_text(text)
    with pytest.raises(ModelError, match=message) as error:
        Twin.load(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_model_that_is_not_there_gets_the_names_of_those_that_are():
    with pytest.raises(ModelError, match=r"one_storey, .*two_storey, two_storey_absorber"):
        Twin.load("three_storey")


def test_a_model_without_a_ground_joint_cannot_be_released():
    mjcf = Twin.load("two_storey_lumped").mjcf
    renamed = mjcf.replace('<joint name="ground"', '<joint name="rail"').replace(
        'joint1="ground"', 'joint1="rail"'
    )
    with pytest.raises(ModelError, match="no joint 'ground'; joints are rail, storey1, storey2"):
        Twin(renamed).released()


def test_a_diverging_simulation_is_an_error_and_not_nan(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mjcf = Twin.load("two_storey_lumped").mjcf.replace('damping="0.28', 'damping="-500.28')
    tap = np.zeros(2000)
    tap[0] = 1
    with pytest.raises(ModelError, match="the motion diverges between"):
        Twin(mjcf, "mine").simulate({"force_floor1": tap}, 100, 2000)
    assert not list(tmp_path.iterdir())


def test_a_mode_that_does_not_oscillate_is_a_model_error():
    mjcf = Twin.load("two_storey_lumped").mjcf.replace('stiffness="518', 'stiffness="-518')
    with pytest.raises(ModelError, match=r"mine: .* unstable in stiffness"):
        Twin(mjcf, "mine").modes()


def test_a_timestep_of_zero_is_refused():
    mjcf = Twin.load("one_storey").mjcf.replace('timestep="0.001"', 'timestep="0"')
    with pytest.raises(ModelError, match="timestep must be positive"):
        Twin(mjcf).simulate({}, 100, 10)


@pytest.mark.parametrize(
    ("forces", "rate", "samples", "message"),
    [
        ({"force_floor9": np.ones(5)}, 100, 5, "no actuator 'force_floor9'; it has force_ground"),
        ({"force_floor1": np.ones(4)}, 100, 5, r"'force_floor1' has shape \(4,\), expected \(5,\)"),
        ({"force_floor1": [0, np.nan, 0]}, 100, 3, "sample 2 of 'force_floor1' is not finite"),
        ({}, 0, 5, "rate must be positive"),
        ({}, np.nan, 5, "rate must be positive"),
        ({}, 100, 0, "at least one sample"),
    ],
)
def test_impossible_inputs_are_named(forces, rate, samples, message):
    with pytest.raises(ModelError, match=message):
        Twin.load("one_storey").simulate(forces, rate, samples)


def test_a_motion_cannot_be_changed():
    motion = Twin.load("one_storey").simulate({}, 100, 5)
    with pytest.raises(ValueError, match="read-only"):
        motion.qpos[0] = 1
    assert motion.samples == 5


def test_joint_positions_belong_to_the_same_samples_as_the_sensors():
    force = np.random.default_rng(6).standard_normal(200)
    motion = Twin.load("two_storey_lumped").simulate({"force_floor1": force}, 100, 200)
    np.testing.assert_allclose(motion.qpos[:, 0], motion.columns["disp_floor1"], atol=1e-15)
    np.testing.assert_allclose(motion.qpos.sum(axis=1), motion.columns["disp_floor2"], atol=1e-15)
