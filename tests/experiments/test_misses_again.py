"""Misses diagnosed again: the right cases, made anew, and nothing said of another one."""

import json
from dataclasses import replace

import pytest
from quick_campaign import quick, reached

from experiments import misses_again as again
from experiments import proof_sections
from experiments.concealed import case as cases
from experiments.concealed import steps
from experiments.condense_campaign import row


def said(right, ahead=1.0, not_worse=True, found="mass floor1"):
    return {"right": right, "found": found, "probability": 0.9,
            "explained_over_calibrated_ahead": ahead, "ahead_not_worse": not_worse}  # fmt: skip


@pytest.fixture
def source(tmp_path):
    """Three campaigns, two of them with a case that foresaw worse."""
    pieces = [{"command": f"twin concealed --cases 4 --seed {seed}"} for seed in (31, 32, 33)]
    names = {
        "1/case_0001": said(True), "1/case_0002": said(False), "2/none_0003": said(True),
        "2/case_0005": said(True, 1.1, False),
        "3/pairs_0004": said(False), "3/case_0010": said(True, 1.2, False),
    }  # fmt: skip
    truth = {"table": "single", "effects": []}
    rows = [
        {"case": name, "truth": truth, "sha256": "", "score": score}
        for name, score in names.items()
    ]
    path = tmp_path / "concealed.json"
    path.write_text(json.dumps({"campaigns": [{"pieces": [p]} for p in pieces], "rows": rows}))
    return path


def test_what_foresaw_worse_comes_first_and_then_the_newest_misses(source):
    tasks = again.tasks(source)
    assert [t.name for t in tasks] == ["3/case_0010", "2/case_0005", "3/pairs_0004", "1/case_0002"]
    assert [t.seed for t in tasks] == [33, 32, 33, 31]
    assert [t.number for t in tasks] == [10, 5, 4, 2]


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A case of eight seconds, and what is kept of its truth."""
    draw = cases.draw_plan
    short = lambda *a: tuple(replace(t, duration_s=8.0) for t in draw(*a))  # noqa: E731
    monkeypatch.setattr(cases, "draw_plan", short)
    monkeypatch.setattr(steps, "reference", reached)
    monkeypatch.setattr(steps, "of_the_command", lambda: quick)
    recordings, sealed = tmp_path / "recordings", tmp_path / "sealed"
    for folder in (recordings, sealed):
        folder.mkdir()
    digest = steps.conceal(steps.Concealing("single", 2, 31, recordings, sealed))["sha256"]
    kept = tmp_path / "kept.json"
    steps.diagnose_blind(steps.Blind(recordings / "case_0002", "two_storey_lumped", kept, ()))
    opening = steps.Opening(sealed / "case_0002.json", digest, recordings, kept)
    return row("1/case_0002", digest, steps.open_and_score(opening))


def test_a_case_is_made_anew_from_its_seed_and_scored(made):
    task = again.Again("1/case_0002", "single", 31, made["truth"], said(False))
    found = again.diagnosed_again(task)
    assert found["now"] == {key: made["score"][key] for key in again.SAYS}
    assert found["now"]["found"] == "mass floor1"
    assert found["before"] == said(False)


def test_nothing_is_said_of_another_case(made):
    other = {**made["truth"], "noise": made["truth"]["noise"] * 1.001}
    found = again.diagnosed_again(again.Again("1/case_0002", "single", 31, other, said(False)))
    assert found["now"] is None


def test_the_page_counts_what_is_mended():
    def case(name, before, now):
        effects = [{"mechanism": "bumper", "location": "storey1"}]
        return {"case": name, "truth": {"effects": effects}, "before": before, "now": now}

    given = {
        "made_with": {"commit": "abc"},
        "cases": [
            case("1/case_0002", said(False), said(False)),
            case("1/case_0001", said(False), said(True, found="bumper storey1")),
            case("1/case_0003", said(True, 1.2, False), said(True)),
            case("1/case_0004", said(False), None),
        ],
    }
    section = proof_sections.section("misses_again", given)
    assert "commit abc" in section["text"]
    assert "Of 2 that were missed 1 are answered rightly" in section["text"]
    assert "of 1 that foresaw worse 1 no longer do" in section["text"]
    rows = section["tables"][0]["rows"]
    assert rows[0] == ["1/case_0001", "bumper storey1", "mass floor1 (missed)", "bumper storey1",
                       "1", "1"]  # fmt: skip
    assert [r[-2] for r in rows] == ["1", "1", "1.2"]
