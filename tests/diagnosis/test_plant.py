"""The plant: its transfer, its discretisation, and all that may enter it."""

import numpy as np
import pytest
from diagnosis_support import K1, M1, ONE, R1, RATE, TWO, error, motion, rough, tones
from scipy.linalg import expm, solve_continuous_lyapunov

from twin import mechanisms
from twin.diagnosis.filtering import ahead, recursion
from twin.diagnosis.plant import build, sampled
from twin.errors import ModelError

ALL = mechanisms.vocabulary()
FORCE, ACC = ("force_floor1",), ("acc_floor1",)
OMEGA = 2 * np.pi * np.array([0.01, 0.7, 3.1, 3.2, 9.0, 60.0])


def response(plant, omega=OMEGA):
    """Outputs from measured inputs at angular frequencies, (frequencies, m, r)."""
    eye = np.eye(len(plant.A))
    return np.array(
        [plant.C @ np.linalg.solve(1j * w * eye - plant.A, plant.B) + plant.D for w in omega]
    )


def played(plant, u, rate=RATE, held=False):
    """Outputs of the sampled plant from rest, (samples, m)."""
    found = sampled(plant, 1 / rate, held)
    x = recursion(found.A, u @ found.B0.T + ahead(u) @ found.B1.T)
    return x @ plant.C.T + u @ plant.D.T


def test_one_storey_s_transfer_is_the_closed_form():
    found = response(build(ONE, (), FORCE, ("disp_floor1", "acc_floor1")))
    receptance = 1 / (K1 + 1j * OMEGA * R1 - OMEGA**2 * M1)
    np.testing.assert_allclose(found[:, 0, 0], receptance, rtol=1e-11)
    np.testing.assert_allclose(found[:, 1, 0], -(OMEGA**2) * receptance, rtol=1e-9, atol=1e-13)


def test_a_shaken_ground_moves_every_floor_and_the_accelerometers_with_it():
    found = response(build(ONE, (), ("acc_ground",), ("disp_floor1", "acc_floor1")))
    relative = -M1 / (K1 + 1j * OMEGA * R1 - OMEGA**2 * M1)
    np.testing.assert_allclose(found[:, 0, 0], relative, rtol=1e-11)
    transmitted = (K1 + 1j * OMEGA * R1) / (K1 + 1j * OMEGA * R1 - OMEGA**2 * M1)
    np.testing.assert_allclose(found[:, 1, 0], transmitted, rtol=1e-9)


def test_a_channel_at_a_place_that_the_model_lacks_sees_nothing():
    found = response(build(ONE, (), ("force_floor1", "force_ground"), ("acc_floor1", "acc_ground")))
    assert not found[:, 1].any()
    assert not found[:, :, 1].any()
    assert found[:, 0, 0].all()


def test_changes_of_the_structure_are_in_the_plant():
    changes = (ALL["mass"]("floor1", 0.5), ALL["stiffness"]("storey1", -100.0))
    plant = build(ONE, changes, FORCE, ACC)
    poles = np.linalg.eigvals(plant.A)
    np.testing.assert_allclose(np.abs(poles) ** 2, (K1 - 100) / (M1 + 0.5), rtol=1e-12)
    assert plant.model.M[0, 0] == M1 + 0.5


def test_a_place_that_is_not_there_is_an_error():
    with pytest.raises(ModelError, match="no port 'storey3'; there are storey1, storey2"):
        build(TWO, (ALL["cubic_stiffness"]("storey3", 1.0),), FORCE, ACC)


@pytest.mark.parametrize("held", [False, True], ids=["lines", "held"])
def test_the_discretisation_is_exact_for_what_inputs_do_between_samples(held):
    forces = np.column_stack([rough(200, 1), rough(200, 2)])
    names = ("force_floor1", "force_floor2")
    plant = build(TWO, (), names, ("disp_floor1", "disp_floor2", "acc_floor1", "acc_floor2"))
    x, _, acc = motion(TWO, forces, held=held)
    found = played(plant, forces, held=held)
    assert error(found[:, :2], x) < 1e-9
    # the last sample has no next one
    assert error(found[:-1, 2:], acc[:-1]) < 1e-9
    other = played(plant, forces, held=not held)
    assert error(other[:, :2], x) > 0.02, "the test shows something"


