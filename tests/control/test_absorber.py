import numpy as np
import pytest
from absorber_support import PAPER_FRAME

from twin.control.absorber import DesignModel, with_pendulum
from twin.control.bare import pendulum_of, without_pendulum
from twin.control.plant import Plant
from twin.errors import ControlError
from twin.frame import FrameDesign, Pendulum
from twin.model import Twin
from twin.second_order import SecondOrderModel


def test_the_design_model_is_the_papers(paper_model):
    m, length, inertia = 0.083, 0.0825, 8.32e-4
    M, K, R = (getattr(paper_model.structure, name) for name in "MKR")
    expected_M = [
        [1.3005, -0.0846, 0],
        [-0.0846, 0.5663 + m, m * length],
        [0, m * length, m * length**2 + inertia],
    ]
    assert np.allclose(M, expected_M, rtol=1e-14)
    assert np.allclose(K, [[1047.3, -824.1, 0], [-824.1, 841.6, 0], [0, 0, m * 9.81 * length]])
    assert np.allclose(R, [[0.3955, -0.0485, 0], [-0.0485, 0.1838, 0], [0, 0, 0]])


def test_the_two_readings_of_the_inertia_differ_by_that_of_the_mass_at_the_centre():
    centre, pivot = (
        with_pendulum(PAPER_FRAME, Pendulum(inertia_about=about)).M[2, 2]
        for about in ("centre", "pivot")
    )
    assert pivot == pytest.approx(8.32e-4)
    assert centre - pivot == pytest.approx(0.083 * 0.0825**2)


def test_kinetic_energy_is_that_of_a_rod_that_hangs_from_a_moving_floor():
    pendulum = Pendulum(0.2, 0.3, 0.01)
    M = with_pendulum(SecondOrderModel([[2.0]], [[0.0]], [[1.0]], ("floor1",)), pendulum).M
    speed, rate = 0.7, -1.3
    centre = speed + 0.3 * rate
    expected = 0.5 * (2.0 * speed**2 + 0.2 * centre**2 + 0.01 * rate**2)
    motion = np.array([speed, rate])
    assert 0.5 * motion @ M @ motion == pytest.approx(expected)


def test_outputs_are_the_measurements_of_58_for_any_motion(plant):
    """All accelerations from the whole rig's equation of motion, a given ground among them."""
    model, rng = plant.linear(), np.random.default_rng(0)
    names, torque, known = model.structure.coordinates, 0.3, 0.7
    x, rate = rng.normal(size=(2, len(names)))
    whole = plant.rig.second_order()
    if plant.known_input == "acc_ground":
        whole = plant.twin.released().second_order()
    place = {name: i for i, name in enumerate(whole.coordinates)}
    all_x, all_rate, force = np.zeros((3, len(place)))
    moving = [place[name] for name in names]
    all_x[moving], all_rate[moving] = x, rate
    force[place["pendulum"]] = torque
    acceleration = np.zeros(len(place))
    if plant.known_input == "acc_ground":
        acceleration[place["ground"]] = known
    else:
        force[place[plant.known_input.removeprefix("force_")]] += known
    right = force - whole.K @ all_x - whole.R @ all_rate - whole.M @ acceleration
    acceleration[moving] = np.linalg.solve(whole.M[np.ix_(moving, moving)], right[moving])
    expected = [*(acceleration[place[f]] for f in ("floor1", "floor2")), x[names.index("pendulum")]]
    system = model.continuous()
    state = np.concatenate([x, rate])
    assert np.allclose(system.C @ state + system.D @ [known, torque], expected, rtol=1e-9)
    on_table = [
        float(name != "pendulum") * (known if "acc" in plant.known_input else 0) for name in names
    ]
    slope = np.concatenate([rate, acceleration[moving] - on_table])
    assert np.allclose(system.A @ state + system.B @ [known, torque], slope, rtol=1e-9)


def test_on_a_shake_table_a_clamped_model_knows_the_floors_inertia_only(believed):
    table = DesignModel(believed.structure, "acc_ground")
    assert table.influence() == pytest.approx(-believed.structure.M @ [1, 1, 0])


def test_the_linear_plant_is_the_frame_with_its_pendulum(floor_plant, believed):
    true = floor_plant.linear().structure
    assert np.allclose(true.M, believed.structure.M, atol=1e-9)
    # the pendulum's weight adds to P-Delta, which (55) does not know
    assert np.allclose(true.K, believed.structure.K, rtol=0.012, atol=1e-9)
    assert not np.allclose(true.K, believed.structure.K, rtol=1e-3)


def test_the_pendulums_data_are_read_from_the_model(absorber_twin):
    found, design = pendulum_of(absorber_twin), Pendulum()
    for name in ("mass", "centre_distance", "pivot_inertia", "damping"):
        assert getattr(found, name) == pytest.approx(getattr(design, name), rel=1e-9)


def test_the_friction_of_the_hinge_is_read_too():
    twin = Twin.of(FrameDesign(pendulum=Pendulum(0.1, 0.07, 9e-4, "pivot", 0.002)))
    found = pendulum_of(twin)
    assert found.damping == pytest.approx(0.002)
    assert found.pivot_inertia == pytest.approx(9e-4, rel=1e-6)


def test_the_frame_without_its_pendulum_is_the_shipped_one(absorber_twin):
    bare, shipped = without_pendulum(absorber_twin), Twin.load("two_storey")
    for name in "MKR":
        ours, theirs = (getattr(twin.second_order(), name) for twin in (bare, shipped))
        assert np.allclose(ours, theirs, rtol=1e-12, atol=1e-12)


def test_a_model_without_the_pendulums_names_says_what_it_lacks_and_has():
    with pytest.raises(
        ControlError, match=r"lacks actuator torque_pendulum and sensor angle_"
    ) as e:
        Plant(Twin.load("two_storey"))
    assert "force_floor1" in str(e.value)
    with pytest.raises(ControlError, match="no joint sensor 'angle_pendulum'"):
        without_pendulum(Twin.load("two_storey"))


@pytest.mark.parametrize(
    ("coordinates", "known", "message"),
    [
        (("floor1", "floor2"), "force_ground", "lacks the coordinate ground"),
        (("floor2", "floor3"), "force_floor2", "lacks the coordinate floor1"),
        (("ground", "floor1"), "acc_ground", "take the model of the clamped"),
    ],
)
def test_a_design_model_without_what_it_needs_is_refused(coordinates, known, message):
    frame = SecondOrderModel(np.eye(2), np.eye(2), np.eye(2), coordinates)
    with pytest.raises(ControlError, match=message):
        DesignModel(with_pendulum(frame, Pendulum()), known)


def test_friction_of_the_hinge_damps_the_angle_alone():
    R = with_pendulum(PAPER_FRAME, Pendulum(damping=0.003)).R
    assert R - np.pad(PAPER_FRAME.R, ((0, 1), (0, 1))) == pytest.approx(np.diag([0, 0, 0.003]))


def test_a_pendulum_is_not_hung_twice(paper_model):
    with pytest.raises(ControlError, match="without pendulum"):
        with_pendulum(paper_model.structure, Pendulum())


def test_a_place_that_cannot_be_excited_is_refused(absorber_twin):
    with pytest.raises(ControlError, match="force_floor1, force_floor2, force_ground, acc_ground"):
        Plant(absorber_twin, "force_floor7")
