"""A law without a name: what it must bring."""

from types import SimpleNamespace

import pytest

from twin.diagnosis import unnamed as laws
from twin.diagnosis.stage import DECISIVE


@pytest.mark.parametrize(("foresees", "needed"), [(0.4, DECISIVE), (0.6, 2000.0)])
def test_what_foresees_far_better_needs_no_more_evidence_than_any(monkeypatch, foresees, needed):
    fits = {name: SimpleNamespace(name=name, bic=bic) for name, bic in
            (("nothing", 0.0), ("best", -1e5), ("unnamed", -2e5))}  # fmt: skip
    off = {"best": 1.0, "unnamed": foresees}
    monkeypatch.setattr(laws, "foresees_off", lambda bench, fit: off[fit.name])
    assert laws._needed(None, fits["nothing"], fits["best"], fits["unnamed"]) == needed


def test_a_flexible_law_needs_a_least_gain(monkeypatch):
    fits = [SimpleNamespace(bic=bic) for bic in (0.0, -1e3, -2e3)]
    monkeypatch.setattr(laws, "foresees_off", lambda bench, fit: 1.0)
    assert laws._needed(None, *fits) == laws.UNNAMED
