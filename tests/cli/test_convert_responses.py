"""``twin convert --responses``: what it writes is what was measured, and is read back."""

import json

import numpy as np
import pytest

from twin import hammer_test
from twin.cli import main
from twin.formats import write_recording
from twin.formats.responses import holds_responses, read_responses
from twin.identification.records import prepare
from twin.signals.frf import measured_response


def run(*arguments):
    with pytest.raises(SystemExit) as stopped:
        main([*arguments])
    return stopped.value.code


@pytest.fixture(scope="module")
def hits(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hits")
    made = [
        hammer_test("two_storey_lumped", noise=0.02, input_noise=0.02, seed=s) for s in range(3)
    ]
    paths = [folder / f"hit{i}.csv" for i in range(3)]
    for hit, path in zip(made, paths, strict=True):
        write_recording(hit, path)
    return made, [str(path) for path in paths]


@pytest.mark.parametrize("name", ["H1", "H2", "Hv"])
def test_the_file_holds_the_estimator_that_was_asked_for(hits, tmp_path, name):
    made, paths = hits
    target = tmp_path / "responses.csv"
    assert run("convert", *paths, str(target), "--responses", name.lower()) == 0
    records = prepare(made)
    expected = measured_response(records.pairs, 1 / records.dt, name)
    assert holds_responses(target)
    found = read_responses(target)
    assert (found.outputs, found.inputs) == (records.outputs, records.inputs)
    at = np.searchsorted(expected.frequency_hz, found.frequency_hz - 1e-9)
    size = np.abs(expected.H[at]).max()
    np.testing.assert_allclose(found.H, expected.H[at], atol=1e-4 * size)
    np.testing.assert_allclose(found.coherence[:, :, 0], expected.coherence[at], atol=1e-3)
    header, first = target.read_text().splitlines()[:2]
    column = header.split(",").index("acc_floor1/force_floor1 deviation")
    told = float(first.split(",")[column])
    assert told == pytest.approx(np.sqrt(expected.variance[at[0], 0, 0]), rel=0.01)


def test_the_estimators_are_told_apart(hits, tmp_path):
    size = {}
    for name in ("H1", "H2", "Hv"):
        target = tmp_path / f"{name}.csv"
        run("convert", *hits[1], str(target), "--responses", name)
        size[name] = np.abs(read_responses(target).H)
    assert np.all(size["H1"] <= size["Hv"] * (1 + 1e-9))
    assert np.all(size["Hv"] <= size["H2"] * (1 + 1e-9))
    assert np.mean(size["H2"] / size["H1"]) > 1.001


def test_one_hit_has_no_deviation_and_it_is_said(hits, tmp_path, capsys):
    target, out = tmp_path / "one.csv", tmp_path / "one.json"
    arguments = ["convert", hits[1][0], str(target), "--responses", "H1", "--json", str(out)]
    assert run(*arguments) == 0
    assert "neither coherence nor deviations" in capsys.readouterr().err
    assert "deviation" not in target.read_text().splitlines()[0]
    assert json.loads(out.read_text())["blocks"] == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["x.csv", "--responses", "H9"], "there are H1, H2, Hv"),
        (["x.uff", "--responses", "H1"], "written as .csv"),
        (["x.csv", "--responses", "H1", "--start", "1"], "whole recordings"),
        (["x.csv"], "several recordings go with --responses"),
    ],
)
def test_what_cannot_be_is_one_line(hits, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert run("convert", *hits[1], *arguments) == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert said in error[-1]
