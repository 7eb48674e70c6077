"""The real slide through the diagnosis, where its recording is there."""

import pytest

from experiments import emps
from experiments.emps_diagnosed import RATE_HZ, diagnosed, halves
from twin.formats import read_recording

there = pytest.mark.skipif(not emps.DATA.exists(), reason=f"no recording at {emps.DATA}")


def test_the_halves_are_thinned_out_and_share_no_sample(tmp_path):
    whole = read_recording(emps.virtual(tmp_path))
    first, second = halves(whole)
    assert first.sampling_hz == second.sampling_hz == RATE_HZ
    assert first.duration_s + second.duration_s == pytest.approx(whole.duration_s, abs=0.1)


@there
def test_dry_friction_is_what_the_real_slide_lacks():
    found = diagnosed(read_recording(emps.DATA))
    values, known = found["found"], emps.PUBLISHED
    assert values["slide"]["mass"] == pytest.approx(known["mass"], rel=0.03)
    spread = found["deviations"]["sensor_offset force offset"]
    assert values["sensor_offset force"]["offset"] == pytest.approx(known["offset"], abs=3 * spread)
    dry = values["coulomb_friction slide"]["force"]
    assert dry == pytest.approx(known["coulomb"], rel=0.15)
    # dry and viscous friction share what the slide brakes with at the speed that it mostly has
    together = dry + 0.1 * values["slide"]["viscous"]
    assert together == pytest.approx(known["coulomb"] + 0.1 * known["viscous"], rel=0.03)
    errors = found["error_on_the_second_half"]
    assert errors["found"]["free_run"] < 1.1 * errors["published"]["free_run"]
