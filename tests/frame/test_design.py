import math

import pytest

from twin.errors import ModelError
from twin.frame import FrameDesign, Ground, Pendulum, Storey


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize(
    ("part", "name"),
    [(Storey, "floor_mass"), (Storey, "beam_length"), (Pendulum, "mass"), (Ground, "frequency_hz")],
)
def test_a_quantity_that_must_be_positive_is_named_when_it_is_not(part, name, value):
    with pytest.raises(ModelError, match=f"{part.__name__}: {name} must be positive"):
        part(**{name: value})


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"storeys": ()}, "at least one storey"),
        ({"kind": "rubber"}, "unknown kind 'rubber'; kinds are lumped, pseudo_rigid, hinge_chain"),
        ({"segments": 1}, "2 segments or more"),
        ({"damping_ratio": ()}, "damping must be given"),
        ({"damping_ratio": (-0.1,)}, "not negative"),
        ({"damping_ratio": (1.0,)}, "below 1"),
        ({"rayleigh": (0.1, math.nan)}, "not negative"),
        ({"gravity": -9.81}, "gravity"),
    ],
)
def test_a_design_that_cannot_be_says_why(wrong, message):
    with pytest.raises(ModelError, match=message):
        FrameDesign(**wrong)


def test_a_pendulum_has_no_negative_damping_and_a_known_reference_for_its_inertia():
    with pytest.raises(ModelError, match="damping must not be negative"):
        Pendulum(damping=-1.0)
    with pytest.raises(ModelError, match="not centre or pivot"):
        Pendulum(inertia_about="tip")


def test_total_mass_counts_ground_floors_beams_and_pendulum():
    beams = 2 * 2 * 7850 * 0.035 * 0.001 * 0.3
    assert FrameDesign(kind="lumped").total_mass == pytest.approx(3 + 0.65 + 1.55)
    assert FrameDesign(pendulum=Pendulum()).total_mass == pytest.approx(5.2 + beams + 0.083)


def test_a_tall_frame_needs_a_storey():
    with pytest.raises(ModelError, match="at least one storey"):
        FrameDesign.tall(0)
