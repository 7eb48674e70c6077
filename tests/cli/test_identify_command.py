import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from twin.cli import main
from twin.formats import write_recording
from twin.laboratory import Experiment, run
from twin.model import Twin

SCHEMA = Path(__file__).parents[3] / "shared" / "contracts" / "identification.schema.json"


@pytest.fixture(scope="module")
def recording():
    return run(Experiment(), Twin.load("two_storey_lumped"), 0)


@pytest.fixture
def file(recording, tmp_path):
    path = tmp_path / "hammer.csv"
    write_recording(recording, path)
    return path


def called(arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    return stop.value.code


def test_the_json_on_standard_output_is_the_contracts(file, tmp_path, capsys):
    assert called(["identify", file, "--order", 4, "--json", "-", "--out", tmp_path / "o"]) == 0
    found = json.loads(capsys.readouterr().out)
    if SCHEMA.exists():
        jsonschema.validate(found, json.loads(SCHEMA.read_text()))
    assert found["order"] == 4
    np.testing.assert_allclose(
        [m["frequency_hz"] for m in found["modes"]], [1.949, 6.715], atol=5e-4
    )
    assert found["inputs"] == ["force_floor1"]
    assert np.shape(found["M"]) == (2, 2)


def test_figures_and_one_rerun_recording_are_written(file, tmp_path):
    out = tmp_path / "found"
    assert called(["identify", file, "--out", out]) == 0
    names = {p.name for p in out.iterdir()}
    assert "identification.rrd" in names
    assert {"frequency_responses.png", "stabilisation.png"} <= names


def test_the_true_model_is_laid_beside(file, tmp_path, capsys):
    arguments = ["identify", file, "--model", "two_storey_lumped", "--out", tmp_path / "o"]
    assert called(arguments) == 0
    printed = capsys.readouterr().out
    assert "true" in printed
    assert "Cramér-Rao" in printed


def test_an_unseen_recording_gets_its_error(recording, file, tmp_path, capsys):
    other = tmp_path / "other.csv"
    write_recording(run(Experiment(at="floor1"), Twin.load("two_storey_lumped"), 5), other)
    arguments = ["identify", file, "--test", other, "--json", "-", "--out", tmp_path / "o"]
    assert called(arguments) == 0
    errors = json.loads(capsys.readouterr().out)["unseen_nrmse"]
    assert all(0 < error < 0.01 for error in errors.values())
    assert len(errors) == 1


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda t: t.replace("force_floor1 [N]", "force_floor1 [parsec]"), "parsec"),
        (lambda t: t.replace("acc_floor2", "acc_floor1"), "acc_floor1"),
        (lambda t: t.replace("acc_floor2 [m/s^2]", "acc_attic"), "acc_attic"),
        (lambda t: "\n".join(t.splitlines()[:12]), "too few"),
        (lambda _: "", "empty"),
    ],
    ids=["unit", "doubled", "unknown", "short", "empty"],
)
def test_bad_input_ends_with_one_line_that_names_the_file(file, tmp_path, capsys, damage, said):
    bad = tmp_path / "bad.csv"
    bad.write_text(damage(file.read_text()))
    out = tmp_path / "nothing"
    assert called(["identify", bad, "--out", out]) == 2
    error = capsys.readouterr().err
    assert len(error.strip().splitlines()) == 1, error
    assert "bad.csv" in error
    assert said in error
    assert not out.exists()


def test_unseen_without_a_period_is_refused(file, capsys):
    assert called(["identify", file, "--unseen", 2]) == 2
    assert "--period" in capsys.readouterr().err


def test_a_json_file_that_cannot_be_written_is_refused_before_the_work(file, tmp_path, capsys):
    assert called(["identify", file, "--json", tmp_path / "no" / "x.json"]) == 2
    assert "cannot write the JSON" in capsys.readouterr().err


def test_poles_can_be_chosen_by_their_frequencies(file, tmp_path, capsys):
    out = tmp_path / "o"
    assert called(["identify", file, "--poles", "6.7", "--json", "-", "--out", out]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [m["frequency_hz"] for m in found["modes"]] == pytest.approx([6.715], abs=2e-2)
    assert any("by hand" in note for note in found["notes"])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--poles", "300"], "no pole lies within 1 % of 300 Hz; the nearest"),
        (["--poles", "a,b"], "frequencies in Hz"),
        (["--poles", "2", "--pick"], "give one of them"),
        (["--pick"], "here is no screen"),
    ],
)
def test_a_choice_that_cannot_be_is_one_line(file, tmp_path, capsys, options, said):
    assert called(["identify", file, *options, "--out", tmp_path / "o"]) == 2
    error = capsys.readouterr().err
    assert len(error.strip().splitlines()) == 1
    assert said in error
    assert not (tmp_path / "o").exists()


def test_the_window_of_the_diagram_chooses(file, tmp_path, capsys, monkeypatch):
    seen = []

    def pick(diagram):
        seen.append(diagram)
        return np.array([p.pole for p in diagram.poles if p.stable and p.frequency_hz < 3][-1:])

    monkeypatch.setattr("twin.view.poles.pick_by_hand", pick)
    assert called(["identify", file, "--pick", "--json", "-", "--out", tmp_path / "o"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [m["frequency_hz"] for m in found["modes"]] == pytest.approx([1.949], abs=5e-3)
    assert seen[0].curves.shape == (len(seen[0].frequency_hz), 1)


@pytest.mark.parametrize("again", [[], ["--test"]])
def test_a_file_named_twice_is_no_second_measurement(file, tmp_path, capsys, again):
    assert called(["identify", file, *again, file.parent / "." / file.name]) == 2
    assert "named twice; it would count as two measurements" in capsys.readouterr().err


@pytest.mark.parametrize("band", [("-1", "2"), ("5", "2"), ("nan", "2"), ("2", "2")])
def test_a_band_that_is_none_is_refused(file, capsys, band):
    assert called(["identify", file, "--band", *band]) == 2
    assert "two frequencies [Hz], the lower first" in capsys.readouterr().err
