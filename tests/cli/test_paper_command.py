"""The command ``twin paper``."""

import json

import pytest
import typer
from typer.testing import CliRunner

from twin.cli import paper


@pytest.fixture
def run(monkeypatch):
    app = typer.Typer()
    paper.register(app)
    app.callback()(lambda: None)
    monkeypatch.setenv("COLUMNS", "80")
    return lambda *arguments: CliRunner().invoke(app, ["paper", *arguments])


def test_it_prints_both_numbers_side_by_side_and_the_contradictions(run):
    result = run()
    assert result.exit_code == 0
    assert max(len(line) for line in result.stdout.splitlines()) <= 80
    row = next(line for line in result.stdout.splitlines() if "f_n,1" in line)
    assert row.split() == ["(9)", "f_n,1", "[Hz]", "1.949", "1.9488", "(2)-(7)", "agrees"]
    assert "25 contradictions." in result.stdout
    assert "N5" in result.stdout


def test_json_on_standard_output_is_nothing_but_json(run):
    result = run("--json", "-")
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    assert len(found["contradictions"]) == 25
    assert sum(found["verdicts"].values()) == len(found["entries"])
    assert "contradictions." in result.stderr


def test_a_folder_gets_the_table_and_the_json(run, tmp_path):
    result = run("--out", str(tmp_path / "new"), "--json", str(tmp_path / "again.json"))
    assert result.exit_code == 0
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [
        "ledger.json",
        "ledger.txt",
    ]
    assert (tmp_path / "new/ledger.json").read_text() == (tmp_path / "again.json").read_text()
    text = (tmp_path / "new/ledger.txt").read_text()
    assert max(len(line) for line in text.splitlines()) <= 100
    assert "25 contradictions." in text


def test_its_help_has_an_example(run):
    result = run("--help")
    assert result.exit_code == 0
    assert "twin paper --json -" in " ".join(result.stdout.split())
