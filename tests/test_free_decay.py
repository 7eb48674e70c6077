"""Simulated free decay against the model's eigenvalues, by the twin and in plain MuJoCo."""

import importlib.util
from pathlib import Path

import mujoco
import numpy as np
import pytest

from twin.frame import PLANE, FrameDesign, Pendulum
from twin.model import Twin
from twin.model_files import shipped

SCRIPT = Path(__file__).parents[1] / "experiments" / "integrator_accuracy.py"
if not SCRIPT.exists():
    pytest.skip("experiments/ is not beside the tests", allow_module_level=True)
SPEC = importlib.util.spec_from_file_location("integrator_accuracy", SCRIPT)
accuracy = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(accuracy)


def test_the_estimate_is_exact_for_a_sum_of_damped_modes():
    t = np.arange(2500) / 125
    poles = 2 * np.pi * np.array([1.7, 5.8]) * np.exp(1j * (np.pi / 2 + np.arcsin([0.01, 0.004])))
    shapes = np.array([[1, 1], [1.6, -0.3]])
    freq, damping = accuracy.decay_modes((shapes * 1e-3 @ np.exp(np.outer(poles, t))).real.T, 125)
    np.testing.assert_allclose(freq, [1.7, 5.8], rtol=1e-9)
    np.testing.assert_allclose(damping, [0.01, 0.004], rtol=1e-8)


@pytest.mark.parametrize("released", [False, True])
@pytest.mark.parametrize("name", PLANE)
def test_free_decay_has_the_eigenvalues_within_0_02_percent(name, released):
    twin = Twin.load(name)
    freq, damping = accuracy.errors(twin.released() if released else twin)
    assert np.max(np.abs([freq, damping])) < 0.02


@pytest.mark.parametrize("rate", [64, 250, 1000, 2000])
def test_the_decay_does_not_depend_on_the_sampling_rate(rate):
    freq, damping = accuracy.errors(Twin.load("two_storey"), rate)
    assert np.max(np.abs([freq, damping])) < 0.02


def test_ten_storeys_decay_with_their_eigenvalues():
    twin = Twin.of(FrameDesign.tall(10, "lumped"))
    freq, damping = accuracy.errors(twin)
    assert np.max(np.abs(freq)) < 0.02
    assert np.max(np.abs(damping)) < 0.02


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "discrete"])
def test_the_integrator_that_a_file_asks_for_does_not_spoil_the_motion(integrator):
    mjcf = Twin.load("two_storey_lumped").mjcf.replace('"RK4"', f'"{integrator}"')
    freq, damping = accuracy.errors(Twin(mjcf))
    assert np.max(np.abs([freq, damping])) < 1e-3


@pytest.mark.parametrize("name", PLANE)
def test_the_file_in_plain_mujoco_has_the_same_frequencies(name):
    model = mujoco.MjModel.from_xml_path(str(shipped(name)))
    data = mujoco.MjData(model)
    places = [f"acc_{place}" for place in Twin.load(name).floors]
    places += ["angle_pendulum"] * (PLANE[name].pendulum is not None)
    address = [model.sensor(place).adr[0] for place in places]
    decay = np.empty((16000, len(address)))
    data.ctrl[model.actuator("force_floor1").id] = 2e-2
    for row in decay:
        mujoco.mj_step(model, data)
        row[:] = data.sensordata[address]
        data.ctrl[:] = 0
    assert abs(data.joint("ground").qpos[0]) < 1e-8
    freq, _ = accuracy.decay_modes(decay[3::8], 125.0)
    np.testing.assert_allclose(freq, Twin.load(name).modes().natural_freq, rtol=1e-5)


def test_pendulum_and_frame_exchange_energy_as_the_eigenvalues_say():
    twin = Twin.of(FrameDesign(kind="lumped", pendulum=Pendulum(damping=1e-4)))
    freq, damping = accuracy.errors(twin)
    assert np.max(np.abs([freq, damping])) < 0.02
