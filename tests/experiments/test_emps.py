"""EMPS end to end: the twin's virtual recording and, where it is there, the real one."""

import pytest

from experiments import emps
from twin.formats import read_recording


def test_the_twin_of_the_drive_has_one_rigid_mode():
    found = emps.inspected()
    assert found["modes_hz"] == [0.0]
    assert {"slide", "carriage"} <= set(found["ports"])


def test_a_virtual_recording_gives_the_twins_own_mass_and_friction(tmp_path):
    found = emps.inverse_model(read_recording(emps.virtual(tmp_path)), dry=False)
    assert found.values["mass"] == pytest.approx(80.0, rel=0.005)
    assert found.values["viscous"] == pytest.approx(150.0, abs=4 * found.std["viscous"])


@pytest.mark.skipif(not emps.DATA.exists(), reason=f"no recording at {emps.DATA}")
def test_the_real_slide_has_the_published_mass_and_friction():
    found = emps.inverse_model(read_recording(emps.DATA))
    for name, value in emps.PUBLISHED.items():
        assert found.values[name] == pytest.approx(value, abs=3 * found.std[name])
    assert found.left < 0.05
    # without dry friction the dashpot would have to do its work, too
    linear = emps.inverse_model(read_recording(emps.DATA), dry=False)
    assert linear.values["viscous"] > 1.5 * found.values["viscous"]
    assert linear.left > 3 * found.left
