"""The page of the proof: everything on it comes from the results."""

import json
import shutil
from pathlib import Path

import pytest

from experiments import condense_campaign, proof_calibration, proof_page
from twin.errors import TwinError

ROOT = Path(__file__).resolve().parents[2]
FRICTION, CUBIC = ("coulomb_friction", "storey1"), ("cubic_stiffness", "storey2")


def result(table, effects, found, probability, verdict):
    errors = {"nominal": 0.5, "calibrated": 0.2, "explained": 0.011, "noise_floor": 0.01}
    fits = {"train": errors, "test": errors}
    findings = [
        {"mechanism": m, "location": p, "parameters": {}, "probability": probability}
        for m, p in found
    ]
    truth = {
        "table": table, "model": "two_storey_lumped", "expected": "missing_physics",
        "effects": [
            {"mechanism": m, "location": p, "parameters": {}, "form": ""} for m, p in effects
        ],
        "mechanism": effects[0][0] if effects else "none",
        "location": effects[0][1] if effects else "", "parameters": {}, "form": "",
        "noise": 0.01, "style": "linear", "effect_over_noise": 12.0 if effects else 0.0,
    }  # fmt: skip
    diagnosis = {
        "verdict": verdict, "findings": findings, "alternatives": [], "fit": fits,
        "fit_ahead": fits, "seconds": 11.0, "made_with": {"twin": "1"},
    }  # fmt: skip
    return {"truth": truth, "diagnosis": diagnosis, "reference": {"fit": 0.01, "fit_ahead": 0.01}}


