"""``twin rehearse`` from the command line."""

import json

import pytest
from rehearsal_support import table

from twin.cli import main


def call(*words):
    with pytest.raises(SystemExit) as stop:
        main(["rehearse", *map(str, words)])
    return stop.value.code


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(table()))
    return path


def test_it_prints_a_table_and_writes_json(written, tmp_path, capsys):
    out = tmp_path / "out"
    assert call("two_storey_lumped", "--plan", written, "--out", out, "--json", "-") == 0
    shown = capsys.readouterr()
    document = json.loads(shown.out)
    assert json.loads((out / "rehearsal.json").read_text()) == document
    assert [x["location"] for x in document["limits"]] == ["storey1", "storey2"]
    first = document["limits"][0]
    assert first["unit"] == "N"
    assert 0 < first["limit"] == first["predicted"]
    assert first["share_of"] == "the elastic force"
    assert first["mistaken_for"] == "microslip at storey1"
    assert "coulomb_friction" in shown.err


def test_the_same_seed_gives_the_same(written, tmp_path, capsys):
    texts = []
    for seed in (3, 3, 4):
        call("two_storey_lumped", "--plan", written, "--out", tmp_path, "--seed", seed, "--json",
             "-")  # fmt: skip
        texts.append(json.loads(capsys.readouterr().out)["limits"])
    assert texts[0] == texts[1] != texts[2]


def test_a_bad_plan_is_one_line_and_writes_nothing(written, tmp_path, capsys):
    written.write_text(json.dumps(table(tolerance=-1)))
    assert call("two_storey_lumped", "--plan", written, "--out", tmp_path / "out") == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "tolerance: expected a positive number" in error
    assert not (tmp_path / "out").exists()
