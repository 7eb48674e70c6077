"""States of filters before white noises stand beside the structure's, each as it scatters."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded
from scipy.linalg import solve_continuous_lyapunov

from twin.diagnosis.discrepancy import Discrepancy
from twin.diagnosis.plant import plant_of
from twin.diagnosis.plant_states import stationary
from twin.diagnosis.prepare import prepare
from twin.mechanisms.sensor_highpass import SensorHighpass
from twin.mechanisms.unmeasured_force import UnmeasuredForce


@pytest.fixture(scope="module")
def model():
    return prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train.model


def test_forces_before_the_first_sample_scatter_as_they_always_do(model):
    disturbance = UnmeasuredForce("floor1", 0.2, 2.0, 0.3)
    latent = [Discrepancy("storey2", 0.3, 4.0, 9.0), Discrepancy("acc_floor1", 0.05, 11.0)]
    plant = plant_of(model, (disturbance,), latent, {})
    system, n = plant.system, 2 * len(model.coordinates)
    assert len(system.A) == n + len(plant.start)
    assert np.diag(plant.start)[[0, 2]] == pytest.approx([0.3**2, 0.05**2])
    own, G = system.A[n:, n:], system.G[n:]
    stationary = solve_continuous_lyapunov(own, -G @ G.T)
    np.testing.assert_allclose(plant.start, stationary, rtol=1e-9, atol=1e-12)
    assert not np.any(system.G[:n])
    assert -own[1, 0] == pytest.approx((2 * np.pi * 4.0) ** 2)
    np.testing.assert_allclose(np.diag(own)[:3], -2 * np.pi * np.array([0.0, 9.0, 11.0]))


def test_a_latent_force_pushes_its_port_and_a_latent_reading_its_output(model):
    latent = [Discrepancy("storey2", 0.3, 4.0, 9.0), Discrepancy("acc_floor1", 0.05, 11.0)]
    plant = plant_of(model, (), latent, {})
    bare, n = plant_of(model, (), (), {}).system, 2 * len(model.coordinates)
    push = np.linalg.solve(model.M, -model.port("storey2"))
    np.testing.assert_allclose(plant.system.A[: n // 2, n:], 0.0)
    np.testing.assert_allclose(plant.system.A[n // 2 : n, n], push)
    assert not np.any(plant.system.A[:n, n + 1 :])
    np.testing.assert_allclose(plant.system.C[:, n], model.Ca @ push)
    assert not np.any(plant.system.C[:, n + 1])
    assert plant.system.C[:, n + 2].tolist() == [
        float(name == "acc_floor1") for name in model.outputs
    ]
    np.testing.assert_array_equal(plant.system.A[:n, :n], bare.A)
    np.testing.assert_array_equal(plant.system.C[:, :n], bare.C)


def response(system, columns, B, D, w):
    """What outputs show of inputs at circular frequencies w, (k, m, inputs)."""
    n = len(system.A)
    return np.array([system.C @ np.linalg.solve(1j * x * np.eye(n) - system.A, B[:, columns])
                     + D[:, columns] for x in w])  # fmt: skip


def test_an_input_that_was_high_passed_drives_the_structure_as_it_was_before(model):
    (name,) = model.inputs
    corner, w = 0.7, 2 * np.pi * np.array([0.1, 0.7, 3.0, 11.0])
    readings = {name: 2.0, **dict.fromkeys(model.outputs, 1.0)}
    bare = plant_of(model, (), (), readings).system
    plant = plant_of(model, (SensorHighpass(name, corner),), (), readings)
    system, passed = plant.system, 1j * w / (1j * w + 2 * np.pi * corner)
    whole = response(bare, [0], bare.B, bare.D, w) / passed[:, None, None]
    np.testing.assert_allclose(response(system, [0], system.B, system.D, w), whole, rtol=1e-9)
    # its noise is in the reading
    np.testing.assert_allclose(response(system, [0], system.W, system.V, w), whole, rtol=1e-9)
    assert plant.start.tolist() == [[4.0]]


def test_units_do_not_count_for_how_a_fast_filter_scatters():
    # a latent force of 280 kHz, made not to ring above half the sampling rate
    block = np.array([[-1731698.138, 0.7141429165], [-4374576724045.0, -1733303.85]])
    drive = np.array([85.228, 215301025.466])
    P = stationary(block, drive)
    left = block @ P + P @ block.T + np.outer(drive, drive)
    size = np.sqrt(np.outer(np.diag(P), np.diag(P))) * 1.7e6
    assert np.max(np.abs(left) / size) < 1e-9
