"""Drawings that are off: which cases, what is diagnosed, how the page shows them."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from experiments import drawings
from experiments.concealed.frames import MODEL_FILE
from experiments.concealed.rig import TWO_STOREY
from experiments.concealed.tables import combination_of
from experiments.proof_sections import section
from twin.model import Twin

EVERY = drawings.tasks(15, 5, True, Path("kept"))


def test_sixty_effects_and_twenty_rigs_with_nothing_each_of_its_own():
    hidden = [t for t in EVERY.values() if t.table == "single"]
    quiet = [t for t in EVERY.values() if t.table == "none"]
    assert (len(hidden), len(quiet)) == (60, 20)
    assert len({t.number for t in hidden}) == 60
    assert len({t.number for t in quiet}) == 20


def test_what_a_drawing_hides_is_not_asked_of_it():
    for task in EVERY.values():
        if task.table == "single":
            ((name, _),) = combination_of("single", task.number, drawings.SEED)
            assert name not in drawings.HIDDEN[task.known]


def test_a_drawing_is_off_by_its_share_and_the_same_each_time(tmp_path):
    offs = []
    for turn, (first, second) in enumerate([(1, 1), (1, 2)]):
        masses = []
        for number in (first, second):
            task = drawings.Task("10 %", "single", number, True, tmp_path)
            folder = tmp_path / f"{turn}_{len(masses)}"
            folder.mkdir()
            drawings.draw(task, folder)
            masses.append(np.diag(Twin.load(str(folder / MODEL_FILE)).second_order().M))
        offs.append(np.log(masses[0] / masses[1]))
        assert np.all(np.abs(np.log(masses[0] / np.array(TWO_STOREY.masses))) < 0.4)
    assert np.allclose(offs[0], 0)
    assert np.all(offs[1] != 0)


def test_the_right_name_at_the_right_place_first_is_right(tmp_path, monkeypatch):
    task = EVERY["10 % case_0003"]
    ((name, place),) = combination_of("single", 3, drawings.SEED)
    seen = {}

    def quick(model, train, test, tolerance, unknown):
        seen.update(tolerance=tolerance, unknown=unknown)
        found = SimpleNamespace(mechanism=SimpleNamespace(name=name), location=place)
        fit = SimpleNamespace(test=SimpleNamespace(explained=0.01))
        return SimpleNamespace(
            findings=[found], verdict="missing_physics", fit=fit, notes=(), seconds=1.0
        )

    monkeypatch.setattr(drawings, "diagnose", quick)
    monkeypatch.setattr(drawings, "generate", lambda *given: None)
    result = drawings.work(drawings.Task("10 %", "single", task.number, True, tmp_path))
    assert result["right"]
    assert seen == {"tolerance": 0.1, "unknown": False}
    drawings.work(drawings.Task("unknown", "single", task.number, True, tmp_path))
    assert seen == {"tolerance": None, "unknown": True}
    drawings.work(drawings.Task("10 %", "single", task.number, False, tmp_path))
    assert seen == {"tolerance": None, "unknown": False}


def test_the_page_counts_by_drawing(tmp_path):
    row = {"known": "3 %", "concealed": "bumper storey1", "right": True}
    rows = {
        "a": {**row, "said": "bumper storey1"},
        "b": {**row, "said": "bumper storey1, damping storey2"},
        "c": {**row, "said": "clearance storey1", "right": False},
        "d": {**row, "concealed": "", "said": "nothing"},
    }
    (shown,) = section("drawings", {"said": rows, "versions": {}})["tables"]
    ((known, right, _, _, alone, quiet),) = shown["rows"]
    assert (known, right, alone, quiet) == ("3 %", "2 of 3", "1 of 3", "1 of 1")
