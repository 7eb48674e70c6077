"""The paper's lumped frame, eqs. (2)-(10)."""

import numpy as np
import pytest

from twin.frame import FrameDesign, Storey
from twin.model import Twin

LUMPED = Twin.of(FrameDesign(kind="lumped"))


def test_a_storey_has_the_stiffness_of_equation_7():
    assert Storey().stiffness == pytest.approx(24 * 2.0e11 * 2.917e-12 / 0.3**3, rel=1e-14)


def test_mass_and_stiffness_matrix_are_those_of_equations_5_and_6():
    k = 24 * 2.0e11 * 2.917e-12 / 0.3**3
    model = LUMPED.second_order()
    assert model.coordinates == ("floor1", "floor2")
    np.testing.assert_allclose(model.M, np.diag([0.65, 1.55]), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(model.K, [[2 * k, -k], [-k, k]], rtol=1e-10)


def test_frequencies_shapes_and_phases_are_those_printed_in_equations_9_and_10():
    modes = LUMPED.second_order().undamped_modes()
    assert [f"{f:.3f}" for f in modes.natural_freq] == ["1.949", "6.715"]
    assert [[f"{a:.3f}" for a in row] for row in modes.amplitude.T] == [
        ["1.000", "1.812"],
        ["1.000", "0.231"],
    ]
    # The paper cuts pi to 3.141.
    assert np.trunc(1e3 * np.abs(modes.phase.T)).tolist() == [[0, 0], [0, 3141]]


@pytest.mark.parametrize("storeys", [1, 3, 10])
def test_equal_storeys_have_the_closed_form_frequencies_of_a_uniform_shear_building(storeys):
    frame = Twin.of(FrameDesign((Storey(0.8),) * storeys, "lumped"))
    r = np.arange(1, storeys + 1)
    omega = 2 * np.sqrt(Storey().stiffness / 0.8) * np.sin((2 * r - 1) * np.pi / (4 * storeys + 2))
    found = frame.second_order().undamped_modes().natural_freq
    np.testing.assert_allclose(2 * np.pi * found, omega, rtol=1e-9)
