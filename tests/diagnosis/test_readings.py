"""What outputs read of what moves a structure, against its motion in time and its covariance."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, solve_continuous_lyapunov
from scipy.signal import StateSpace, dlsim

from twin.diagnosis.readings import read_of, read_of_disturbance
from twin.mechanisms.unmeasured_force import UnmeasuredForce
from twin.model.twin import Twin

STEP_S = 0.005


@pytest.fixture(scope="module")
def model():
    return Twin.load("two_storey_lumped").linear(("force_floor2",), ("acc_floor1", "acc_floor2"))


def in_state_space(model, entry, direct):
    """Return A, B, C and D from one force that enters along ``entry``."""
    system = replace(model, inputs=("one",), B=entry[:, None], Cu=direct[:, None],
                     base={}).state_space()  # fmt: skip
    return system.A, system.B, system.C, system.D


def test_of_forces_it_is_what_the_motion_shows_of_them(model):
    rng = np.random.default_rng(3)
    row = model.port("storey2")
    forces = []
    for samples in (4001, 6000):
        t = np.arange(samples) * STEP_S
        burst = np.sin(2 * np.pi * 5.3 * t) + np.sin(2 * np.pi * 11.0 * t + rng.random())
        forces.append(np.outer(burst * np.exp(-(((t - 6.0) / 1.5) ** 2)), row))
    A, B, C, D = in_state_space(model, row, np.zeros(len(model.outputs)))
    system = StateSpace(A, B, C, D).to_discrete(STEP_S, "foh")
    seen = np.vstack([dlsim(system, f @ row / (row @ row))[1] for f in forces])
    expected = np.sqrt(np.mean(seen**2, axis=0))
    assert read_of(forces, model, STEP_S) == pytest.approx(expected, rel=5e-3)


def test_a_constant_force_is_not_read(model):
    steady = np.ones((1000, 1)) * model.port("floor1")
    assert np.all(read_of([steady], model, STEP_S) < 1e-12)


@pytest.mark.parametrize(("edged", "width"), [(0.0, 3.0), (0.0, 20.0), (1.0, 3.0)])
@pytest.mark.parametrize("place", ["floor1", "ground"])
def test_of_a_disturbance_it_is_the_stationary_covariance_of_the_outputs(
    model, place, edged, width
):
    force = UnmeasuredForce(place, 0.3, 7.0, width, edged)
    if place == "ground":
        (base,) = model.base.values()
        A, B, C, D = in_state_space(model, -base.row, base.acc)
    else:
        A, B, C, D = in_state_space(model, model.port(place), np.zeros(len(model.outputs)))
    block, drive, shape = force.shaping()
    whole = block_diag(A, block)
    whole[: len(A), len(A) :] = B * shape
    entry = np.concatenate([np.zeros(len(A)), drive])
    out = np.hstack([C, D * shape])
    covariance = solve_continuous_lyapunov(whole, -np.outer(entry, entry))
    expected = np.sqrt(np.diag(out @ covariance @ out.T))
    found = read_of_disturbance(force, [40001, 60000], model, STEP_S)
    assert found == pytest.approx(expected, rel=0.01)


def test_a_sinusoid_is_read_in_full_however_narrow_it_is(model):
    hz = 6.013  # between two lines of the spectrum
    force = UnmeasuredForce("floor1", 0.3, hz, 0.0)
    A, B, C, D = in_state_space(model, model.port("floor1"), np.zeros(len(model.outputs)))
    G = C @ np.linalg.solve(2j * np.pi * hz * np.eye(len(A)) - A, B) + D
    found = read_of_disturbance(force, [8000], model, STEP_S)
    assert found == pytest.approx(0.3 * np.abs(G[:, 0]), rel=0.03)
