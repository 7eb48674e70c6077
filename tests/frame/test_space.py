"""Frames in three dimensions against matrices written out by hand."""

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh

from twin.errors import ModelError
from twin.frame import (
    SHIPPED,
    Accelerometer,
    Column,
    Load,
    Shaker,
    SpaceFrameDesign,
    SpaceStorey,
    four_columns,
    to_mjcf,
)
from twin.linearise import linearise

UNEQUAL = SpaceFrameDesign(
    storeys=(
        SpaceStorey(
            (Column((-0.2, -0.1)), Column((0.15, 0.0), section=(0.005, 0.003)), Column((0.0, 0.12)))
        ),
        SpaceStorey(four_columns(0.1, 0.05), 1.7, loads=(Load(0.5, (0.1, -0.05)),)),
        SpaceStorey(loads=(Load(0.4, (-0.15, 0.1)), Load(0.2, (0.0, 0.1)))),
    ),
    damping_ratio=(0.02, 0.01),
)


def by_hand(design):
    """M and K of absolute floor motions (x, y, rz of each floor's centre)."""
    n = 3 * len(design.storeys)
    mass, stiffness = np.zeros((2, n, n))
    for i, storey in enumerate(design.storeys):
        here = slice(3 * i, 3 * i + 3)
        a, b, _ = storey.floor_size
        plate = [(storey.floor_mass, 0, 0, storey.floor_mass / 12 * (a**2 + b**2))]
        edge = [round((load.mass / 7850.0) ** (1 / 3), 6) for load in storey.loads]
        plate += [
            (x.mass, *x.position, x.mass / 6 * e**2)
            for x, e in zip(storey.loads, edge, strict=True)
        ]
        for m, x, y, inertia in plate:
            move = np.array([[1, 0, -y], [0, 1, x]])
            mass[here, here] += m * move.T @ move + np.diag([0, 0, inertia])
        for column in storey.columns:
            x, y = column.position
            rows = np.zeros((3, n))
            rows[:, here] = [[1, 0, -y], [0, 1, x], [0, 0, 1]]
            if i:
                rows[:, 3 * i - 3 : 3 * i] = -rows[:, here]
            stiffness += rows.T @ np.diag(column.stiffness) @ rows
    return mass, stiffness


def compiled(design):
    return mujoco.MjModel.from_xml_string(to_mjcf(design))


@pytest.mark.parametrize("design", [UNEQUAL, SHIPPED["portal_3d"]])
def test_modes_are_those_of_matrices_assembled_by_hand(design):
    mass, stiffness = by_hand(design)
    frequencies = np.sqrt(eigh(stiffness, mass, eigvals_only=True)) / (2 * np.pi)
    modes = linearise(compiled(design)).modes()
    np.testing.assert_allclose(modes.natural_freq, frequencies, rtol=1e-8)
    ratios = np.r_[design.damping_ratio, np.full(9, design.damping_ratio[-1])]
    np.testing.assert_allclose(modes.damping_ratio, ratios[: len(frequencies)], rtol=1e-6)


def test_rayleigh_damping_is_alpha_m_plus_beta_k():
    design = SpaceFrameDesign(
        storeys=UNEQUAL.storeys[:2], damping_ratio=(), rayleigh=(0.3, 2e-5)
    )  # fmt: skip
    matrices = linearise(compiled(design)).generalised
    asked = 0.3 * matrices.M + 2e-5 * matrices.K
    np.testing.assert_allclose(matrices.R, asked, atol=3e-7 * np.abs(asked).max())


def test_a_column_is_clamped_at_both_ends_and_a_shaft():
    column = Column((0, 0), 0.5, (0.01, 0.01))
    along_x, along_y, twist = column.stiffness
    assert along_x == along_y == pytest.approx(12 * 2e11 * 0.01**4 / 12 / 0.5**3)
    # the square shaft, Timoshenko: 0.1406 a^4
    assert twist == pytest.approx(7.9e10 * 0.1406 * 0.01**4 / 0.5, rel=2e-3)


