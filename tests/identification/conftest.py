"""A linear two-storey frame whose answers are known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from twin.recording import Recording
from twin.second_order import SecondOrderModel

K1 = 24 * 2.0e11 * 2.917e-12 / 0.3**3
FS = 32.0


@pytest.fixture(scope="session")
def frame() -> SecondOrderModel:
    M = np.diag([0.65, 1.55])
    K = np.array([[2 * K1, -K1], [-K1, K1]])
    stiffness, shapes = linalg.eigh(K, M)
    damping = np.diag(2 * np.array([0.0118, 0.0039]) * np.sqrt(stiffness))
    return SecondOrderModel(M, M @ shapes @ damping @ shapes.T @ M, K, ("floor1", "floor2"))


@pytest.fixture(scope="session")
def held_hit(frame: SecondOrderModel) -> Recording:
    """The hammer test on data that OKID/ERA is exact for: no noise, force held."""
    u = np.zeros((1024, 1))
    u[16:18, 0] = 0.6, 0.3
    y = frame.acceleration_response(("floor1",)).held(1 / FS).simulate(u)
    columns = {"force_floor1": u[:, 0], "acc_floor1": y[:, 0], "acc_floor2": y[:, 1]}
    return Recording.build(FS, columns, source="held.csv")
