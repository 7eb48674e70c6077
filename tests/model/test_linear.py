"""The linear equations of any MJCF against closed forms and against MuJoCo itself."""

import numpy as np
import pytest

from twin.errors import ModelError
from twin.model import Twin
from twin.model.free_run import free_run


def mjcf(bodies, rest="", gravity=9.81):
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-gravity}" timestep="0.0005"/>'
        f"<worldbody>{bodies}</worldbody>{rest}</mujoco>"
    )


def inertial(mass, z=0.0, turning=1e-3):
    return f'<inertial pos="0 0 {z}" mass="{mass}" diaginertia="{turning} {turning} {turning}"/>'


PENDULUM = mjcf(
    f"""<body name="arm"><joint name="pin" axis="0 1 0" damping="0.01"/>{inertial(2, -0.4, 0.05)}
    <site name="tip" pos="0 0 -0.5"/></body>""",
    '<actuator><motor name="torque" joint="pin" gear="3"/></actuator>'
    '<sensor><accelerometer name="tip" site="tip"/><gyro name="rate" site="tip"/>'
    '<jointpos name="angle" joint="pin"/><velocimeter name="speed" site="tip"/></sensor>',
)

SLIDE = mjcf(
    f'<body name="car"><joint name="rail" type="slide" axis="1 0 0" damping="200"/>{inertial(95)}'
    "</body>",
    '<actuator><motor name="drive" joint="rail" gear="35"/></actuator>'
    '<sensor><jointpos name="encoder" joint="rail"/></sensor>',
)

PLANE = """<body name="base"><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>
  <body name="plate" pos="0 0 1">
   <joint name="sx" type="slide" axis="1 0 0" stiffness="900" damping="1.5"/>
   <joint name="sy" type="slide" axis="0 1 0" stiffness="1400" damping="2"/>
   <joint name="twist" type="hinge" axis="0 0 1" stiffness="30" damping="0.05"/>
   <inertial pos="0.1 0.05 0" mass="2" diaginertia="0.1 0.1 0.2"/>
   <site name="corner" pos="0.3 0.2 0" euler="0 0 0.6"/></body></body>"""
PLANE_REST = """<actuator><motor name="hit" site="corner" gear="1 0 0 0 0 0"/></actuator>
<sensor><accelerometer name="A1" site="corner"/><framepos name="laser" objtype="site"
 objname="corner"/><gyro name="spin" site="corner"/><force name="cell" site="corner"/>
 <framelinvel name="doppler" objtype="site" objname="corner"/></sensor>"""


@pytest.mark.parametrize("name", ["two_storey_lumped", "two_storey", "two_storey_absorber"])
def test_the_chain_responds_as_its_matrices_in_floors_say(name):
    twin = Twin.load(name)
    model = twin.linear(["force_floor1", "force_floor2"], ["acc_floor1", "acc_floor2"])
    frequency = np.array([0.5, 1.7, 5.0, 20.0])
    floors = twin.second_order().acceleration_response(("floor1", "floor2"))
    np.testing.assert_allclose(
        model.state_space().frequency_response(frequency),
        floors.frequency_response(frequency)[:, :2],
        rtol=1e-10,
    )


def test_a_pendulums_sensors_and_motor_have_their_closed_form_rows():
    model = Twin(PENDULUM).linear(["torque"], ["tip.x", "tip.z", "rate.y", "angle", "speed.x"])
    inertia = 0.05 + 2 * 0.4**2
    unit = model.port("pin")  # angle for unit q
    assert model.K[0, 0] == pytest.approx(2 * 9.81 * 0.4 / inertia, rel=1e-9)
    assert model.R[0, 0] == pytest.approx(0.01 / inertia, rel=1e-9)
    assert unit[0] ** 2 == pytest.approx(1 / inertia, rel=1e-9)
    np.testing.assert_allclose(model.B[:, 0], 3 * unit)
    # leaning by a, the tip's x axis sees gravity: -0.5 a'' - 9.81 a
    np.testing.assert_allclose(model.Ca / unit, [[-0.5], [0], [0], [0], [0]], atol=1e-10)
    np.testing.assert_allclose(model.Cd / unit, [[-9.81], [0], [0], [1], [0]], atol=1e-8)
    np.testing.assert_allclose(model.Cv / unit, [[0], [0], [1], [0], [-0.5]], atol=1e-10)
    np.testing.assert_allclose(model.rest, [0, 9.81, 0, 0, 0], atol=1e-12)


