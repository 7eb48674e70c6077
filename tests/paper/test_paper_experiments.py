"""The scripts behind the ledger and the counterparts of Figs. 4-7."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXPERIMENTS = Path(__file__).parents[2] / "experiments"


def script(name, *arguments, cwd):
    if not (EXPERIMENTS / name).exists():
        pytest.skip(f"experiments/{name} is not beside the tests")
    done = subprocess.run(
        [sys.executable, str(EXPERIMENTS / name), *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, "COLUMNS": "100", "PYTHONPATH": str(EXPERIMENTS.parent)},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_ledger_script_prints_the_ledger(tmp_path):
    assert "25 contradictions." in script("paper_ledger.py", cwd=tmp_path)


def test_the_figures_script_draws_four_figures_and_four_singular_values_stand_out(tmp_path):
    printed = script("paper_figures.py", str(tmp_path / "figures"), cwd=tmp_path)
    pictures = sorted((tmp_path / "figures").iterdir())
    assert [picture.name[:10] for picture in pictures] == [f"paper_fig{n}" for n in (4, 5, 6, 7)]
    assert all(picture.read_bytes()[:4] == b"\x89PNG" for picture in pictures)
    (values,) = [line for line in printed.splitlines() if line.startswith("singular values")]
    sigma = [float(value) for value in values.split()[2:]]
    assert sigma[3] > 2 * sigma[4]
    assert sigma[4] < 1.1 * sigma[5]
