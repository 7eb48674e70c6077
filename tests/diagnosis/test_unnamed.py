"""A law without a name: what it must bring."""

from types import SimpleNamespace

import pytest

from twin.diagnosis import unnamed as laws
from twin.diagnosis.stage import DECISIVE


@pytest.mark.parametrize(("foresees", "needed"), [(0.4, DECISIVE), (0.6, 2000.0)])
def test_what_foresees_far_better_needs_no_more_evidence_than_any(monkeypatch, foresees, needed):
    nothing, best = SimpleNamespace(bic=0.0), SimpleNamespace(bic=-1e5)
    monkeypatch.setattr(laws, "foresees_off", lambda bench, fit: {-1e5: 1.0}[fit.bic])
    assert laws._needed(None, nothing, best, foresees) == needed


def test_a_flexible_law_needs_a_least_gain(monkeypatch):
    nothing, best = SimpleNamespace(bic=0.0), SimpleNamespace(bic=-1e3)
    monkeypatch.setattr(laws, "foresees_off", lambda bench, fit: 1.0)
    assert laws._needed(None, nothing, best, 1.0) == laws.UNNAMED
