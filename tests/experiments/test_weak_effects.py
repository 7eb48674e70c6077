"""Weak effects: the cases that tell what probabilities in the middle are worth."""

import json
from collections import Counter

from experiments import detection_limits as limits
from experiments import weak_effects as weak
from experiments.detection_limits_theory import PAIRS


def test_every_effect_is_tried_at_both_of_its_places_with_every_severity():
    tasks = weak.tasks()
    assert len({task.name for task in tasks}) == len(tasks) == 16 * 3 * weak.TURNS
    tried = Counter((t.pair.name, t.pair.place, t.multiple) for t in tasks)
    assert set(tried.values()) == {weak.TURNS}
    assert {t.pair.place for t in tasks} >= {"storey1", "storey2", "acc_floor1", "acc_floor2"}
    named = {pair.name for pair in PAIRS}
    assert {t.pair.name for t in tasks[:8]} == set(weak.SEVERITIES)
    assert named - set(weak.SEVERITIES) == {"sensor_gain", "sensor_highpass"}


def test_no_case_is_one_of_the_detection_limits():
    assert not {t.turn for t in weak.tasks()} & {t.turn for t in limits.tasks()}


def test_what_was_stated_and_how_often_it_was_right_is_printed_and_kept(
    tmp_path, monkeypatch, capsys
):
    def diagnosed(task):
        return {"mechanism": task.pair.name, "probability": 0.9, "found": task.turn % 2 == 0}

    monkeypatch.setattr(weak, "diagnosed", diagnosed)
    few = [task for task in weak.tasks() if task.pair.name == "appendage"][:12]
    monkeypatch.setattr(weak, "tasks", lambda: few)
    monkeypatch.setattr("sys.argv", ["weak", str(tmp_path / "out"), "--results", str(tmp_path)])
    weak.main()
    printed = capsys.readouterr().out
    assert "0.85 to 0.95: stated 0.900, right   6 of  12" in printed
    kept = json.loads((tmp_path / "weak_effects.json").read_text())
    assert len(kept["cases"]) == 12
    assert kept["made_with"]["commit"]


def test_what_another_version_has_found_is_kept_as_an_earlier_run(tmp_path):
    path = tmp_path / "weak_effects.json"
    assert weak.before(path, {"commit": "c"}) == []
    runs = [{"made_with": {"commit": name}, "cases": [name]} for name in ("a", "b")]
    path.write_text(json.dumps({**runs[1], "earlier": runs[:1]}))
    assert weak.before(path, {"commit": "c"}) == [runs[1], runs[0]]
    assert weak.before(path, {"commit": "b-dirty"}) == runs[:1]
