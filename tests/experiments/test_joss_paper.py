"""The draft of the paper: what is written is what the results say, and what is cited is there."""

import re
from pathlib import Path

from experiments import joss_paper

ROOT = Path(__file__).resolve().parents[2]


def test_the_draft_is_that_of_the_results():
    written = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    assert joss_paper.paper() == written, "run python experiments/joss_paper.py"


def test_no_number_of_a_result_stands_in_the_template():
    template = ROOT / "experiments" / "templates" / joss_paper.TEMPLATE
    body = template.read_text(encoding="utf-8").split("# Results", 1)[1]
    bare = re.sub(r"\{\{.*?\}\}|\{%.*?%\}|@\w+|p = 20|\bC\b", "", body)
    numbers = re.findall(r"(?<![\w.ζ])\d+(?:\.\d+)?", bare)
    assert set(numbers) <= {"1", "95"}, numbers  # the bound's, and the intervals'


def test_every_reference_is_there_and_is_cited():
    entries = (ROOT / "docs" / "paper.bib").read_text(encoding="utf-8")
    keys = set(re.findall(r"^@\w+\{(\w+),", entries, re.M))
    text = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    assert joss_paper.cited() | {"juang1985", "juang1993"} == keys
    assert all(f"@{key}" in text for key in keys)


def test_a_changed_result_changes_the_draft(monkeypatch):
    real = joss_paper._results

    def changed(name):
        document = real(name)
        if name == "concealed":
            document["rows"] = document["rows"][:-1]
        return document

    monkeypatch.setattr(joss_paper, "_results", changed)
    assert joss_paper.paper() != (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