def test_a_position_servo_is_a_spring_and_a_dashpot():
    servo = SLIDE.replace("<motor", '<position kp="50" kv="4"')
    model = Twin(servo).linear(["drive"], ["encoder"])
    gear = 35**2
    np.testing.assert_allclose(model.K, [[50 * gear / 95]], rtol=1e-9)
    np.testing.assert_allclose(model.R, [[(200 + 4 * gear) / 95]], rtol=1e-9)
    np.testing.assert_allclose(model.B / model.port("rail"), [[50 * 35]], rtol=1e-9)


def test_a_free_slide_is_a_rigid_body_mode():
    model = Twin(SLIDE).linear(["drive"], ["encoder"])
    assert model.K[0, 0] == 0
    force = np.full((400, 1), 0.2)
    t = np.arange(400) / 100
    decay = 200 / 95
    speed = 35 * 0.2 / 200
    expected = speed * (t - (1 - np.exp(-decay * t)) / decay)
    np.testing.assert_allclose(free_run(model, force, 100)[:, 0], expected, atol=1e-14)


def test_a_twisting_plate_moves_in_mujoco_as_its_equations_say():
    twin = Twin(mjcf(PLANE, PLANE_REST))
    names = [f"{n}.{a}" for n in ("A1", "laser", "spin", "cell", "doppler") for a in "xyz"]
    model = twin.linear(["hit"], names)
    force = 1e-3 * np.random.default_rng(1).standard_normal(400)
    found = free_run(model, force[:, None], 200)
    motion = twin.simulate({"hit": force}, 200, 400)
    for index, name in enumerate(names):
        true = motion.column(name)
        scale = np.abs(true - true.mean()).max()
        assert np.abs(found[:, index] - true).max() < 1e-4 * scale + 1e-9, name


def test_ports_are_what_moves_and_by_its_own_name():
    model = Twin(mjcf(PLANE, PLANE_REST)).linear(["hit"], ["A1"])
    assert list(model.ports) == [
        *("sx", "sy", "twist", "plate.x", "plate.y", "plate.rz"),
        *("corner.x", "corner.y", "corner.rz"),
    ]
    # the corner turns about the plate's origin
    lever = model.port("corner.x-plate.x")
    np.testing.assert_allclose(lever, -0.2 * model.port("twist"), atol=1e-12)
    assert model.places("motion") == (
        *("plate.x", "plate.y", "plate.rz"),
        *("corner.x", "corner.y"),
    )
    assert model.places("base") == ("ground.x", "ground.y")
    assert model.ports["plate.rz"].unit == "rad"
    assert model.base["x"].mass == pytest.approx(5)
    assert model.base["x"].fixed_mass == pytest.approx(3)


@pytest.mark.parametrize(
    ("inputs", "outputs", "message"),
    [
        (["push"], ["A1"], "no actuator 'push'; inputs are hit, acc_ground, acc_ground.x"),
        (["hit"], ["A3"], "no sensor 'A3'; there are A1, A1.x, A1.y, A1.z, laser"),
        (["acc_ground", "acc_ground.x"], ["A1"], "the ground is shaken along the same axis twice"),
        (["acc_ground.z"], ["A1"], "no actuator 'acc_ground.z'; inputs are hit, acc_ground"),
    ],
)
def test_what_is_not_there_is_named_with_what_is(inputs, outputs, message):
    with pytest.raises(ModelError, match=f"mine: {message}"):
        Twin(mjcf(PLANE, PLANE_REST), "mine").linear(inputs, outputs)


def test_a_port_that_nothing_moves_is_not_there():
    model = Twin(mjcf(PLANE, PLANE_REST)).linear([], ["A1"])
    with pytest.raises(ModelError, match=r"no port 'plate\.z'; there are sx, sy, twist"):
        model.port("plate.z")
    with pytest.raises(ModelError, match="sx is in m, twist in rad"):
        model.port("sx-twist")


def test_a_force_cell_behind_a_weld_is_refused():
    welded = PLANE.replace('name="plate"', 'name="plate"', 1) + (
        f'<body name="other"><joint type="slide" axis="1 0 0" stiffness="9"/>{inertial(1)}</body>'
    )
    tie = '<equality><connect name="tie" body1="plate" body2="other" anchor="0 0 0"/></equality>'
    with pytest.raises(ModelError, match="'cell' reads a force that equality constraint tie"):
        Twin(mjcf(welded, PLANE_REST + tie)).linear([], ["cell"])


