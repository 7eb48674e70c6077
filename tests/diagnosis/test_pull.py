"""What something light does beside a motion, against the equations of the structure that has it."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, tones
from scipy.signal import lsim

from twin.diagnosis.motion import Motion
from twin.diagnosis.pull import pull_of
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.stiffness import Stiffness

RATE, STILL = 512.0, 0.02
FORCE = tones(8192, RATE)


def moved(model):
    """Motion and outputs of a linear model that is pushed, (N, n) and (N, m)."""
    system = model.state_space()
    time = np.arange(len(FORCE)) / RATE
    _, y, x = lsim((system.A, system.B, system.C, system.D), FORCE[:, None], time)
    n = len(model.coordinates)
    q, v = x[:, :n], x[:, n : 2 * n]
    return Motion(q, v, np.gradient(v, 1 / RATE, axis=0)), y


@pytest.fixture(scope="module")
def plain():
    return lumped().linear(("force_floor2",), ("acc_floor1", "acc_floor2"))


@pytest.mark.parametrize(
    "light",
    [
        Appendage("floor1", 2e-4, 3.0, 0.04),
        Appendage("floor2", 1e-4, 12.0, 0.02),
    ],
)
def test_to_first_order_it_moves_the_structure_as_its_equations_do(plain, light):
    motion, without = moved(plain)
    _, true = moved(light.edit(plain))
    change = true - without
    row = plain.port(light.place)
    pull = pull_of(light.edit(plain), plain, row, motion, 1 / RATE)
    # the force, on the structure without it
    driven = replace(plain, B=-row[:, None])
    system = driven.state_space()
    through = -plain.Ca @ np.linalg.solve(plain.M, row)
    time = np.arange(len(FORCE)) / RATE
    _, answer, _ = lsim((system.A, system.B, system.C, through[:, None]), pull[:, None], time)
    error = np.sqrt(np.mean((answer - change) ** 2))
    assert error < STILL * np.sqrt(np.mean(change**2))


def test_light_ones_differ_in_frequency_alone():
    hung = Appendage("floor1", 0.2, 3.0, 0.04)
    light = hung.scaled(1 / 50).light([1.0, 2.0])
    assert [one.frequency for one in light] == [1.0, 2.0]
    assert {one.mass for one in light} == {hung.mass / 50}
    assert Stiffness("storey1", 3.0).light([1.0]) == ()
