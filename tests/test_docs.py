"""What the documentation says runs: every block of a page, every notebook, the catalogue."""

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from twin.cli import main

ROOT = Path(__file__).parents[1]
PAGES = ["index.md", "add_mechanism.md", *(
    f"howto/{name}.md"
    for name in ("virtual_frame", "identify", "control", "diagnose", "rehearse", "own_structure")
)]  # fmt: skip
NOTEBOOKS = ["1_test_and_identify", "2_from_file_to_physics", "3_own_structure"]
BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```", re.M | re.S)


def executed(code, names):
    exec(compile(code, "<docs>", "exec"), names)


@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # a dataclass looks its module up
    names = {"__name__": "docs_page"}
    monkeypatch.setitem(sys.modules, "docs_page", type(sys)("docs_page"))
    blocks = BLOCK.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))
    assert blocks
    for kind, text in blocks:
        if kind == "python":
            executed(text, names)
            continue
        for line in text.strip().splitlines():
            program, *arguments = shlex.split(line)
            assert program == "twin"
            with pytest.raises(SystemExit) as stop:
                main(arguments)
            assert stop.value.code in (0, None), line


def test_the_readmes_python_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = BLOCK.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    python = [text for kind, text in blocks if kind == "python"]
    assert len([line for line in python[0].splitlines() if line.strip()]) == 5
    for text in python:
        executed(text, {"__name__": "readme"})
    assert (tmp_path / "report.html").stat().st_size


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_every_notebook_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    notebook = json.loads((ROOT / "notebooks" / f"{name}.ipynb").read_text(encoding="utf-8"))
    names = {"__name__": "notebook"}
    cells = [c for c in notebook["cells"] if c["cell_type"] == "code"]
    assert sum(len(c["source"]) for c in cells) <= 20
    for cell in cells:
        executed("".join(cell["source"]), names)


def test_the_catalogue_is_that_of_the_files(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import catalogue

    written = (ROOT / "docs" / "mechanisms.md").read_text(encoding="utf-8")
    assert catalogue.page() == written, "run python docs/catalogue.py"
    pictures = re.findall(r"\(mechanisms/(\w+)\.png\)", written)
    assert all((ROOT / "docs" / "mechanisms" / f"{name}.png").stat().st_size for name in pictures)


def test_the_site_builds_without_a_warning(tmp_path):
    for name in ("mkdocs", "material", "mkdocstrings"):
        pytest.importorskip(name, reason="the site needs pip install 'frame-twin[docs]'")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)],
        cwd=ROOT, capture_output=True, text=True, check=False,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    reference = (tmp_path / "reference" / "index.html").read_text(encoding="utf-8")
    assert "hammer_test" in reference
    assert "<blockquote>" not in reference  # an example that is no code


def test_every_page_of_the_site_is_there_and_every_link_leads_somewhere():
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = re.findall(r"- (\S+\.md)$", site, re.M)
    assert len(pages) >= 10
    for page in pages:
        path = ROOT / "docs" / page
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", path.read_text(encoding="utf-8")):
            assert (path.parent / target).exists(), f"{page}: {target}"
    assert os.path.exists(ROOT / "CITATION.cff")
