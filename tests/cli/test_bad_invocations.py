"""A hundred ways to call a command wrongly: exit code 2, one line, nothing written."""

import shlex

import pytest

from twin.cli import main
from twin.formats import write_recording
from twin.recording import Recording

MODEL = "two_storey_lumped"
BOTH = "--train a.csv --test b.csv"
WRONG = {
    "": ["nosuch", "--nope", "identify --help-me"],
    "identify": [
        "", "no.csv", "empty.csv", "folder", "a.csv --order 0", "a.csv --order x", "a.csv --p -1",
        "a.csv --band 5 2", "a.csv --band -1 2", "a.csv --band 1", "a.csv --band 100 200",
        "a.csv --input nope", "a.csv --output nope", "a.csv --map x", "a.csv --map 'a=b [N]'",
        "a.csv --rate 0", "a.csv --rate nan", "a.csv --rate 31", "a.csv --period 3",
        "a.csv --period 5000", "a.csv --unseen 2", "a.csv --unseen -1 --period 100",
        "a.csv --model nope", "a.csv --model bad.xml", "a.csv --model a.csv",
        "a.csv --test no.csv", "a.csv --json no/x.json", "a.csv --json folder",
        "a.csv --json a.csv", "a.csv --seed -1", "a.csv --seed x", "'no*.csv'", "a.csv --bogus",
        "a.csv a.csv", "a.csv --out bad.xml/deep", "text.xlsx", "text.mat", "bad.xml",
    ],
    "diagnose": [
        "", MODEL, f"{MODEL} --train a.csv", f"nope {BOTH}", f"{MODEL} --train a.csv --test no.csv",
        f"{MODEL} {BOTH} --tolerance 0", f"{MODEL} {BOTH} --tolerance x",
        f"{MODEL} {BOTH} --added-mass floor2=1",
        f"{MODEL} {BOTH} --added-mass a.csv:floor2=nan", f"{MODEL} {BOTH} --damping-tolerance 1000",
        f"{MODEL} --train a.csv --test 'no*.csv'", f"bad.xml {BOTH}", f"{MODEL} {BOTH} --json no/x",
        f"{MODEL} {BOTH} --out bad.xml/deep", f"{MODEL} {BOTH} --seed -1",
    ],
    "test hammer": [
        "--floor 0", "--floor 9", "--at nope", "--width 0", "--width -1", "--peak nan", "--rate 0",
        "--rate 1e9", "--duration 0", "--duration 1e9", "--noise -1", "--bits 0", "--repeat 0",
        "--double 0", "--cut-off 100", "--added-mass floor2", "--added-mass floor9=1",
        "--added-mass floor2=-5", "nope", "--out bad.xml/deep",
    ],
    "test shaker": [
        "--at nope", "--kind nope", "--band 5 2", "--level -1", "--level 0",
        "--at ground --kind earthquake", "--ground q", "--periods 0",
    ],
    "control": [
        "no.csv", "--rate 0", "--delay -1", "--torque-limit 0", "--settings no.json",
        "--excite nope", "--model two_storey",
    ],
    "tune": ["--max-swing 0", "--max-torque -1", "--model nope"],
    "convert": [
        "a.csv", "a.csv x.foo", "a.csv x", "a.csv x.csv --resample 0", "a.csv x.csv --resample -3",
        "a.csv x.csv --start 100", "a.csv x.csv --start 5 --stop 4", "a.csv x.csv --start nan",
        "a.csv folder", "a.csv x.csv --resample 1e12", "no.csv y.csv", "a.csv x.xlsx",
        "a.csv x.csv --json no/x",
    ],
    "view": ["", "no.rrd", "a.csv", "folder"],
    "fetch": ["nope", "silverbox --from nope", "silverbox --out bad.xml/deep"],
    "inspect": ["", "nope", "bad.xml", "a.csv --model nope", "folder", "a.csv --json a.csv"],
    "concealed": ["--cases -1", "--table foo", "--table foo=3", "--table pairs=x"],
    "rehearse": [
        "", MODEL, f"{MODEL} --plan no.toml", f"{MODEL} --plan bad.xml", f"{MODEL} --plan folder",
        f"{MODEL} --plan empty.csv", "nope --plan empty.csv", f"{MODEL} --plan a.csv --verify -1",
        f"{MODEL} --plan a.csv --json no/x", f"{MODEL} --plan a.csv --out bad.xml/deep",
    ],
    "paper": ["--json no/x", "--out bad.xml/deep"],
    "demo": ["--seed -3", "--out bad.xml/deep"],
}  # fmt: skip
CALLS = [f"{command} {words}".strip() for command, each in WRONG.items() for words in each]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("bad")
    x = [0.0, 1.0, 0.5, -0.25] * 16
    for name, last in (("a", 0.0), ("b", 1.0)):
        columns = {"force_floor1": x, "acc_floor1": [*x[1:], last], "acc_floor2": [last, *x[1:]]}
        write_recording(Recording.build(32.0, columns), path / f"{name}.csv")
    (path / "empty.csv").touch()
    (path / "bad.xml").write_text("<mujoco>")
    for name in ("text.xlsx", "text.mat"):
        (path / name).write_bytes((path / "a.csv").read_bytes())
    (path / "folder").mkdir()
    return path


def test_there_are_more_than_a_hundred():
    assert len(set(CALLS)) == len(CALLS) > 100


@pytest.mark.parametrize("call", CALLS)
def test_it_is_one_line_and_nothing_is_written(folder, monkeypatch, capsys, call):
    monkeypatch.chdir(folder)
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}
    with pytest.raises(SystemExit) as stop:
        main(shlex.split(call))
    error = capsys.readouterr().err
    assert stop.value.code == 2, error
    assert error.startswith("twin: ")
    assert error.count("\n") == 1
    assert error.strip().isprintable()
    assert {p: p.stat().st_mtime_ns for p in folder.rglob("*") if p.is_file()} == before
