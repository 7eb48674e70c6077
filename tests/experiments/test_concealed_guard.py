"""What a diagnosis may not do, tried: read the truth, list it, start another process."""

import io
import json
import multiprocessing
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from experiments.concealed.guard import SealedError, guarded
from experiments.concealed.steps import Blind, diagnose_blind

WAYS = {
    "open": lambda f: f.open(),
    "read_text": lambda f: f.read_text(),
    "bytes": lambda f: io.FileIO(os.fsencode(f)),
    "os.open": lambda f: os.open(f, os.O_RDONLY),
    "numpy.load": lambda f: np.load(f),
    "numpy.fromfile": lambda f: np.fromfile(f, np.uint8),
    "memmap": lambda f: np.memmap(f),
    "listdir": lambda f: os.listdir(f.parent),
    "scandir": lambda f: list(os.scandir(f.parent)),
    "glob": lambda f: list(f.parent.glob("*")),
    "copy": lambda f: shutil.copy(f, f.parents[1] / "copy"),
    "rename": lambda f: f.rename(f.parents[1] / "moved"),
    "rename of the folder above": lambda f: f.parents[1].rename(f.parents[2] / "moved"),
    "hard link": lambda f: os.link(f, f.parents[1] / "linked"),
    "symlink": lambda f: (f.parents[1] / "before" / f.name).read_text(),
    "new symlink": lambda f: os.symlink(f, f.parents[1] / "new"),
    "relative": lambda f: Path(os.path.relpath(f)).read_text(),
    "relative to a folder's descriptor": lambda f: os.open(
        "sealed/truth.json", os.O_RDONLY, dir_fd=os.open(f.parents[1], os.O_RDONLY)
    ),
    "dots": lambda f: (f.parents[1] / "recordings" / ".." / "sealed" / f.name).read_text(),
    "through /proc": lambda f: Path(f"/proc/self/root{f}").read_text(),
    "cat": lambda f: subprocess.run(["cat", f], capture_output=True, check=True),
    "os.system": lambda f: os.system(f"cat {f}"),
    "fork": lambda f: os.fork(),
    "spawn": lambda f: multiprocessing.get_context("spawn").Process(target=print).start(),
    "thread": lambda f: ThreadPoolExecutor(1).submit(f.read_text).result(),
    "command line": lambda f: Path("/proc/self/cmdline").read_text(),
}  # fmt: skip


@pytest.fixture
def sealed(tmp_path):
    """A campaign's folder with one truth, a link to it, and a recording; the truth's path."""
    truth = tmp_path / "sealed" / "truth.json"
    for name in ("sealed", "recordings/case_0001", "diagnoses"):
        (tmp_path / name).mkdir(parents=True)
    truth.write_text("bumper")
    (tmp_path / "before").symlink_to(tmp_path / "sealed")
    for name in ("test_1", "train_1", "train_2"):
        (tmp_path / "recordings" / "case_0001" / f"{name}.csv").write_text(f"{name}\n")
    return truth


@pytest.mark.parametrize("way", WAYS)
def test_the_truth_is_out_of_reach(sealed, way):
    with guarded(sealed.parent) as attempts, pytest.raises(SealedError, match="while diagnosing"):
        WAYS[way](sealed)
    assert attempts
    assert sealed.read_text() == "bumper"  # the guard ends with the block


def test_what_is_not_sealed_can_be_read_and_written(sealed, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["twin", "--seed", "31"])
    folder = sealed.parents[1] / "recordings" / "case_0001"
    with guarded(sealed.parent) as attempts:
        assert sorted(os.listdir(folder)) == ["test_1.csv", "train_1.csv", "train_2.csv"]
        assert (folder / "test_1.csv").read_text() == "test_1\n"
        (sealed.parents[1] / "note").write_text("x")
        assert sys.argv == ["twin"]
    assert not attempts
    assert sys.argv == ["twin", "--seed", "31"]


def honest(model, train, test, out, seed):
    return {"verdict": "consistent", "read": [p.read_text().strip() for p in (*train, *test)]}


def prying(model, train, test, out, seed):
    """Look for a truth everywhere, and say nothing of the refusals."""
    try:
        Path(os.environ["SEALED_FOR_A_TEST"]).read_text()
    except Exception:
        return {"verdict": "consistent"}
    return {"verdict": "missing_physics"}


def blind(sealed, diagnose):
    out = sealed.parents[1]
    kept = out / "diagnoses" / "case_0001.json"
    task = Blind(
        out / "recordings" / "case_0001", "two_storey_lumped", kept, (sealed.parent,),
        made_with={"twin": "1"}, diagnose=diagnose,
    )  # fmt: skip
    assert diagnose_blind(task) == {"done": True}
    return json.loads(kept.read_text())


def test_an_honest_diagnosis_gets_all_recordings_of_its_case(sealed):
    found = blind(sealed, honest)
    assert found["read"] == ["train_1", "train_2", "test_1"]
    assert found["made_with"] == {"twin": "1"}


def test_a_diagnosis_that_pries_is_an_error_even_if_it_hides_it(sealed, monkeypatch):
    monkeypatch.setenv("SEALED_FOR_A_TEST", str(sealed))
    assert "refused while diagnosing: open of" in blind(sealed, prying)["error"]
    results = sealed.parents[1] / "recordings" / "case_0001" / "train_1.csv"
    monkeypatch.setenv("SEALED_FOR_A_TEST", str(results))  # it has its copies: no way around
    assert "refused while diagnosing" in blind(sealed, prying)["error"]


def test_the_task_holds_neither_seed_nor_truth():
    names = {field.name for field in fields(Blind)}
    assert names == {
        "recordings", "model", "kept", "refused", "until", "made_with", "diagnose",
    }  # fmt: skip
