"""The section on any structure counts what its campaigns left."""

import json

from experiments.any_structure import closed, identified, rows_of
from experiments.structures_identified import true_modes


def test_draws_are_counted_within_three_deviations(tmp_path):
    modes = len(true_modes("cantilever")[0])
    sound = {"frequency": [1.0] * modes, "damping": [-2.0] * modes, "spurious": 0}
    off = {"frequency": [4.0] * modes, "damping": [None] * modes, "spurious": 1}
    lines = [{"campaign": "identified"}]
    lines += [{"name": f"cantilever {i}", "result": r} for i, r in enumerate((sound, sound, off))]
    (tmp_path / "draws.jsonl").write_text("\n".join(json.dumps(line) for line in lines))
    rows = identified(rows_of(tmp_path, "draws.jsonl"))["rows"]
    assert [row[2].split(" (")[0] for row in rows] == ["2 of 3"] * modes
    assert [row[3].split(" (")[0] for row in rows] == ["2 of 3"] * modes
    assert rows[0][4] == 1


def test_the_closure_counts_only_the_steps_there_are():
    row = {"place": "storey1", "own": "right", "named": "right", "again": "consistent: nothing"}
    plain = {"place": "", "own": "right", "named": "-", "again": "-"}
    table = closed({"chain plain": plain, "chain mass": row})
    assert table["rows"][-1][3:] == ["2 of 2", "1 of 1", "0 of 1"]
