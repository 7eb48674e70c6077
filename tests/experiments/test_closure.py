"""The closure test itself: what it conceals, what it counts as right, and its table."""

from dataclasses import replace

import numpy as np
import pytest

from experiments import closure
from experiments.closure_rigs import STRUCTURES, linear_of, mechanisms_of, place_of, record
from experiments.closure_sizes import visible
from twin.formats import read_recording


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """Recordings of two seconds: nothing here is diagnosed."""
    for name, structure in STRUCTURES.items():
        monkeypatch.setitem(STRUCTURES, name, replace(structure, duration_s=2.0))


def answer(verdict="consistent", *found, twin="found.xml"):
    findings = [{"mechanism": m, "location": place} for m, place in found]
    return {"verdict": verdict, "findings": findings, "twin": twin}


def test_the_whole_vocabulary_has_a_place_on_the_chain():
    names = mechanisms_of(STRUCTURES["chain"])
    assert {"mass", "coulomb_friction", "base_compliance", "sensor_swap", "appendage"} <= set(names)
    assert place_of(STRUCTURES["chain"], "mass") == "floor1"
    assert place_of(STRUCTURES["portal"], "coulomb_friction") == "storey1_column3_x"
    assert place_of(STRUCTURES["portal"], "base_compliance") == "ground.y"


def test_every_mechanism_of_the_vocabulary_has_a_size():
    chain = STRUCTURES["chain"]
    nothing_to_size = ("sensor_polarity", "sensor_swap")
    for name in mechanisms_of(chain):
        built = visible(chain, name)
        assert name in nothing_to_size or built != type(built)(built.place), name


@pytest.mark.parametrize("name", ["cubic_stiffness", "sensor_gain", "unmeasured_force"])
def test_what_is_built_in_shows_in_the_recordings(tmp_path, name):
    chain = STRUCTURES["chain"]
    train, test = record(chain, visible(chain, name), tmp_path / "with")
    plain, _ = record(chain, None, tmp_path / "without")
    assert [p.name for p in (*train, *test)] == [
        "train_1.csv", "train_2.csv", "train_3.csv", "test_1.csv",
    ]  # fmt: skip
    there, before = read_recording(train[0]), read_recording(plain[0])
    if name == "unmeasured_force":
        assert there.inputs == ("force_floor1",)
        return
    change = there.column("acc_floor2") - before.column("acc_floor2")
    assert np.std(change) > 0.03 * np.std(before.column("acc_floor2"))


def test_a_row_is_right_where_all_three_diagnoses_are(tmp_path, monkeypatch):
    told = []

    def diagnose(model, train, test, out, seed):
        told.append(model)
        return answer("parameter", ("mass", "floor1")) if out.name == "named" else answer()

    monkeypatch.setattr("twin.cli.diagnose.diagnose_files", diagnose)
    done = closure.close(closure.Task("chain", "mass", tmp_path))
    assert done == {"place": "floor1", "own": "right", "named": "right", "again": "right"}
    assert told == [str(tmp_path / "chain_mass" / "own.xml"), "two_storey_lumped", "found.xml"]
    told.clear()
    done = closure.close(closure.Task("chain", "sensor_gain", tmp_path))
    assert (done["own"], done["again"]) == ("-", "-")
    assert done["named"] == "parameter: mass floor1"
    assert len(told) == 1


def test_a_place_that_moves_alike_is_the_same_place():
    portal = STRUCTURES["portal"]
    assert {"storey1_rz", "storey1_column2_rz"} <= set(linear_of(portal).ports)
    assert closure._same("storey1_column2_rz", "storey1_rz", portal)
    assert not closure._same("storey1_column2_x", "storey1_x", portal)
    assert closure._same("b+a", "a+b", portal)


def test_the_table_counts_what_is_right():
    rows = {
        "chain mass": {"place": "floor1", "own": "right", "named": "right", "again": "right"},
        "chain plain": {"place": "", "own": "parameter: damping storey1", "named": "-",
                        "again": "-"},
    }  # fmt: skip
    last = closure.table(rows).splitlines()[-1]
    assert last == "| all | | | 1 of 2 | 1 of 1 | 1 of 1 |"


def test_a_weight_that_takes_less_than_a_drawing_errs_has_no_row(tmp_path):
    rows = closure.tasks_of(("chain", "cantilever"), ("p_delta", "stiffness"), tmp_path)
    assert list(rows) == ["chain p_delta", "chain stiffness", "cantilever stiffness"]
