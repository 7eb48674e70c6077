"""Concealed cases: the true model's reference, the score, the campaign and its resumption."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from experiments.concealed import campaign, pictures, steps
from experiments.concealed import case as cases
from experiments.concealed.case import generate
from experiments.concealed.reference import reference
from experiments.concealed.score import score
from experiments.concealed.seal import open_seal
from twin.cli import main
from twin.errors import TwinError

FITS = {"nominal": 0.9, "calibrated": 0.5, "explained": 0.02, "noise_floor": 0.01}
NONE = {
    "verdict": "consistent", "findings": [], "alternatives": [], "twin": None,
    "fit": {"train": FITS, "test": FITS}, "fit_ahead": {"train": FITS, "test": FITS},
    "next_experiment": None, "seconds": 1.5,
}  # fmt: skip
TRUTH = {
    "mechanism": "bumper",
    "location": "storey2",
    "parameters": {"gap": -0.004, "stiffness": 900},
}
REFERENCE = {"fit": 0.01, "fit_ahead": 0.008}


@pytest.fixture
def short(monkeypatch):
    """Recordings of eight seconds."""
    draw = cases.draw_plan
    monkeypatch.setattr(
        cases, "draw_plan", lambda *a: tuple(replace(t, duration_s=8.0) for t in draw(*a))
    )


def named(mechanism, location, **values):
    parameters = {name: {"value": v, "std": None, "unit": ""} for name, v in values.items()}
    entry = {"mechanism": mechanism, "location": location, "parameters": parameters}
    return {**entry, "probability": 0.9}


def diagnosed(*findings, verdict="missing_physics", alternatives=()):
    return {
        **NONE,
        "verdict": verdict,
        "findings": list(findings),
        "alternatives": list(alternatives),
    }


def blind(model, train, test, out, seed):
    """Say bumper at storey 2 where the first test is long, give up where it is quiet."""
    assert model == "two_storey_lumped"
    assert [p.name for p in (*train, *test)] == [f"train_{i}.csv" for i in range(1, 5)] + [
        "test_1.csv", "test_2.csv",
    ]  # fmt: skip
    assert "0" not in str(train[0].parent.name)  # the name says nothing
    found = ANSWERS[train[0].read_bytes()[-6:-2][0] % 3]
    if found is None:
        raise ValueError("gave up")
    return found


ANSWERS = (NONE, None, diagnosed(named("bumper", "storey2", gap=0.004, stiffness=900.0)))


def never(*_):
    raise AssertionError("this was done already")


def test_a_right_finding_is_scored_by_its_main_parameter():
    found = score(
        TRUTH, diagnosed(named("bumper", "storey2", gap=-0.0042, stiffness=450.0)), REFERENCE
    )
    assert found["right"]
    assert found["mechanism_right"]
    assert found["place_right"]
    assert found["verdict_right"]
    assert found["rank"] == 1
    assert found["strength_error"] == pytest.approx(0.05)
    assert found["parameter_errors"]["stiffness"] == pytest.approx(0.5)
    assert found["explained_over_true"] == pytest.approx(2.0)
    assert found["explained_over_true_ahead"] == pytest.approx(2.5)
    assert not found["false_alarm"]
    assert (found["probability"], found["seconds"]) == (0.9, 1.5)


def test_wrong_findings_are_misses_with_a_rank():
    second = {**named("bumper", "storey2", gap=0.1), "delta_bic": 3.0}
    found = score(TRUTH, diagnosed(named("bumper", "storey1"), alternatives=[second]), REFERENCE)
    assert found["mechanism_right"]
    assert not found["place_right"]
    assert not found["right"]
    assert found["rank"] == 2
    assert found["strength_error"] is None
    silent = score(TRUTH, NONE, REFERENCE)
    assert not silent["mechanism_right"]
    assert silent["rank"] is None
    failed = score(TRUTH, {"error": "gave up"}, REFERENCE)
    assert failed["found"] == "error"
    assert failed["explained_over_true"] is None


def test_nothing_concealed_wants_silence():
    truth = {"mechanism": "none", "location": "", "parameters": {}}
    assert score(truth, NONE, REFERENCE)["right"]
    assert not score(truth, NONE, REFERENCE)["false_alarm"]
    loud = score(truth, diagnosed(named("mass", "floor1"), verdict="parameter"), REFERENCE)
    assert loud["false_alarm"]
    assert not loud["right"]
    assert score(truth, {"error": "gave up"}, REFERENCE)["false_alarm"]


def test_a_gain_counts_from_one_and_a_swap_has_no_order():
    gain = {"mechanism": "sensor_gain", "location": "acc_floor1", "parameters": {"gain": 0.9}}
    found = score(gain, diagnosed(named("sensor_gain", "acc_floor1", gain=0.91)), REFERENCE)
    assert found["strength_error"] == pytest.approx(0.1)
    swap = {"mechanism": "sensor_swap", "location": "acc_floor1+acc_floor2", "parameters": {}}
    found = score(swap, diagnosed(named("sensor_swap", "acc_floor2+acc_floor1")), REFERENCE)
    assert found["right"]
    assert found["strength_error"] is None


def test_the_true_model_reaches_the_noise(tmp_path, short):
    digest = generate(1, 3, tmp_path, tmp_path, "none")
    truth = open_seal(tmp_path / "none_0001.json", digest)
    reached = reference(truth, tmp_path)
    assert 0.95 * truth["noise"] < reached["fit_ahead"] < 1.3 * truth["noise"]
    assert 0.95 * truth["noise"] < reached["fit"] < 1.5 * truth["noise"]
    assert reached["fit_through_chain"] == pytest.approx(reached["fit"], rel=0.3)


def test_a_campaign_generates_seals_diagnoses_opens_scores_and_resumes(tmp_path, short):
    seen = []
    asked = {"single": 2, "none": 1}
    results = campaign.run(asked, 1, tmp_path, None, lambda *told: seen.append(told), blind)
    assert list(results) == ["case_0001", "case_0002", "none_0001"]
    assert seen[0] == ("generated", 0, 3)
    assert seen[-1] == ("opened", 3, 3)
    steps_told = [("generated", 3, 3), ("diagnosed", 0, 3), ("diagnosed", 3, 3), ("opened", 0, 3)]
    assert [told for told in seen if told in steps_told] == steps_told
    manifest = json.loads((tmp_path / "sealed" / "manifest.json").read_text())
    assert list(manifest["sha256"]) == list(results)
    assert manifest["pieces"][0]["command"] == "twin concealed --cases 2 --none 1 --seed 1"
    assert {"twin", "python", "mujoco", "numpy", "scipy", "numba"} <= set(
        manifest["pieces"][0]["versions"]
    )
    stored = json.loads((tmp_path / "diagnoses" / "case_0001.json").read_text())
    assert stored["made_with"] == manifest["pieces"][0]["versions"]
    found = json.loads((tmp_path / "summary.json").read_text())
    assert found["tables"]["single"]["cases"] == 2
    assert found["tables"]["none"]["false_alarm"]["of"] == 1
    assert np.sum(found["confusion"]["counts"]) == 3
    assert (tmp_path / "confusion.png").stat().st_size > 5000
    console = Console(width=120, record=True, file=io.StringIO())
    pictures.show(console, found)
    assert "of 1 with nothing concealed" in console.export_text()
    assert campaign.run(asked, 1, tmp_path, diagnose=never) == results
    with pytest.raises(TwinError, match="another campaign"):
        campaign.run(asked, 2, tmp_path, None, None, blind)


def test_a_campaign_grows_and_stops_when_its_time_is_up(tmp_path, short):
    assert campaign.run({"none": 1}, 1, tmp_path, diagnose=never, budget_s=-1) == {}
    assert not list((tmp_path / "diagnoses").glob("*.json"))
    first = campaign.run({"none": 1}, 1, tmp_path, diagnose=blind)
    more = campaign.run({"none": 2}, 1, tmp_path, diagnose=blind)
    assert list(more) == ["none_0001", "none_0002"]
    assert more["none_0001"] == first["none_0001"]
    pieces = json.loads((tmp_path / "sealed" / "manifest.json").read_text())["pieces"]
    assert [piece["cases"] for piece in pieces] == [1, 1]
    with pytest.raises(TwinError, match="no table 'two' of concealed cases; there are single"):
        campaign.run({"two": 1}, 1, tmp_path, diagnose=blind)


def test_a_truth_that_was_touched_after_it_was_sealed_stops_the_campaign(tmp_path, short):
    campaign.run({"none": 1}, 1, tmp_path, diagnose=blind, budget_s=-1)
    path = tmp_path / "sealed" / "none_0001.json"
    path.write_text(path.read_text().replace("none", "bumper"))
    with pytest.raises(TwinError, match="the seal is broken"):
        campaign.run({"none": 1}, 1, tmp_path, diagnose=blind)


def test_a_seal_stays_closed_until_there_is_a_diagnosis(tmp_path):
    opening = steps.Opening(tmp_path / "a.json", "", tmp_path, tmp_path / "diagnoses" / "a.json")
    with pytest.raises(TwinError, match="the seal stays closed"):
        steps.open_and_score(opening)


def test_a_campaign_runs_on_dask(tmp_path, short):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        results = campaign.run({"none": 2}, 1, tmp_path, client.get_executor(), None, blind)
    assert len(results) == 2


def test_the_command_asks_for_work_and_for_a_cluster_that_is_there(tmp_path, capsys):
    def refused(*arguments):
        with pytest.raises(SystemExit) as stop:
            main(["concealed", "--out", str(tmp_path), *arguments])
        assert stop.value.code == 2
        return capsys.readouterr().err

    assert "nothing to do" in refused("--cases", "0", "--none", "0")
    assert "no table 'two'; there are single, none" in refused("--table", "two=3")
    assert "expected NAME=COUNT" in refused("--table", "single=many")
    pytest.importorskip("distributed")
    assert "no Dask cluster there" in refused("--cases", "1", "--scheduler", "nowhere")
