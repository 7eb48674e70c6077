"""``twin diagnose``: from files to files, and input that it refuses."""

import json
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from diagnosis_support import lumped, recorded

from twin import cli, mechanisms
from twin.cli import main
from twin.cli.diagnose import TWIN_FILE, diagnose_files, masses_of
from twin.errors import TwinError
from twin.formats import write_recording
from twin.model import Twin

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")  # as the command line does

SOFT = mechanisms.vocabulary()["stiffness"]("storey1", -40.0)


def called(arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    return stop.value.code


@pytest.fixture
def command(monkeypatch):
    """The command as it stands, whether or not the program lists it yet."""
    monkeypatch.setattr(cli, "COMMANDS", tuple(dict.fromkeys([*cli.COMMANDS, "diagnose"])))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    paths = [folder / name for name in ("one.csv", "two.csv", "unseen.csv")]
    for seed, path in enumerate(paths, start=1):
        write_recording(recorded(lumped(SOFT), seed, 0.6, 8.0), path)
    return paths


def options(files):
    return ["--train", files[0], "--train", files[1], "--test", files[2]]


@pytest.fixture(scope="module")
def ended(files, tmp_path_factory):
    """Exit code, standard output and folder of the command, from end to end."""
    for name in ("tables", "report", "rrd"):
        pytest.importorskip(f"twin.view.diagnosis_{name}")
    out = tmp_path_factory.mktemp("diagnosis")
    with redirect_stdout(StringIO()) as printed:
        code = called(
            ["diagnose", "two_storey_lumped", *options(files), "--json", "-", "--out", out]
        )
    return code, printed.getvalue(), out


def test_a_soft_storey_is_told_on_standard_output_and_nothing_else_is(ended):
    code, printed, _ = ended
    assert code == 0
    found = json.loads(printed)
    assert found["verdict"] == "parameter"
    (finding,) = found["findings"]
    assert (finding["mechanism"], finding["location"]) == ("stiffness", "storey1")
    assert finding["parameters"]["change"]["value"] == pytest.approx(-40.0, rel=0.02)
    assert found["fit"]["test"]["explained"] < 1.2 * found["fit"]["test"]["noise_floor"]
    assert found["fit"]["test"]["nominal"] > 0.1


def test_the_explained_twin_and_its_papers_are_written(ended):
    _, printed, out = ended
    assert {TWIN_FILE, "diagnosis.json", "diagnosis.html", "diagnosis.rrd"} <= {
        p.name for p in out.iterdir()
    }
    found = json.loads(printed)
    assert json.loads((out / "diagnosis.json").read_text()) == found
    assert found["twin"] == str(out / TWIN_FILE)
    K, true = (t.second_order().K for t in (Twin.load(found["twin"]), lumped(SOFT)))
    assert abs(K - true).max() < 0.005 * true.max()


def test_files_are_diagnosed_without_the_command_as_with_it(files, monkeypatch, tmp_path):
    """What is read and written; the diagnosis itself is that of the command."""
    asked = {}

    class EnoughError(Exception):
        pass

    def whole(twin, train, test, **given):
        asked.update(given, train=[r.source for r in train], test=[r.source for r in test])
        raise EnoughError

    monkeypatch.setattr("twin.diagnosis.pipeline.diagnose", whole)
    with pytest.raises(EnoughError):
        diagnose_files("two_storey_lumped", files[:2], files[2:], tmp_path, seed=7)
    assert [Path(n).name for n in asked["train"]] == ["one.csv", "two.csv"]
    assert [Path(n).name for n in asked["test"]] == ["unseen.csv"]
    assert asked["seed"] == 7


def refused(arguments, capsys, out):
    assert called([*arguments, "--out", out]) == 2
    error = capsys.readouterr().err
    assert len(error.strip().splitlines()) == 1, error
    assert not list(out.glob("*"))
    return error


@pytest.mark.usefixtures("command")
def test_a_test_that_is_trained_on_is_refused_in_one_line(files, tmp_path, capsys):
    same = ["diagnose", "two_storey_lumped", "--train", files[0], "--test", files[0]]
    assert "one.csv" in refused(same, capsys, tmp_path / "o")
    copy = tmp_path / "copy.csv"
    copy.write_bytes(files[0].read_bytes())
    copied = ["diagnose", "two_storey_lumped", "--train", files[0], "--test", copy]
    assert "copy.csv" in refused(copied, capsys, tmp_path / "o")


@pytest.mark.usefixtures("command")
def test_recordings_must_be_given_and_be_there(files, tmp_path, capsys):
    alone = ["diagnose", "two_storey_lumped", "--train", files[0]]
    assert "--test" in refused(alone, capsys, tmp_path / "o")
    gone = ["diagnose", "two_storey_lumped", "--train", "gone.csv", "--test", files[2]]
    assert "gone.csv" in refused(gone, capsys, tmp_path / "o")


@pytest.mark.usefixtures("command")
@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("one.csv:floor2=heavy", "expected FILE:PLACE=KG"),
        ("one.csv:floor2", "expected FILE:PLACE=KG"),
        ("one.csv", "expected FILE:PLACE=KG"),
        ("other.csv:floor2=0.5", "there are one.csv, two.csv, unseen.csv"),
        ("floor2=0.5", "is no recording of this diagnosis"),
        ("one.csv:roof=0.5", "no place 'roof' for an added mass; there are floor1, floor2"),
    ],
)
def test_an_added_mass_that_cannot_be_is_refused_in_one_line(files, tmp_path, capsys, option, said):
    arguments = ["diagnose", "two_storey_lumped", *options(files), "--added-mass", option]
    assert said in refused(arguments, capsys, tmp_path / "o")


def test_added_masses_are_read_by_recording_and_place():
    files = [Path("lab/one.csv"), Path("lab/two.csv")]
    given = ["one.csv:floor2=0.5", "lab/one.csv:floor1=-0.25", "two.csv:floor1=1e-1"]
    assert masses_of(given, files) == {
        "one.csv": {"floor2": 0.5, "floor1": -0.25}, "two.csv": {"floor1": 0.1},
    }  # fmt: skip
    assert masses_of([], files) == {}
    with pytest.raises(TwinError, match="--added-mass"):
        masses_of(["three.csv:floor1=1"], files)


@pytest.mark.usefixtures("command")
@pytest.mark.parametrize("option", ["--tolerance", "--damping-tolerance"])
@pytest.mark.parametrize("value", ["0", "-1", "1e9", "some"])
def test_a_tolerance_out_of_range_is_refused(files, tmp_path, capsys, option, value):
    arguments = ["diagnose", "two_storey_lumped", *options(files), option, value]
    assert option in refused(arguments, capsys, tmp_path / "o")


@pytest.mark.parametrize("value", ["nan", "inf"])
def test_a_mass_that_is_no_number_is_refused(value):
    with pytest.raises(TwinError, match="--added-mass"):
        masses_of([f"one.csv:floor2={value}"], [Path("one.csv")])
