"""Dashpots that a twin is written with are how it is damped, and no elements of their own."""

import mujoco
import numpy as np

from twin.mechanisms.damping import Damping
from twin.model import Twin
from twin.model.dashpots import dashpots_noted, note_dashpot

SPACED = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="frame">
    <joint name="the storey" type="slide" axis="1 0 0" stiffness="400" damping="1"/>
    <geom size="0.1" mass="1"/><site name="top"/></body>
</worldbody>
<actuator><motor name="drive" joint="the storey"/></actuator>
<sensor><accelerometer name="acc" site="top"/></sensor></mujoco>"""


def linear(twin):
    return twin.linear(["force_mid"], ["acc_tip"])


def test_a_twin_damped_between_two_places_is_read_back_with_the_same_ports(tmp_path):
    plain = Twin.load("cantilever")
    damped = plain.including(Damping("hinge3", 1e-4), Damping("link1.ry-link8.ry", 1e-6))
    back = Twin.load(damped.export(tmp_path / "damped.xml"))
    np.testing.assert_allclose(linear(back).R, linear(damped).R, rtol=1e-12)
    assert not np.allclose(linear(back).R, linear(plain).R)
    for twin in (damped, back):
        assert set(linear(twin).ports) == set(linear(plain).ports)
    again = Twin.load(back.including(Damping("hinge3", 1e-4)).export(tmp_path / "again.xml"))
    assert set(linear(again).ports) == set(linear(plain).ports)


def test_a_dashpot_of_the_user_is_a_port():
    spec = mujoco.MjSpec.from_string(SPACED)
    tendon = spec.add_tendon(name="damper", damping=[3.0, 0.0, 0.0])
    tendon.wrap_joint("the storey", 1.0)
    assert "damper" in Twin(spec.to_xml()).linear(["drive"], ["acc.x"]).ports


def test_names_of_dashpots_may_have_spaces(tmp_path):
    path = tmp_path / "spaced.xml"
    path.write_text(SPACED)
    damped = Twin.load(path).including(Damping("the storey", 2.0)).export(tmp_path / "damped.xml")
    model = mujoco.MjModel.from_xml_path(str(damped))
    assert dashpots_noted(model) == {"the storey_damping"}
    ports = Twin.load(damped).linear(["drive"], ["acc.x"]).ports
    assert "the storey_damping" not in ports
    assert "the storey" in ports


def test_a_model_without_any_has_none_noted():
    spec = mujoco.MjSpec.from_string(SPACED)
    assert dashpots_noted(spec.compile()) == frozenset()
    spec.add_text(name="of the user", data="damper")
    note_dashpot(spec, "one")
    note_dashpot(spec, "two")
    assert dashpots_noted(spec.compile()) == {"one", "two"}
