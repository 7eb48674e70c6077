"""What else a search may begin with: a range that ends where readings pile up, or a law."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.refining import refined
from twin.diagnosis.restarting import OTHERWISE, other_beginnings
from twin.diagnosis.rig import heights_of
from twin.diagnosis.stage import Stage, next_stage
from twin.recording import Recording

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

ALL = mechanisms.vocabulary()
BUMPER = ALL["bumper"]("storey2", 2000.0, 0.004)
FORCE = ALL["unmeasured_force"]("floor2", 0.1, 5.0, 10.0)
CLIPS = ("sensor_clipping", "acc_floor2")
LEVEL = 1.8


def cut_off(recording, level):
    """The recording with its second accelerometer's range ended at a level."""
    columns = {name: recording.column(name) for name in recording.names}
    columns["acc_floor2"] = np.clip(columns["acc_floor2"], -level, level)
    return Recording.build(recording.sampling_hz, columns, recording.source)


@pytest.fixture(scope="module")
def both():
    """A bumper and an accelerometer that clips, and the fit of nothing missing."""
    return calibrated([cut_off(recorded(lumped(BUMPER), seed, 0.6, 8.0), LEVEL) for seed in (1, 2)])


@pytest.fixture(scope="module")
def sound():
    """Nothing that piles up."""
    return calibrated([recorded(lumped(), seed, 0.6, 8.0) for seed in (1, 2)])


def calibrated(records):
    bench = prepare(lumped(), records[:1], records[1:]).train
    return bench, refined(bench, [base_hypothesis(bench.model)], 3e-3)


def explaining(nothing, mechanism, gain):
    """A fit with a mechanism that drops the BIC by a gain."""
    found = replace(nothing, hypothesis=nothing.hypothesis.including(mechanism))
    return replace(
        found, log_likelihood=found.log_likelihood + (gain + found.bic - nothing.bic) / 2
    )


def begins_with(bench, nothing, *fits):
    """What stands first in each other beginning."""
    first = Stage(nothing, {}, (), fits)
    return [s.fits[0].hypothesis.labels[-1] for s in other_beginnings(bench, nothing, first)]


def test_behind_a_range_that_ends_where_readings_pile_up_the_law_is_found(both):
    bench, nothing = both
    first = Stage(nothing, {}, (), (explaining(nothing, BUMPER, 5000.0),))
    (other,) = other_beginnings(bench, nothing, first)
    (clipped,) = other.fits
    assert clipped.hypothesis.labels == (CLIPS,)
    stage = next_stage(bench, clipped, heights_of(lumped()), lambda message: None)
    best = stage.fits[0].hypothesis
    assert best.labels == (CLIPS, ("bumper", "storey2"))
    range_end, bumper = best.found
    assert range_end.level == pytest.approx(LEVEL, rel=2e-3)
    assert bumper.stiffness == pytest.approx(2000.0, rel=0.02)
    assert bumper.gap == pytest.approx(0.004, rel=0.01)


def test_a_range_that_was_begun_with_is_not_begun_with_again(both):
    bench, nothing = both
    clipping = ALL["sensor_clipping"]("acc_floor2", LEVEL)
    assert begins_with(bench, nothing, explaining(nothing, clipping, 5000.0)) == []


def test_a_law_goes_before_a_force_that_leads_nowhere_where_it_explains_enough(sound):
    bench, nothing = sound
    force = explaining(nothing, FORCE, 1000.0)
    enough = explaining(nothing, BUMPER, OTHERWISE * 1000.0 + 1.0)
    little = explaining(nothing, BUMPER, OTHERWISE * 1000.0 - 1.0)
    assert begins_with(bench, nothing, force, enough) == [("bumper", "storey2")]
    assert begins_with(bench, nothing, force, little) == []
    assert begins_with(bench, nothing, enough, force) == []
    assert begins_with(bench, nothing, force) == []
    assert begins_with(bench, nothing) == []


def test_what_led_nowhere_stays_among_what_it_could_have_been(sound):
    bench, nothing = sound
    fits = explaining(nothing, FORCE, 1000.0), explaining(nothing, BUMPER, 900.0)
    (other,) = other_beginnings(bench, nothing, Stage(nothing, {}, (), fits))
    assert other.fits == fits[::-1]
