import io
import json
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout

import numpy as np
import pytest
from scipy import io as matlab

from twin.cli import main


def run(*arguments):
    """Run ``twin fetch``; return exit code, standard output and standard error."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as stopped:
        main(["fetch", *map(str, arguments)])
    return stopped.value.code, out.getvalue(), err.getvalue()


@pytest.fixture
def copy(tmp_path):
    for kind in ("multisine", "sinesweep"):
        for letter in "uy":
            name = f"{letter}val_{kind}"
            matlab.savemat(tmp_path / f"{name}.mat", {name: np.arange(9.0)})
    return tmp_path


def test_the_list_names_every_set_with_its_page():
    code, out, _ = run("--list")
    assert code == 0
    for name in ("silverbox", "f16", "lanl_bumper", "bouc_wen"):
        assert name in out
    assert out.count("https://") == 4


def test_a_local_copy_is_converted_and_the_next_command_is_said(copy, tmp_path):
    code, out, err = run("bouc_wen", "--from", copy, "--out", tmp_path / "out")
    assert (code, err) == (0, "")
    assert out.startswith("2 recordings in ")
    assert f"--official {tmp_path / 'out'}" in out


def test_json_on_standard_output_lists_the_files(copy, tmp_path):
    code, out, _ = run("bouc_wen", "--from", copy, "--out", tmp_path / "out", "--json", "-")
    assert code == 0
    files = json.loads(out)["files"]
    assert [f.rsplit("/", 1)[1] for f in files] == ["bouc_wen_test_multisine.csv",
                                                    "bouc_wen_test_sweep.csv"]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["moon"], "twin: no benchmark 'moon'; there are silverbox, f16, lanl_bumper, bouc_wen\n"),
        ([], "twin: fetch needs a name; twin fetch --list says which there are\n"),
        (["f16", "--from", "nowhere"], "twin: f16: nowhere does not exist\n"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_two(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(*arguments) == (2, "", message)
    assert list(tmp_path.iterdir()) == []


def test_importing_the_command_line_loads_no_downloader():
    code = "import sys, twin.cli as c; c.build(); print('pooch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
