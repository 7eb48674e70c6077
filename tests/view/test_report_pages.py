"""Reports as data: what stands in them and in which order, without a browser."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pytest
from control_example import control_page
from diagnosis_example import CUBIC, SLIP, consistent, diagnosis

from twin.model import Twin
from twin.provenance import provenance, sha256
from twin.view.colours import LOCATED, REJECTED
from twin.view.diagnosis_words import quantity, verdict_sentence
from twin.view.page import diagnosis as diagnosis_page
from twin.view.page import identification as identification_page
from twin.view.page.blocks import Plot
from twin.view.page.diagnosis_plots import force, where
from twin.view.page.plots import numbers, thinned
from twin.view.page.render import render


def plots(page):
    return [b for s in page.sections for b in s.blocks if isinstance(b, Plot)]


@pytest.fixture(scope="module")
def pages(identification):
    made = provenance(["diagnose", "a b.csv"], [__file__], 3)
    truth = Twin.load("two_storey_lumped")
    return {
        "cubic": diagnosis_page.page(diagnosis(CUBIC), made),
        "slip": diagnosis_page.page(diagnosis(SLIP), made),
        "consistent": diagnosis_page.page(consistent(), made),
        "identification": identification_page.page(identification, truth, made, {"b.csv": 0.02}),
        "control": control_page(),
    }


@pytest.mark.parametrize("name", ["cubic", "slip", "consistent", "identification", "control"])
def test_every_plot_is_one_that_plotly_knows(pages, name):
    drawn = plots(pages[name])
    assert drawn
    for plot in drawn:
        go.Figure(json.loads(json.dumps(plot.figure, allow_nan=False)))


def test_a_diagnosis_answers_in_the_order_in_which_one_asks(pages):
    titles = [s.title for s in pages["cubic"].sections if not s.folded]
    assert titles[:6] == [
        "What was left out",
        "Before and after, on recordings it has not seen",
        "Where",
        "The missing force",
        "What else it could be",
        "What to test next",
    ]
    assert pages["cubic"].title == (
        "The twin lacks physics: cubic stiffness in storey 1 (93.0 %), "
        "which ties with bumper in storey 1 (7.0 %)."
    )


def test_a_rival_of_a_smaller_finding_is_not_said_to_tie_with_the_first():
    whole = diagnosis(CUBIC)
    first, other = whole.findings[0], whole.alternatives[0]
    both = replace(
        whole,
        findings=(replace(first, probability=0.97), replace(other, probability=0.36)),
        alternatives=(replace(other, probability=0.33),),
    )
    assert verdict_sentence(both) == (
        "The twin lacks physics: cubic stiffness in storey 1; besides, with less effect, "
        "bumper in storey 1 (36.0 %) or bumper in storey 1 (33.0 %)."
    )


def test_nothing_found_leaves_nothing_to_explain(pages):
    titles = [s.title for s in pages["consistent"].sections]
    assert "What was left out" not in titles
    assert "The missing force" not in titles
    assert "Nothing ties" in render(pages["consistent"])


def test_the_law_is_drawn_over_its_points_with_its_band(pages):
    force = next(s for s in pages["cubic"].sections if s.title == "The missing force")
    drawn = next(b for b in force.blocks if isinstance(b, Plot))
    names = [trace["name"] for trace in drawn.figure["data"]]
    assert names == ["missing force", "cubic stiffness", "cubic stiffness"]
    points, band, law = drawn.figure["data"]
    assert band["fill"] == "toself"
    x = law["x0"] + law["dx"] * np.arange(len(law["y"]))
    near = np.interp(points["x"], x, law["y"])
    missing = np.array(points["y"])
    assert np.std(missing - near) < 0.3 * np.std(missing)


def test_a_few_points_at_the_ends_of_a_recording_do_not_hide_the_others():
    whole = diagnosis(CUBIC)
    latent = np.array(whole.force[0].latent)
    latent[:2] = 1e3 * np.abs(latent).max()
    drawn, *_ = force(replace(whole.force[0], latent=latent), whole.findings[0])
    low, high = drawn.figure["layout"]["yaxis"]["range"]
    assert low < np.quantile(latent, 0.01) < np.quantile(latent, 0.99) < high
    assert high < 10 * np.abs(latent[2:]).max()


def test_what_rounds_to_nothing_has_no_sign():
    assert quantity(-0.0004, 0.23, "N s/m") == "0.00 ± 0.23 N s/m"
    assert quantity(-0.04, 0.023, "N") == "-0.040 ± 0.023 N"


def test_the_ranking_is_sorted_and_every_bar_has_its_words(pages):
    others = next(s for s in pages["cubic"].sections if s.title.startswith("What else"))
    bars = others.blocks[0].figure["data"][0]
    assert bars["x"] == sorted(bars["x"])
    assert bars["text"][0] == "cubic stiffness, storey 1: best, 93.0 %"
    assert len(bars["text"]) == 3


def test_the_located_place_is_lit_in_the_model(pages):
    where = next(s for s in pages["cubic"].sections if s.title == "Where")
    names = [trace["name"] for trace in where.blocks[0].figure["data"]]
    assert names[0] == "storey1: 100 %"
    assert "floor1" in names
    assert "sensor" in names


def test_the_place_of_the_best_explanation_gains_most_though_another_promised_more():
    cubic = diagnosis()
    found = replace(cubic.findings[0], gain=900.0)
    others = (
        replace(cubic.alternatives[0], gain=894.8),
        replace(cubic.alternatives[1], gain=88.0),
    )
    told = replace(cubic, findings=(found,), alternatives=others,
                   where={"storey2": 5000.0, "storey1": 1400.0})  # fmt: skip
    bars = where(told).figure["data"][0]
    assert bars["text"] == ["cubic stiffness, storey 1: 900", "coulomb friction, storey 2: 88"]
    assert bars["marker"]["color"] == [LOCATED, REJECTED]


def test_the_provenance_names_command_files_versions_and_seed(pages):
    html = render(pages["cubic"])
    assert "twin diagnose &#39;a b.csv&#39;" in html
    assert sha256(Path(__file__)) in html
    assert re.search(r"mujoco \d", html)
    assert re.search(r"20\d\d-\d\d-\d\d \d\d:\d\d UTC", html)
    assert "<dt>seed</dt><dd>3</dd>" in html


def test_the_date_can_be_set_for_the_same_file_twice(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    assert provenance().date == "1970-01-01 00:00 UTC"


def test_a_page_is_for_narrow_screens_and_fetches_nothing(pages):
    html = render(pages["identification"])
    assert 'content="width=device-width, initial-scale=1"' in html
    assert re.findall(r"""(?:src|href)\s*=\s*["']?(?!data:)([^"'\s>]{1,20})""", html) == []


def test_a_long_line_keeps_its_extremes():
    y = np.zeros(100_000)
    y[77_777], y[5] = 3.0, -2.0
    x, kept = thinned(np.arange(len(y)) / 100, y)
    assert len(x) <= 4000
    assert kept.max() == 3.0
    assert x[np.argmax(kept)] == 777.77
    assert kept.min() == -2.0


def test_what_is_not_finite_is_a_gap():
    assert numbers(np.array([1.0, np.nan, np.inf])) == [1.0, None, None]
