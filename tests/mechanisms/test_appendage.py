"""What hangs on a structure: its pull, and how it is looked for."""

import numpy as np
import pytest

from twin.mechanisms.appendage import Appendage
from twin.mechanisms.stiffness import Stiffness

HUNG = Appendage("floor1", 0.2, 3.0, 0.04)


@pytest.mark.parametrize("frequency", [0.3, 2.8, 3.0, 9.0])
def test_its_pull_is_that_of_a_mass_on_a_spring_and_a_dashpot(frequency):
    """In steady state, against the complex amplitude of its equation of motion."""
    step_s = 1 / 2048
    time = np.arange(round(60 / step_s)) * step_s
    pull = HUNG.reaction(np.cos(2 * np.pi * frequency * time), step_s)
    s = 2j * np.pi * frequency
    # m (r'' + a) + c r' + k r = 0 of the relative motion r; the support feels -(c r' + k r)
    relative = -HUNG.mass / (HUNG.mass * s**2 + HUNG.damping * s + HUNG.stiffness)
    expected = -(HUNG.damping * s + HUNG.stiffness) * relative
    late = slice(len(time) // 2, None)
    steady = np.real(expected * np.exp(s * time))
    np.testing.assert_allclose(pull[late], steady[late], atol=2e-3 * abs(expected))


def test_slowly_it_is_a_mass_that_goes_along():
    time = np.arange(40960) / 1024
    slow = 1 - np.exp(-time / 4)
    np.testing.assert_allclose(HUNG.reaction(slow, 1 / 1024)[-1], HUNG.mass * slow[-1], rtol=2e-3)


def test_light_ones_differ_in_frequency_alone():
    light = HUNG.light([1.0, 2.0])
    assert [one.frequency for one in light] == [1.0, 2.0]
    assert {one.mass for one in light} == {HUNG.mass / 50}
    assert Stiffness("storey1", 3.0).light([1.0]) == ()