@pytest.mark.parametrize("axis", ["x", "y"])
def test_what_hangs_at_a_port_and_a_base_that_gives_way_are_as_if_built_in_mujoco(axis):
    inputs, outputs = ["hit"], ["A1.x", "A1.y", "laser.x"]
    plain = Twin(mjcf(PLANE, PLANE_REST)).linear(inputs, outputs)
    slide = f'<joint name="base" type="slide" axis="{int(axis == "x")} {int(axis == "y")} 0" '
    slide += 'stiffness="5000" damping="7"/>'
    hung = (
        '<body name="hung" pos="0.3 0.2 0"><joint type="slide" '
        f'axis="{int(axis == "x")} {int(axis == "y")} 0" stiffness="8" damping="0.01"/>'
        f"{inertial(0.1, 0, 1e-9)}</body></body></body>"
    )
    body = PLANE.replace('<body name="base">', f'<body name="base">{slide}')
    body = body.removesuffix("</body></body>") + hung
    true = Twin(mjcf(body, PLANE_REST)).linear(inputs, outputs)
    # what hangs on the slide follows the corner across it: that is mass there
    across = "corner.y" if axis == "x" else "corner.x"
    found = plain.on_base("ground", axis, 7, 5000).hanging("hung", f"corner.{axis}", 0.1, 0.01, 8)
    found = found.adding(M=0.1, along=found.port(across))
    frequency = np.array([0.3, 1.4, 3.0, 8.0])
    np.testing.assert_allclose(
        found.state_space().frequency_response(frequency),
        true.state_space().frequency_response(frequency),
        rtol=1e-6,
    )


def test_modes_far_above_the_band_are_left_out_but_not_what_they_do_statically():
    chain, end = "", ""
    for k in range(60):
        chain += (
            f'<body name="b{k}" pos="0 0 {0.02 if k else 0}"><joint name="h{k}" axis="0 1 0" '
            f'stiffness="80" damping="0.01"/>{inertial(0.05, 0.01, 1e-5)}'
        )
        end += "</body>"
    chain += '<site name="tip" pos="0 0 0.02"/>'
    rest = (
        '<actuator><motor name="hit" site="tip" gear="1 0 0 0 0 0"/></actuator>'
        '<sensor><accelerometer name="A" site="tip"/></sensor>'
    )
    twin = Twin(mjcf(chain + end, rest))
    short = twin.linear(["hit"], ["A"], band_hz=100)
    assert short.left_out < 0.05
    assert len(short.coordinates) < 40 + 60
    whole = twin.linear(["hit"], ["A"], band_hz=1e9)
    assert len(whole.coordinates) == 60
    assert whole.left_out == 0
    frequency = np.linspace(1, 100, 200)
    true = whole.state_space().frequency_response(frequency)
    found = short.state_space().frequency_response(frequency)
    assert np.abs(found - true).max() < 1e-3 * np.abs(true).max()


def test_what_is_printed_fits_on_a_line_and_names_what_there_is():
    twin = Twin(mjcf(PLANE, PLANE_REST), "mine.xml")
    assert repr(twin) == "Twin(mine.xml)"
    assert repr(Twin.load("two_storey").released()).endswith("two_storey.xml, its ground released)")
    assert repr(twin.linear(["hit"], ["A1.x"])) == (
        "LinearModel(3 coordinates, 9 ports; inputs hit; outputs A1.x)"
    )
    motion = twin.simulate({"hit": np.zeros(50)}, 100, 50)
    assert repr(motion).startswith("Motion(0.5 s at 100 Hz: A1.x, A1.y, A1.z, laser.x")


def test_a_stop_three_hundredths_of_a_millimetre_away_is_no_spring_at_rest():
    near = SLIDE.replace(
        "</mujoco>",
        '<tendon><fixed name="stop" stiffness="1e4" springlength="-1000 3e-5">'
        '<joint joint="rail" coef="1"/></fixed></tendon></mujoco>',
    )
    assert Twin(near).linear(["drive"], ["encoder"]).K[0, 0] == pytest.approx(0.0, abs=1e-9)


def test_an_axis_across_the_only_motion_can_be_asked_for():
    motion = Twin.load("portal_3d").simulate({"force_floor1_x": np.ones(8)}, 64, 8)
    assert "acc_ground.y" not in motion.columns
    assert motion.column("acc_ground.y") == pytest.approx(np.zeros(8), abs=1e-9)
