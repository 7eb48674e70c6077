"""Rules of the house that no reviewer should have to check."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
LONGEST = 300


def test_rooms_import_only_from_the_rooms_below_them():
    command = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [command, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_no_file_is_longer_than_300_lines():
    long = {
        str(path.relative_to(ROOT)): lines
        for folder in ("twin", "experiments", "benchmarks", "tests")
        for path in (ROOT / folder).rglob("*.py")
        if (lines := len(path.read_text().splitlines())) > LONGEST
    }
    assert not long


def test_every_experiment_and_benchmark_finds_what_it_imports_of_ours():
    """A command that the README or a page names must run after a module has moved."""
    code = (
        "import importlib, sys\n"
        "sys.path[:0] = ['.', 'benchmarks']\n"
        "for name in sys.argv[1:]:\n"
        "    try:\n"
        "        importlib.import_module(name)\n"
        "    except ModuleNotFoundError as error:\n"
        "        if error.name.split('.')[0] in ('twin', 'experiments', *sys.argv[1:]):\n"
        "            raise\n"
    )
    names = [f"experiments.{path.stem}" for path in (ROOT / "experiments").glob("*.py")]
    names += [path.stem for path in (ROOT / "benchmarks").glob("*.py")]
    done = subprocess.run(
        [sys.executable, "-c", code, *sorted(names)],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_importing_twin_loads_no_plotting_viewer_or_unit_library():
    code = (
        "import sys, twin; "
        "print([m for m in ('matplotlib', 'rerun', 'jinja2', 'pint') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_product_never_names_the_shared_recordings():
    guilty = [str(path) for path in (ROOT / "twin").rglob("*.py") if "shared/" in path.read_text()]
    assert not guilty


def test_no_pickle_is_ever_loaded():
    guilty = [
        str(path)
        for path in (ROOT / "twin").rglob("*.py")
        if "allow_pickle=True" in path.read_text() or "import pickle" in path.read_text()
    ]
    assert not guilty


def test_no_two_test_files_have_the_same_name():
    names = [path.name for path in (ROOT / "tests").rglob("test_*.py")]
    assert sorted(names) == sorted(set(names))
