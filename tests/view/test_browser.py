"""Every report in a real browser: it draws, zooms, links, and says nothing on the console."""

from dataclasses import replace

import numpy as np
import pytest
from browser import chromium, opened, printed
from control_example import control_page
from diagnosis_example import SLIP, consistent, diagnosis

from twin.identification.stabilisation import StablePole
from twin.provenance import provenance
from twin.view.page.diagnosis import report
from twin.view.page.identification import page
from twin.view.page.render import render

A4_PT, MARGIN_PT, PT_PER_PX, SHRUNK = 595.0, 14 / 25.4 * 72, 0.75, 0.8
"""Width of the narrower paper, and of the style sheet its margin and the zoom of plots."""


@pytest.fixture(scope="module")
def pages(identification):
    chromium()
    return {
        "diagnosis": report(diagnosis(SLIP)),
        "consistent": report(consistent()),
        "identification": render(page(identification, None, provenance(), {})),
        "control": render(control_page()),
    }


@pytest.mark.parametrize("width", [1200, 400])
@pytest.mark.parametrize("name", ["diagnosis", "consistent", "identification", "control"])
def test_a_browser_draws_and_zooms_without_an_error(pages, name, width, tmp_path):
    seen = opened(pages[name], tmp_path, width)
    assert seen["outside"] == []
    assert seen["covered"] == []
    assert seen["width"] <= width
    assert seen["errors"] == []
    assert seen["console"] == []
    assert seen["drawn"] == seen["plots"] > 0
    (low, high), (a, b) = seen["before"], seen["after"]
    assert a == pytest.approx(low + 0.3 * (high - low), abs=0.02 * (high - low))
    assert b == pytest.approx(low + 0.6 * (high - low), abs=0.02 * (high - low))
    assert seen["pressed"] == "false"


PAGES = {"diagnosis": 10, "consistent": 5, "identification": 4, "control": 4}
"""What the reports of the examples need at most in print, folded sections included."""


@pytest.mark.parametrize("name", PAGES)
def test_a_report_in_print_is_whole_and_wastes_no_pages(pages, name, tmp_path):
    count, (width, _) = printed(pages[name], tmp_path)
    assert 1 < count <= PAGES[name]
    print("COUNT", name, count, max(opened(pages[name], tmp_path)["printed"]))
    seen = opened(pages[name], tmp_path)
    shown_pt = SHRUNK * PT_PER_PX * max(seen["printed"])
    assert shown_pt <= min(width, A4_PT) - 2 * MARGIN_PT
    assert seen["console"] == []


def test_plots_of_one_kind_zoom_together(pages, tmp_path):
    seen = opened(pages["control"], tmp_path)
    assert seen["linked"]
    assert all(other == pytest.approx(seen["after"]) for other in seen["linked"])


def test_clicked_poles_become_a_command(identification, tmp_path):
    made = provenance(["identify", "hit.csv", "--poles", "3,4"])
    steady = frozenset(("frequency", "damping", "shape"))
    column = [StablePole(n, 12.3 * (-0.01 + 1j), np.ones(2), True, steady) for n in (4, 6, 8)]
    drawn = replace(identification, diagram=tuple(column))
    seen = opened(render(page(drawn, None, made, {})), tmp_path)
    assert seen["picked"] == "twin identify hit.csv --poles 2.5,7.25"
    assert seen["lines"] == len(identification.modal.natural_freq) + 2
    assert seen["console"] == []