def test_a_law_s_known_force_acts_as_the_law_itself_does():
    law = ALL["cubic_stiffness"]("storey2", 2e7)
    forces = np.column_stack([tones(600, seed=3, scale=4.0), np.zeros(600)])
    rate = 1024.0
    x, _, acc = motion(TWO, forces, rate, law=lambda d, v: 2e7 * d**3, b=[-1, 1])
    force = 2e7 * (x[:, 1] - x[:, 0]) ** 3
    names = ("force_floor1", "force_floor2", "law_0_storey2")
    plant = build(TWO, (), names, ("disp_floor1", "acc_floor2"))
    found = played(plant, np.column_stack([forces, force]), rate)
    # straight lines between samples lose (w h)^2 / 12 of the force: 3e-4 at 10 Hz
    assert error(found[:, 0], x[:, 0]) < 5e-4
    assert error(found[:-1, 1], acc[:-1, 1]) < 5e-4
    without = played(plant, np.column_stack([forces, 0 * force]), rate)
    assert error(without[:, 0], x[:, 0]) > 0.05, "the test shows something"
    with_law = build(TWO, (law,), names[:2], ("disp_floor1", "acc_floor2"))
    np.testing.assert_array_equal(with_law.E[:, 0], plant.B[:, 2])
    np.testing.assert_array_equal(with_law.F[:, 0], plant.D[:, 2])


def test_drift_and_rate_of_a_law_are_read_off_the_states():
    laws = (ALL["cubic_stiffness"]("storey2", 1.0), ALL["quadratic_drag"]("floor1", 1.0))
    plant = build(TWO, laws, FORCE, ACC)
    state = np.array([0.1, 0.4, 2.0, 7.0])
    np.testing.assert_allclose(plant.drift @ state, [0.3, 0.1])
    np.testing.assert_allclose(plant.rate @ state, [5.0, 2.0])


def test_a_high_pass_channel_is_its_transfer_times_the_sound_one():
    corner = 0.8
    plain = build(TWO, (), FORCE, ("acc_floor1", "acc_floor2"))
    fault = ALL["sensor_highpass"]("acc_floor2", corner)
    found = response(build(TWO, (fault,), FORCE, ("acc_floor1", "acc_floor2")))
    s = 1j * OMEGA
    wanted = response(plain)[:, 1, 0] * s / (s + 2 * np.pi * corner)
    np.testing.assert_allclose(found[:, 1, 0], wanted, rtol=1e-10, atol=1e-14)
    np.testing.assert_allclose(found[:, 0], response(plain)[:, 0], rtol=1e-9)


def test_a_high_pass_passes_forces_of_laws_and_noise_too():
    law, fault = ALL["cubic_stiffness"]("storey1", 1.0), ALL["sensor_highpass"]("acc_floor1", 0.8)
    plant = build(ONE, (law, fault), FORCE, ACC)
    for enter, direct in ((plant.E, plant.F), (plant.G, plant.L), (plant.B, plant.D)):
        assert plant.C @ np.linalg.solve(-plant.A, enter) + direct == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(("frequency", "bandwidth"), [(2.0, 0.05), (5.0, 12.0)])
def test_a_disturbance_has_its_rms_at_all_times_and_in_its_band(frequency, bandwidth):
    force = ALL["unmeasured_force"]("floor1", 0.7, frequency, bandwidth)
    plant = build(TWO, (force,), FORCE, ACC)
    P = solve_continuous_lyapunov(plant.A, -plant.drive @ plant.drive.T)
    assert np.sqrt(P[-2, -2]) == pytest.approx(0.7, rel=1e-9)
    assert np.sqrt(P[-1, -1]) == pytest.approx(0.7 * 2 * np.pi * frequency, rel=1e-9)
    found = sampled(plant, 1 / RATE)
    np.testing.assert_allclose(found.A @ P @ found.A.T + found.Q, P, rtol=1e-9, atol=1e-14)


def test_a_disturbance_pushes_its_place_with_its_first_state():
    plant = build(TWO, (ALL["unmeasured_force"]("floor2", 0.7, 2.0, 0.1),), ("force_floor2",), ACC)
    np.testing.assert_allclose(plant.A[:4, -2], plant.B[:4, 0], atol=1e-15)
    assert not plant.A[:4, -1].any()


def test_an_unmeasured_shake_of_the_ground_acts_as_a_measured_one():
    shake = ALL["unmeasured_force"]("ground", 0.7, 2.0, 0.1)
    outputs = ("acc_floor1", "disp_floor2")
    plant = build(TWO, (shake,), ("acc_ground",), outputs)
    np.testing.assert_allclose(plant.A[:4, -2], plant.B[:4, 0], rtol=1e-12)
    np.testing.assert_allclose(plant.C[:, -2], plant.D[:, 0], rtol=1e-12)


def test_noise_between_samples_is_the_integral_of_its_covariance():
    plant = build(TWO, (ALL["unmeasured_force"]("floor1", 0.7, 2.0, 0.3),), FORCE, ACC)
    step, W = 0.05, plant.drive @ plant.drive.T
    t, weight = np.polynomial.legendre.leggauss(12)
    t = (t + 1) * step / 2
    parts = [
        w * expm(plant.A * s) @ W @ expm(plant.A.T * s) for s, w in zip(t, weight, strict=True)
    ]
    wanted = np.sum(parts, axis=0) * step / 2
    found = sampled(plant, step).Q
    np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-12 * wanted.max())
