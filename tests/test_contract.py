import numpy as np
import pytest

from twin.contract import channel_sensors, floors_of, names_in, pendulum_dof
from twin.errors import ModelError
from twin.model import Twin

OWN = """
<mujoco model="mine">
  <option gravity="0 0 0" timestep="0.001"/>
  <worldbody>
    <body name="ground">
      <geom size="0.1" mass="5"/>
      <body name="floor1" pos="0 0 1">
        <joint name="storey1" type="slide" axis="1 0 0" stiffness="400" damping="0.5"/>
        <geom size="0.1" mass="2"/>
        <site name="s1"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="force_floor1" joint="storey1"/></actuator>
  <sensor>
    <accelerometer name="acc_floor1" site="s1"/>
    <jointpos name="disp_floor1" joint="storey1"/>
    <jointvel name="my_speed" joint="storey1"/>
  </sensor>
</mujoco>
"""


def test_a_users_own_model_with_the_contracts_names_works():
    twin = Twin(OWN, "mine.xml")
    modes = twin.modes()
    assert modes.natural_freq == pytest.approx(np.sqrt(400 / 2) / (2 * np.pi), rel=1e-9)
    assert modes.damping_ratio == pytest.approx(0.5 / (2 * np.sqrt(400 * 2)), rel=1e-9)
    motion = twin.simulate({"force_floor1": np.ones(10)}, 100, 10)
    assert set(motion.columns) == {"acc_floor1", "disp_floor1", "my_speed"}
    assert motion.columns["acc_floor1"][0] == pytest.approx(0.5, rel=1e-12)


def test_a_users_own_model_can_be_shaken():
    ramp = np.linspace(0, 1, 50)
    columns = Twin(OWN).simulate({}, 500, 50, ground_acceleration=ramp).columns
    assert columns["disp_floor1"][-1] < 0


@pytest.mark.parametrize(
    ("name", "lacks"),
    [
        ("ground", "lacks body ground. It has body: wrong, floor1"),
        ("floor1", "lacks body floor1. It has body: ground, wrong"),
        ("storey1", "lacks joint or tendon storey1. It has joint or tendon: wrong"),
        ("force_floor1", "lacks actuator force_floor1. It has actuator: wrong"),
        ("acc_floor1", "lacks sensor acc_floor1. It has sensor: wrong, disp_floor1, my_speed"),
        ("disp_floor1", "lacks sensor disp_floor1. It has sensor: acc_floor1, wrong, my_speed"),
    ],
)
def test_a_model_without_a_name_is_told_what_it_lacks_and_has(name, lacks):
    changed = OWN.replace(f'name="{name}"', 'name="wrong"').replace(
        f'joint="{name}"', 'joint="wrong"'
    )
    with pytest.raises(ModelError) as error:
        Twin(changed, "mine.xml").second_order()
    assert str(error.value) == f"mine.xml: {lacks}"


def test_a_second_floor_asks_for_all_its_names():
    second = OWN.replace('name="my_speed"', 'name="acc_floor2"')
    with pytest.raises(ModelError) as error:
        Twin(second).second_order()
    for name in ("body floor2", "storey2", "actuator force_floor2", "sensor disp_floor2"):
        assert name in str(error.value)
    assert "acc_floor2;" not in str(error.value).split("It has")[0]


def test_an_empty_model_lacks_everything():
    with pytest.raises(ModelError, match="It has body: none; joint or tendon: none"):
        Twin("<mujoco/>").second_order()


def test_names_floors_channels_and_pendulum_are_found():
    model = Twin.load("two_storey_absorber").compile()
    assert floors_of(model) == ("floor1", "floor2")
    assert {"storey1", "storey2"} <= set(names_in(model)["tendon"])
    assert "world" not in names_in(model)["body"]
    assert list(channel_sensors(model)) == [
        *(
            f"{kind}_{place}"
            for place in ("ground", "floor1", "floor2")
            for kind in ("acc", "disp")
        ),
        "angle_pendulum",
    ]
    assert model.joint("pendulum").dofadr[0] == pendulum_dof(model)
    assert pendulum_dof(Twin.load("two_storey").compile()) is None
