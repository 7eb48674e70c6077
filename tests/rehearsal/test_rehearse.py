"""A rehearsal: sizes go up where an effect is missed, diagnoses are kept, a run goes on."""

from math import inf

import pytest
from rehearsal_support import plan

import twin.rehearsal.rehearse as room
from twin.errors import TwinError
from twin.model import Twin
from twin.rehearsal.bench import Bench
from twin.rehearsal.rehearse import diagnosed, next_size, rehearse
from twin.rehearsal.result import Try

TWIN = Twin.load("two_storey_lumped")
FRICTION = plan(conceal={"mechanisms": ["coulomb_friction"], "places": ["storey1"]})


def tries(*found):
    return [Try(1.0, f, "", 0.0) for f in found]


def test_a_miss_doubles_and_two_successes_in_a_row_end_it():
    def ladder(steps):
        return 3.0 * 2**steps

    assert next_size(ladder, []) == 3.0
    assert next_size(ladder, tries(True)) == 3.0
    assert next_size(ladder, tries(True, False)) == 6.0
    assert next_size(ladder, tries(False, False, True)) == 12.0
    assert next_size(ladder, tries(False, True, True)) is None
    assert next_size(lambda steps: inf, []) is None


@pytest.fixture
def threshold(monkeypatch):
    """Diagnoses that name friction at storey1 from a force on, and bumpers below; and a list."""
    made = []

    def stub(case):
        size = case.mechanism.values["force"]
        made.append(size)
        right = size > threshold.newton
        first = ["coulomb_friction" if right else "bumper", "storey1"]
        return {"verdict": "missing_physics", "findings": [first], "seconds": 1.0}

    def threshold():
        return made

    threshold.newton = 0.0
    monkeypatch.setattr(room, "diagnosed", stub)
    return threshold


def test_the_prediction_is_told_before_the_first_diagnosis(threshold):
    told = []
    rehearse(TWIN, FRICTION, verify=1, tell=lambda r: told.append((r, len(threshold()))))
    ((prediction, before),) = told
    assert before == 0
    assert prediction.limits[0].status == "predicted"
    assert len(threshold()) == 1


def test_a_limit_is_moved_to_where_diagnoses_find_it(threshold):
    expected = rehearse(TWIN, FRICTION).limits[0].predicted
    threshold.newton = 3 * expected
    (limit,) = rehearse(TWIN, FRICTION, verify=5).limits
    assert limit.status == "verified"
    assert limit.limit == pytest.approx(4 * expected)
    assert limit.mistaken_for == "bumper at storey1"
    assert [t.found for t in limit.tries] == [False, False, True, True]


def test_what_is_never_found_is_said(threshold):
    threshold.newton = 1e9
    (limit,) = rehearse(TWIN, FRICTION, verify=2).limits
    assert limit.status == "not_found"
    assert limit.limit is None
    assert limit.in_words.startswith("above ")


def test_a_folder_is_gone_on_from_and_gives_the_same(threshold, tmp_path):
    first = rehearse(TWIN, FRICTION, verify=1, folder=tmp_path)
    assert len(threshold()) == 1
    second = rehearse(TWIN, FRICTION, verify=2, folder=tmp_path)
    assert len(threshold()) == 2
    again = rehearse(TWIN, FRICTION, verify=2, folder=tmp_path)
    assert len(threshold()) == 2
    assert again == second == rehearse(TWIN, FRICTION, verify=2)
    assert first.limits[0].tries == second.limits[0].tries[:1]
    with pytest.raises(TwinError, match="another campaign"):
        rehearse(TWIN, FRICTION, verify=1, folder=tmp_path, seed=1)


def test_sizes_of_the_plan_are_tried_in_their_order(threshold):
    sized = plan(
        conceal={
            "mechanisms": ["coulomb_friction"], "places": ["storey1"],
            "sizes": {"coulomb_friction": [0.001, 0.005, 0.03]},
        }
    )  # fmt: skip
    threshold.newton = 0.004
    (limit,) = rehearse(TWIN, sized, verify=4).limits
    assert threshold() == pytest.approx([0.001, 0.005, 0.005])
    assert limit.limit == pytest.approx(0.005)


def test_a_place_or_a_sensor_that_there_is_not_is_named():
    with pytest.raises(TwinError, match=r"conceal.places: no place 'attic'; there are .*storey1"):
        rehearse(TWIN, plan(conceal={"places": ["attic"]}))
    with pytest.raises(TwinError, match="nothing measures 'acc_roof'"):
        rehearse(TWIN, plan(sensors=["acc_roof"]))


def test_a_diagnosis_finds_what_is_well_above_its_limit():
    wrong_gain = plan(conceal={"mechanisms": ["sensor_gain"], "places": ["acc_floor1"]})
    bench = Bench.of(TWIN, wrong_gain, 0)
    (effect,) = bench.effects
    case = room.Case(TWIN, wrong_gain, effect.at(effect.times(1.1)), 5)
    answer = diagnosed(case)
    assert answer["findings"][0] == ["sensor_gain", "acc_floor1"]
    assert diagnosed(case)["findings"] == answer["findings"]


def test_a_structure_that_the_effect_destroys_is_a_miss_in_words():
    from twin.mechanisms.mass import Mass

    answer = diagnosed(room.Case(TWIN, FRICTION, Mass("floor1", -50.0), 1))
    assert "error" in answer
