"""What sensors read at once of the inputs, against masses and the linear equations."""

import numpy as np
import pytest
from scipy import signal

from twin.contract import names_in
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, RandomShaking, run
from twin.laboratory.direct import direct_parts
from twin.model import Twin

SLEDGE = """<mujoco><option timestep="0.0005"/><worldbody><body name="sledge">
<joint name="rail" type="slide" axis="1 0 0" damping="0.1" frictionloss="0.01"/>
<inertial pos="0 0 0" mass="2.5" diaginertia="1 1 1"/><site name="s"/></body></worldbody>
<actuator><motor name="push" joint="rail"/></actuator>
<sensor><accelerometer name="acc" site="s"/><jointpos name="place" joint="rail"/></sensor>
</mujoco>"""
IDEAL = {"acc": Instrument(bits=None), "force": Instrument(bits=None)}


def answer(recording, output, force):
    """The frequency response of one channel to another, and its frequencies."""
    columns = (recording.column(name)[200:-200] for name in (force, output))
    f, across = signal.csd(*columns, recording.sampling_hz, nperseg=512)
    _, power = signal.welch(recording.column(force)[200:-200], recording.sampling_hz, nperseg=512)
    return f, across / power


def test_a_force_over_a_mass_is_read_at_all_frequencies_alike():
    mjcf = SLEDGE.replace(' frictionloss="0.01"', "").replace(' damping="0.1"', "")
    shaking = Experiment(
        RandomShaking(1.0, (5.0, 70.0)), "push", Analyser(192.0, 16.0), instruments=IDEAL
    )
    f, H = answer(run(shaking, Twin(mjcf, "sledge")), "acc", "push")
    inside = (f > 10) & (f < 65)
    assert H[inside] == pytest.approx(1 / 2.5, rel=1e-5)


def test_a_force_is_read_over_the_mass_that_it_moves_whatever_rubs():
    model, _ = Twin(SLEDGE, "sledge").driven(())
    parts = direct_parts(model, ["push"])
    assert parts["acc"] == pytest.approx([1 / 2.5])
    assert parts["place"] == pytest.approx([0.0])


@pytest.mark.parametrize("name", ["cantilever", "portal_3d", "two_storey"])
def test_it_is_what_the_linear_equations_read_at_once(name):
    twin = Twin.load(name)
    model, _ = twin.driven(())
    forces = names_in(model)["actuator"]
    outputs = [n for n in direct_parts(model, forces) if n.startswith("acc")]
    linear = twin.linear(forces, outputs)
    at_once = linear.Cu + linear.Ca @ np.linalg.solve(linear.M, linear.B)
    parts = direct_parts(model, forces)
    assert np.array([parts[n] for n in outputs]) == pytest.approx(at_once, rel=1e-6, abs=1e-6)


def test_a_sensor_on_shaken_ground_reads_its_acceleration_and_a_floor_none_at_once():
    model, drives = Twin.load("portal_3d").driven(("x",))
    parts = direct_parts(model, list(drives.values()))
    floors = [v for n, v in parts.items() if n.startswith("acc") and "ground" not in n]
    assert floors
    assert np.array(floors) == pytest.approx(0.0, abs=1e-9)
