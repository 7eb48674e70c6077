"""The twin's own parameters as findings: one that is far off beside what was found."""

import pytest
from diagnosis_support import TWO, exact_trial

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.parameters import promoted, straightens
from twin.diagnosis.refining import refined

ALL = mechanisms.vocabulary()
SOFTER = ALL["stiffness"]("storey1", -60.0)
DASHPOT = ALL["damping"]("storey2", 0.7)


def beside_softer(*concealed):
    """Trials of a frame with a softer storey and more, and the fit in which that one is found."""
    trials = [exact_trial((SOFTER, *concealed), seed=s, noise=1e-3) for s in (1, 2)]
    bench = Bench(TWO, tuple(trials), "linear")
    return bench, refined(bench, [base_hypothesis(TWO).including(SOFTER)], 1e-3)


@pytest.mark.parametrize("needed", [0.0, 100.0])
def test_a_damping_far_beyond_its_tolerance_is_a_finding_beside_another(needed):
    bench, current = beside_softer(DASHPOT)
    found = promoted(bench, current, needed)
    assert found.hypothesis.labels == (("stiffness", "storey1"), ("damping", "storey2"))
    assert found.hypothesis.found[1].change == pytest.approx(0.7, rel=0.03)
    without = refined(bench, [base_hypothesis(TWO, damping_tolerance=1e-9).including(SOFTER)], 1e-3)
    assert without.bic > found.bic + needed


def test_a_dashpot_of_the_lowest_storey_takes_that_of_its_floor_along():
    dashpot = ALL["damping"]("storey1", 0.9)
    trials = [exact_trial((ALL["stiffness"]("storey2", -60.0), dashpot), seed=s) for s in (1, 2)]
    bench = Bench(TWO, tuple(trials), "linear")
    upper = base_hypothesis(TWO).including(ALL["stiffness"]("storey2", -60.0))
    current = refined(bench, [upper], 1e-3)
    taken = {(m.name, m.place): m.values["change"] for m in current.hypothesis.base}
    assert taken["damping", "floor1"] > 0.3  # the two are one, and calibration shares it out
    found = promoted(bench, current, needed=1000.0)
    assert found.hypothesis.labels[-1] == ("damping", "storey1")
    assert found.hypothesis.found[-1].change == pytest.approx(0.9, rel=0.02)


def test_what_is_hardly_missed_is_no_finding():
    bench, current = beside_softer(DASHPOT)
    assert promoted(bench, current, needed=1e9) is None


def test_within_its_tolerance_nothing_is_a_finding():
    bench, current = beside_softer()
    assert promoted(bench, current) is None
    assert promoted(bench, refined(bench, [base_hypothesis(TWO)], 1e-3)) is None


def test_an_explanation_that_leaves_a_parameter_bent_does_not_explain_it():
    bench, current = beside_softer(DASHPOT)
    own = promoted(bench, current)
    assert not straightens(current, own)
    assert straightens(own, own)
    assert straightens(beside_softer()[1], own)
