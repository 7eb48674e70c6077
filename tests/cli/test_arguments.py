"""The command line's outside: several files an option, versions, help, what is replaced."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from rich.table import Table

from twin.cli import main
from twin.cli.arguments import expanded
from twin.cli.common import Terminal
from twin.errors import TwinError
from twin.files import check_folder
from twin.formats import write_recording
from twin.recording import Recording


def called(*arguments):
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("diagnose m --train a b --test c d", "diagnose m --train a --train b --test c --test d"),
        ("diagnose m --train a --train b --test c", "diagnose m --train a --train b --test c"),
        ("diagnose --train a b --test c m", "diagnose --train a --train b --test c m"),
        ("diagnose --train a --test c d m --out o", "diagnose --train a --test c d m --out o"),
        (
            "diagnose m --out o --train a b --test c",
            "diagnose m --out o --train a --train b --test c",
        ),
        (
            "diagnose --out o --train a b --test c m",
            "diagnose --out o --train a --train b --test c m",
        ),
        (
            "diagnose m --train a b --seed 3 --test c",
            "diagnose m --train a --train b --seed 3 --test c",
        ),
        ("identify a b --test c d --out o", "identify a b --test c --test d --out o"),
        ("identify --test c a b", "identify --test c a b"),
        ("identify a --test", "identify a --test"),
        ("view a --time 3", "view a --time 3"),
    ],
)  # fmt: skip
def test_an_option_of_files_takes_what_a_glob_gives(given, meant):
    if "c d m" in given:
        meant = meant.replace("c d", "c --test d")
    assert expanded(given.split()) == meant.split()


def test_a_pattern_that_the_shell_has_left_is_spelt_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("b.csv", "a.csv"):
        (tmp_path / name).touch()
    assert expanded(["identify", "*.csv"]) == ["identify", "a.csv", "b.csv"]
    assert expanded(["diagnose", "m", "--train", "*.csv"])[2:] == [
        *("--train", "a.csv", "--train", "b.csv")
    ]
    with pytest.raises(TwinError, match=r"none/\*\.csv: no file matches this pattern"):
        expanded(["identify", "none/*.csv"])
    assert expanded(["identify", "a.csv", "--map", "F=a [N]"])[-1] == "F=a [N]"


def test_a_diagnosis_reads_every_file_of_a_glob(tmp_path, capsys):
    for name in "abc":
        (tmp_path / f"{name}.csv").write_text("time [s],force_floor1 [N]\n0,1\n1,x\n")
    files = [tmp_path / f"{name}.csv" for name in "abc"]
    assert called("diagnose", "two_storey_lumped", "--train", *files[:2], "--test", files[2]) == 2
    assert "a.csv: row 3" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--version"], ["-h"], ["identify", "-h"]])
def test_version_and_help_have_short_names(arguments, capsys):
    assert called(*arguments) == 0
    assert ("twin 0." if arguments == ["--version"] else "Usage: twin") in capsys.readouterr().out


def test_the_package_runs_as_a_module_and_completes():
    done = subprocess.run(
        [sys.executable, "-m", "twin", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("twin 0.")
    asked = {"_TWIN_COMPLETE": "complete_bash", "COMP_WORDS": "twin ident", "COMP_CWORD": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "twin"], capture_output=True, text=True, check=False,
        env={**os.environ, **asked},
    )  # fmt: skip
    assert done.stdout.split() == ["identify"]


@pytest.mark.parametrize("after_s", [0.15, 0.4, 1.5])
def test_an_interruption_is_one_line_from_the_first_moment(tmp_path, after_s):
    arguments = [sys.executable, "-m", "twin", "test", "hammer", "--repeat", "50"]
    process = subprocess.Popen(
        arguments, cwd=tmp_path, stderr=subprocess.PIPE, stdout=-3, text=True
    )
    time.sleep(after_s)
    process.send_signal(signal.SIGINT)
    error = process.communicate(timeout=30)[1]
    if "twin" in error:  # else Python itself was still starting
        assert error == "twin: interrupted\n"
        assert process.returncode in (130, -signal.SIGINT)
    assert not list(tmp_path.rglob(".part-*"))


def test_an_interruption_inside_a_module_that_loads_is_no_other_error():
    code = (
        "import os, signal, sys; sys.modules['twin.cli'] = fake = type(sys)('fake')\n"
        "def run():\n"
        "    try: os.kill(os.getpid(), signal.SIGINT)\n"
        "    except KeyboardInterrupt: raise ImportError('initialization failed')\n"
        "fake.main = run; from twin.__main__ import main; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "twin: interrupted\n")


def test_an_interruption_inside_a_destructor_is_not_lost():
    code = (
        "import os, signal, sys, time; sys.modules['twin.cli'] = fake = type(sys)('fake')\n"
        "class Thing:\n"
        "    def __del__(self): os.kill(os.getpid(), signal.SIGINT); [0 for _ in range(9)]\n"
        "def run():\n"
        "    thing = Thing(); del thing; time.sleep(5); print('went on')\n"
        "fake.main = run; from twin.__main__ import main; main()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "twin: interrupted\n")


@pytest.mark.parametrize(
    "words", ["convert r.csv r.npz --json ./r.csv", "inspect r.csv --json r.csv"]
)
def test_json_is_never_written_over_an_input(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    source = write_recording(
        Recording.build(8.0, {"acc_floor1": [0.0, 1.0, 2.0]}), tmp_path / "r.csv"
    )
    before = source.read_bytes()
    assert called(*words.split()) == 2
    assert "this is an input of the command" in capsys.readouterr().err
    assert source.read_bytes() == before


def test_what_is_written_over_is_said(tmp_path, capsys):
    source = write_recording(
        Recording.build(8.0, {"acc_floor1": [0.0, 1.0, 2.0]}), tmp_path / "r.csv"
    )
    target = tmp_path / "r.npz"
    assert called("convert", source, target) == 0
    assert "replaced" not in capsys.readouterr().err
    code = "import sys; from twin.cli import main; main(sys.argv[1:])"
    done = subprocess.run(
        [sys.executable, "-c", code, "convert", source, target],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stderr == f"twin: replaced {target}\n"


def test_a_folder_that_cannot_be_written_is_refused_before_the_work(tmp_path, capsys, monkeypatch):
    (tmp_path / "file").touch()
    assert called("identify", tmp_path / "no.csv", "--out", tmp_path / "file" / "deep") == 2
    assert "cannot make this folder" in capsys.readouterr().err

    def refuse(**_):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    with pytest.raises(TwinError, match=r"cannot write there \(Read-only file system"):
        check_folder(tmp_path / "new" / "deep")
    assert not (tmp_path / "new").exists()


def test_no_table_loses_a_digit_in_a_narrow_terminal(capsys):
    table = Table()
    for name in ("quantity", "identified", "std"):
        table.add_column(name, no_wrap=True)
    table.add_row("frequency", "6.71523761", "0.00000043")
    Terminal(width=24).print(table)
    shown = capsys.readouterr().out
    assert "6.71523761" in shown
    assert "0.00000043" in shown
    assert "…" not in shown


def test_json_on_standard_output_stays_json(tmp_path, capsys):
    source = write_recording(
        Recording.build(8.0, {"acc_floor1": [0.0, 1.0, 2.0]}), tmp_path / "r.csv"
    )
    for _ in range(2):
        assert called("convert", source, tmp_path / "x.npz", "--json", "-") == 0
        assert json.loads(capsys.readouterr().out)["samples"] == 3
