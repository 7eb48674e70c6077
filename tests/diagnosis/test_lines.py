"""What straight lines miss is taken from the structure that was fitted."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded, rng

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.lines import by_its_lines, with_its_lines
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, RandomShaking, run
from twin.mechanisms.damping import Damping
from twin.model import Twin

DASHPOT = Damping("hinge3", 0.01)


@pytest.fixture(scope="module")
def beam():
    """A beam with modes above the band, a dashpot at a hinge, and the hypothesis that has it."""
    shaking = Experiment(
        RandomShaking(0.03, (0.5, 70.0)),
        ("force_mid", "force_tip"),
        Analyser(192.0, 6.0, physics_hz=32 * 192.0),
        instruments=dict.fromkeys(("acc", "force"), Instrument(noise_fraction=0.005)),
    )
    true = Twin.load("cantilever").including(DASHPOT)
    train, test = run(shaking, true, 1), run(shaking, true, 2)
    problem = prepare(Twin.load("cantilever"), [train], [test], None, 0.1, None).train
    start = DASHPOT.with_values({"change": 0.7 * DASHPOT.change})
    blank = Hypothesis(problem)
    grown = added(blank, Candidate((start,), priors_of((DASHPOT,))), start)
    return grown, moved_to(grown, blank, np.zeros(len(blank.unknowns)), start)


def test_a_dashpot_is_found_as_strong_as_it_is_though_modes_above_the_band_feel_it(beam):
    h, z = beam
    assert h.problem.calmed
    before = fit(h, z)
    other, found = with_its_lines(h, before)
    (dashpot,) = other.at(found.z)
    assert dashpot.change == pytest.approx(DASHPOT.change, rel=0.02)
    assert found.log_evidence > before.log_evidence + 20
    assert abs(h.at(before.z)[0].change / DASHPOT.change - 1) > 0.04, "and it was not without"


def test_lines_are_those_of_the_values_that_are_asked_for(beam):
    h, z = beam
    there = by_its_lines(h, z)
    assert np.allclose(there.problem.fitted.M, h.problem.model.M)
    assert not np.allclose(there.problem.fitted.R, h.problem.model.R)
    row = h.problem.model.port("hinge3")
    change = h.at(z)[0].change * np.outer(row, row)
    assert np.allclose(there.problem.fitted.R - h.problem.base(z).R, change, atol=1e-9)


def test_a_structure_that_cannot_be_leaves_them_as_they_were(beam):
    h, z = beam
    assert by_its_lines(h, np.where(np.arange(len(z)) == _at(h), -1e3, z)) is h


def _at(h):
    return [u.name for u in h.unknowns].index("damping hinge3 change")


def test_without_modes_above_the_band_nothing_is_done():
    problem = prepare(
        lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)], None, 0.005, None
    ).train
    h = Hypothesis(problem)
    assert not problem.calmed
    found = fit(h, rng(1).normal(size=len(h.unknowns)) * 0)
    assert with_its_lines(h, found) == (h, found)
    assert replace(h).problem.fitted is None
