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


@pytest.mark.parametrize(
    ("verdicts", "poor"),
    [
        (("missing_physics",), True),
        (("parameter",), True),
        (("parameter", "parameter"), False),
        (("parameter", "measurement", "parameter"), False),
        (("parameter", "parameter", "missing_physics"), True),
        (("measurement", "measurement"), False),
    ],
)
def test_several_parameters_are_a_calibration_and_no_poor_explanation(monkeypatch, verdicts, poor):
    found = [SimpleNamespace(verdict=verdict) for verdict in verdicts]
    best = SimpleNamespace(hypothesis=SimpleNamespace(found=found), slack=1e-3)
    monkeypatch.setattr(laws, "foresees_off", lambda bench, fit: 0.5)
    monkeypatch.setattr(laws, "noise_floors", lambda *_, seed: (0.0, 0.01))
    assert laws.is_poor(None, None, best) is poor
