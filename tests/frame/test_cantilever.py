"""The cantilever and the drive against mechanics written out by hand."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh

from twin.errors import ModelError
from twin.frame import CantileverDesign, DriveDesign, to_mjcf
from twin.linearise import linearise

DESIGN = CantileverDesign()


def by_hand(design):
    """M and K of the joint angles, the potential of the weight included."""
    n, h = design.hinges, design.element
    density = design.mass / design.length
    inertia_of = design.thickness**2 / 12
    mass = np.zeros((n, n))
    stiffness = np.diag(np.full(n, design.hinge_stiffness))
    feet = (np.arange(n) + 0.5) * h
    for i, foot in enumerate(feet):
        length = design.length - foot if i == n - 1 else h
        m, middle = density * length, foot + length / 2
        # a piece moves by the height over each hinge below it, and turns by their sum
        move = np.where(np.arange(n) <= i, middle - feet, 0.0)
        turn = np.where(np.arange(n) <= i, 1.0, 0.0)
        mass += m * np.outer(move, move)
        mass += m * (length**2 / 12 + inertia_of) * np.outer(turn, turn)
        # it sinks by the sum over pieces below of length times half the angle squared
        for j in range(i + 1):
            below = np.where(np.arange(n) <= j, 1.0, 0.0)
            arm = (h if j < i else length / 2) if j < n - 1 else length / 2
            stiffness -= m * design.gravity * arm * np.outer(below, below)
    return mass, stiffness


def compiled(design):
    return mujoco.MjModel.from_xml_string(to_mjcf(design))


def test_modes_are_those_of_matrices_assembled_by_hand():
    mass, stiffness = by_hand(DESIGN)
    frequencies = np.sqrt(eigh(stiffness, mass, eigvals_only=True)) / (2 * np.pi)
    modes = linearise(compiled(DESIGN)).modes()
    np.testing.assert_allclose(modes.natural_freq, frequencies, rtol=1e-7)
    np.testing.assert_allclose(modes.damping_ratio, [0.01] + [0.006] * 9, rtol=1e-6)


def test_a_force_at_the_tip_bends_it_as_it_bends_a_beam():
    for hinges in (3, 10):
        design = replace(DESIGN, hinges=hinges, gravity=0.0, accelerometers=())
        compliance = np.linalg.inv(linearise(compiled(design)).generalised.K)
        arm = design.length - (np.arange(hinges) + 0.5) * design.element
        deflection = arm @ compliance @ arm
        assert deflection == pytest.approx(design.length**3 / (3 * design.bending), rel=1e-9)


def test_without_weight_its_first_modes_are_near_those_of_a_beam():
    design = replace(DESIGN, gravity=0.0, hinges=30)
    beam = np.array([1.8751041, 4.6940911, 7.8547574]) ** 2 / (2 * np.pi)
    beam *= np.sqrt(design.bending * design.length / design.mass / design.length**4)
    found = linearise(compiled(design)).modes().natural_freq[:3]
    np.testing.assert_allclose(found, beam, rtol=3e-3)


def test_accelerometers_and_forces_stand_at_their_heights():
    model = compiled(DESIGN)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    heights = {name: data.site(name).xpos[2] - 0.07 for name, _ in DESIGN.accelerometers}
    assert heights == pytest.approx({"acc_low": 0.216, "acc_mid": 0.408, "acc_tip": 0.6})
    assert [model.actuator(i).name for i in range(model.nu)] == ["force_mid", "force_tip"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"hinges": 1}, "two hinges or more"),
        ({"accelerometers": (("a", 1.2),)}, "a at 1.2 of the height"),
        ({"thickness": 0.0}, "thickness must be positive"),
    ],
)
def test_what_cannot_be_is_said(change, message):
    with pytest.raises(ModelError, match=message):
        replace(DESIGN, **change)


def test_a_strip_that_buckles_is_refused():
    with pytest.raises(ModelError, match="buckles under its own weight"):
        to_mjcf(replace(DESIGN, thickness=0.0003))


def test_the_drive_is_a_mass_on_a_dashpot():
    matrices = linearise(compiled(DriveDesign(95.0, 200.0))).generalised
    assert pytest.approx(np.array([[95.0]])) == matrices.M
    assert pytest.approx(np.array([[200.0]]), rel=1e-9) == matrices.R
    assert pytest.approx(np.zeros((1, 1)), abs=1e-9) == matrices.K
    with pytest.raises(ModelError, match="mass must be positive"):
        DriveDesign(mass=0.0)
