import numpy as np
import pytest

from twin.errors import ModelError
from twin.frame import FrameDesign, Pendulum, Storey
from twin.model import Twin


@pytest.mark.parametrize("kind", ["lumped", "pseudo_rigid", "hinge_chain"])
def test_every_mode_has_the_damping_ratio_asked_for(kind):
    ratios = (0.03, 0.002, 0.011)
    modes = Twin.of(FrameDesign((Storey(),) * 3, kind, 4, damping_ratio=ratios)).modes()
    asked = np.r_[ratios, np.full(len(modes.damping_ratio) - 3, ratios[-1])]
    np.testing.assert_allclose(modes.damping_ratio, asked, rtol=1e-6)


def test_modal_damping_leaves_the_shapes_real_and_the_frequencies_alone():
    linear = Twin.load("two_storey").linearisation()
    damped, undamped = linear.modes(), linear.undamped_modes()
    np.testing.assert_allclose(damped.natural_freq, undamped.natural_freq, rtol=1e-9)
    np.testing.assert_allclose(np.abs(np.sin(damped.phase)), 0, atol=1e-6)


@pytest.mark.parametrize("kind", ["lumped", "pseudo_rigid"])
def test_rayleigh_damping_is_alpha_m_plus_beta_k(kind):
    model = Twin.of(FrameDesign(kind=kind, rayleigh=(0.28, 3.0e-5))).second_order()
    np.testing.assert_allclose(model.R, 0.28 * model.M + 3.0e-5 * model.K, rtol=2e-6)


def test_damping_does_not_resist_the_frame_sliding_as_a_whole():
    design = FrameDesign(rayleigh=(5.0, 0.0))
    released = Twin.of(design).released().second_order()
    together = np.ones(3)
    _, suspension = design.suspension
    assert together @ released.R @ together == pytest.approx(suspension, rel=1e-7)


def test_the_pendulum_adds_no_damping_of_its_own_unless_asked():
    still = Twin.of(FrameDesign(pendulum=Pendulum())).second_order().R
    bare = Twin.load("two_storey").second_order().R
    np.testing.assert_allclose(still[:2, :2], bare, rtol=1e-6)
    np.testing.assert_allclose(still[2], 0, atol=1e-9)
    stiff = Twin.of(FrameDesign(pendulum=Pendulum(damping=0.002))).second_order().R
    assert stiff[2, 2] == pytest.approx(0.002, rel=1e-9)


def test_a_frame_that_buckles_is_refused():
    with pytest.raises(ModelError, match="buckles under its own weight"):
        Twin.of(FrameDesign((Storey(50.0),)))


def test_a_frame_of_next_to_no_mass_is_refused():
    with pytest.raises(ModelError, match="FrameDesign: does not compile"):
        Twin.of(FrameDesign((Storey(beam_density=1e-12),)))