def test_every_column_is_an_element_of_each_axis():
    model = compiled(UNEQUAL)
    names = {model.tendon(i).name for i in range(model.ntendon)}
    for storey, columns in enumerate((3, 4, 4), start=1):
        for column in range(1, columns + 1):
            assert {f"storey{storey}_column{column}_{axis}" for axis in ("x", "y", "rz")} <= names
    model.tendon_stiffness[model.tendon("storey2_column3_x").id] = 0
    softer = linearise(model).modes().natural_freq[0]
    assert softer < linearise(compiled(UNEQUAL)).modes().natural_freq[0]


def test_a_turned_accelerometer_sees_its_own_axes():
    turned = Accelerometer("a", 1, (0.1, 0.05), (0, 0, 35.0))
    tilted = Accelerometer("b", 1, (0.1, 0.05), (20.0, 0, 90.0))
    design = SpaceFrameDesign((SpaceStorey(),), (turned, tilted), (Shaker("f", 1, (0, 0), 30.0),))
    model = compiled(design)
    data = mujoco.MjData(model)
    data.ctrl[:] = 3.0
    mujoco.mj_forward(model, data)
    # three newtons on three kilograms along 30 degrees
    a = data.sensor("a").data
    np.testing.assert_allclose(a, [np.cos(np.pi / 36), -np.sin(np.pi / 36), 9.81], atol=1e-9)
    # first about x, then about z: its x axis is the frame's y, its y axis points to -x and up
    b = data.sensor("b").data
    assert b[0] == pytest.approx(0.5)
    lean = np.radians(20)
    assert b[1] == pytest.approx(-np.cos(lean) * np.cos(np.pi / 6) + np.sin(lean) * 9.81)


def test_the_rotated_frame_has_no_sensor_along_a_drift():
    model = compiled(SHIPPED["rotated_sensors"])
    data = mujoco.MjData(model)
    for joint in range(model.njnt):
        data.qacc[:] = np.eye(model.nv)[joint]
        mujoco.mj_inverse(model, data)
        seen = np.r_[data.sensor("acc_a").data[:2], data.sensor("acc_b").data[:2]]
        assert np.max(np.abs(seen)) < 0.9


def test_the_portal_has_at_most_six_accelerometers_on_its_floors():
    design = SHIPPED["portal_3d"]
    assert sum(a.floor > 0 for a in design.accelerometers) <= 6
    model = compiled(design)
    for name in ("storey1_x", "storey1_y", "storey1_rz", "storey2_x", "storey2_y", "storey2_rz"):
        assert model.joint(name).id >= 0


def test_a_floor_may_keep_some_of_its_freedoms():
    model = compiled(SpaceFrameDesign((SpaceStorey(),), freedoms=("x",)))
    assert [model.joint(i).name for i in range(model.njnt)] == ["storey1_x"]
    names = {model.tendon(i).name for i in range(model.ntendon)}
    assert names == {f"storey1_column{i}_x" for i in (1, 2, 3, 4)} | {""}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"storeys": ()}, "at least one storey"),
        ({"freedoms": ("x", "z")}, "freedoms are x, y, rz"),
        ({"shakers": (Shaker("f", 3),)}, "f is on floor 3; floors are 1 to 2"),
        ({"accelerometers": (Accelerometer("a", 1), Accelerometer("a", 2))}, "two devices"),
        ({"damping_ratio": (1.5,)}, "SpaceFrameDesign: damping ratios must be below 1"),
    ],
)
def test_what_cannot_be_is_said(change, message):
    with pytest.raises(ModelError, match=message):
        SpaceFrameDesign(**change)


def test_columns_of_a_storey_have_one_length():
    with pytest.raises(ModelError, match="one length"):
        SpaceStorey((Column((0, 0), 0.3), Column((0.1, 0), 0.2)))
    with pytest.raises(ModelError, match="section must be positive"):
        Column((0, 0), section=(0.0, 0.01))
