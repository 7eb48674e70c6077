"""A hypothesis beside recordings that were made under other loads."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.p_delta import PDelta


def frequencies(A):
    return np.sort(np.abs(np.linalg.eigvals(A).imag))[::2] / (2 * np.pi)


def test_the_weight_of_a_bolted_mass_leans_on_what_is_below_it():
    plain, heavy = recorded(lumped(), 1), recorded(lumped(Mass("floor2", 0.5)), 2)
    added = {heavy.source: {"floor2": 0.5}}
    problem = prepare(lumped(), [plain, heavy], [recorded(lumped(), 3)], added_mass=added).train
    leaning = PDelta("storey1", 1.2, 0.15)
    h = replace(Hypothesis(problem), mechanisms=(leaning,), priors=({"factor": (1.2, 0.1)},))
    systems = h.assemble(np.zeros(len(h.unknowns))).systems
    for system, masses in zip(systems, ((), (Mass("floor2", 0.5),)), strict=True):
        twin = lumped(*masses, leaning).linear(["force_floor2"], ["acc_floor2"])
        expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(twin.M, twin.K)).real) / (2 * np.pi)
        assert frequencies(system.A[:4, :4]) == pytest.approx(np.sort(expected), rel=1e-3)
    first = problem.recordings[0]
    assert not first.added_mass


def test_no_more_damping_can_be_missing_than_there_is():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    row = problem.model.port("storey2")
    most = 1 / float(row @ np.linalg.solve(problem.model.R, row))
    for share, there in ((0.99, True), (1.01, False)):
        less = Damping("storey2", -share * most)
        priors = ({"change": (less.change, 1.0)},)
        h = replace(Hypothesis(problem), mechanisms=(less,), priors=priors)
        if there:
            assert h.assemble(np.zeros(len(h.unknowns)))
        else:
            with pytest.raises(ValueError, match="less damping than none"):
                h.assemble(np.zeros(len(h.unknowns)))