@pytest.fixture
def campaign(tmp_path):
    friction, cubic = FRICTION, CUBIC
    results = {
        "case_0001": result("single", [friction], [friction], 0.98, "missing_physics"),
        "case_0002": result("single", [cubic], [friction], 0.6, "missing_physics"),
        "none_0001": result("none", [], [], None, "consistent"),
        "pairs_0001": result("pairs", [friction, cubic], [cubic, friction], 0.9, "missing_physics"),
    }
    folder = tmp_path / "campaign"
    (folder / "sealed").mkdir(parents=True)
    digests = {name: f"{number:064x}" for number, name in enumerate(results)}
    pieces = [{"written": "today", "command": "twin concealed --seed 5", "versions": {"twin": "1"},
               "cases": 4}]  # fmt: skip
    manifest = {"pieces": pieces, "sha256": digests}
    (folder / "sealed" / "manifest.json").write_text(json.dumps(manifest))
    lines = [{"campaign": "concealed cases of seed 5"}]
    lines += [{"name": name, "result": one} for name, one in results.items()]
    (folder / "results.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    return folder


def test_condensed_results_keep_the_truth_s_digest_and_score_anew(campaign):
    document = condense_campaign.condensed([campaign])
    rows = {row["case"]: row for row in document["rows"]}
    assert rows["case_0001"]["sha256"] == f"{0:064x}"
    assert rows["case_0001"]["score"]["right"]
    assert not rows["case_0002"]["score"]["right"]
    assert rows["pairs_0001"]["score"]["right"], "both effects, in any order"
    assert document["campaigns"][0]["pieces"][0]["command"] == "twin concealed --seed 5"


def test_a_campaign_is_added_to_those_that_were_condensed_before(campaign, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(campaign, other)
    manifest = json.loads((other / "sealed" / "manifest.json").read_text())
    manifest["pieces"][0]["command"] = "twin concealed --seed 6"
    (other / "sealed" / "manifest.json").write_text(json.dumps(manifest))
    kept = tmp_path / "kept.json"
    both = condense_campaign.condensed([campaign, other])
    kept.write_text(condense_campaign.as_text(both))
    manifest["pieces"][0]["command"] = "twin concealed --seed 7"
    (other / "sealed" / "manifest.json").write_text(json.dumps(manifest))
    three = condense_campaign.condensed([other], kept)
    assert three["rows"][:8] == both["rows"]
    assert [row["case"] for row in three["rows"][8:]] == [
        "3/case_0001", "3/case_0002", "3/none_0001", "3/pairs_0001",
    ]  # fmt: skip
    with pytest.raises(TwinError, match="there already"):
        condense_campaign.condensed([campaign], kept)
    kept.write_text(condense_campaign.as_text(condense_campaign.condensed([campaign])))
    with pytest.raises(TwinError, match="which campaign"):
        condense_campaign.condensed([other], kept)
    kept.write_text("{}")
    with pytest.raises(TwinError, match="cannot read"):
        condense_campaign.condensed([other], kept)


def test_the_page_tells_rates_misses_and_commands(campaign, tmp_path):
    results = tmp_path / "results"
    results.mkdir()
    text = condense_campaign.as_text(condense_campaign.condensed([campaign]))
    (results / "concealed.json").write_text(text)
    page = proof_page.write_page(results, tmp_path / "docs").read_text()
    assert "4 laboratory structures" in page
    assert "1 of 2 | 50" in page
    assert (
        "| case_0002 | single | cubic_stiffness storey2 | coulomb_friction storey1 | 0.6 |" in page
    )
    assert "twin concealed --seed 5" in page
    assert "nan" not in page.lower()
    for name in ("rates", "calibration", "fit_ratios", "confusion"):
        assert (tmp_path / "docs" / "proof" / f"{name}.png").stat().st_size > 2000


def test_laws_that_are_nearly_in_the_vocabulary_have_a_table_where_there_are_some(
    campaign, tmp_path
):
    results = tmp_path / "results"
    results.mkdir()
    document = condense_campaign.condensed([campaign])
    (results / "concealed.json").write_text(condense_campaign.as_text(document))
    title = "### Laws that are nearly in the vocabulary"
    assert title not in proof_page.write_page(results, tmp_path / "docs").read_text()
    dahl = result("near", [("dahl_friction", "storey1")], [FRICTION, CUBIC], 0.9, "missing_physics")
    dahl["truth"]["evidence"] = {"explained": 0.8}
    dahl["diagnosis"]["findings"][0]["explained"] = 0.75
    document["rows"].append(condense_campaign.row("near_0001", "0", dahl))
    (results / "concealed.json").write_text(condense_campaign.as_text(document))
    page = proof_page.write_page(results, tmp_path / "docs").read_text()
    assert title in page
    assert "| something else named besides | 1 of 1 |" in page
    assert "| share explained within 10 points of the true one | 1 of 1 |" in page


def test_the_page_points_from_what_foresaw_worse_to_what_is_said_of_it_now(campaign, tmp_path):
    results = tmp_path / "results"
    results.mkdir()
    document = condense_campaign.condensed([campaign])
    one = document["rows"][0]["score"]
    one["ahead_not_worse"], one["explained_over_calibrated_ahead"] = False, 1.25
    (results / "concealed.json").write_text(condense_campaign.as_text(document))
    pointer = 'What the present version says of them: "The misses again" below.'
    page = proof_page.write_page(results, tmp_path / "docs").read_text()
    assert "in these cases" in page
    assert "| 1.25 |" in page
    assert pointer not in page
    again = {"made_with": {"commit": "abc"}, "cases": []}
    (results / "misses_again.json").write_text(json.dumps(again))
    page = proof_page.write_page(results, tmp_path / "docs").read_text()
    assert page.index(pointer) < page.index("\n## The misses again")


def test_weak_effects_count_beside_the_sealed_cases_where_they_were_run(tmp_path):
    rows = [{"score": {"probability": 0.9, "first_right": True, "false_alarm": False}}]
    alone = proof_calibration.table(rows, tmp_path)
    assert alone["rows"][0][2:5] == ["1 of 1", "-", "1 of 1"]
    cases = [{"probability": p, "found": f} for p, f in ((0.9, False), (0.6, True), (None, False))]
    (tmp_path / "detection_limits.json").write_text(json.dumps({"cases": cases}))
    both = proof_calibration.table(rows, tmp_path)
    assert [row[0] for row in both["rows"]] == ["0.5 to 0.7", "0.85 to 0.95"]
    assert both["rows"][1][2:6] == ["1 of 1", "0 of 1", "1 of 2", "50.0 %"]
    (tmp_path / "weak_effects.json").write_text(json.dumps({"cases": cases[:1]}))
    more = proof_calibration.table([*rows, *rows], tmp_path)
    assert more["rows"][1][2:5] == ["2 of 2", "0 of 2", "2 of 4"]
    assert [one["right"]["of"] for one in more["curve"]] == [1, 4]
    (tmp_path / "weak_effects.json").write_text(
        json.dumps({"cases": cases[:1], "earlier": [{"cases": cases}]})
    )
    more = proof_calibration.table([*rows, *rows], tmp_path)
    assert more["rows"][1][2:5] == ["2 of 2", "0 of 3", "2 of 5"]
