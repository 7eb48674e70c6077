"""The stiffness that a law takes over from the structure is the structure's, exactly."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.candidates import motions, scales_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.estimation.likelihood import evaluate
from twin.mechanisms.clearance import Clearance
from twin.mechanisms.hysteresis import Hysteresis


@pytest.fixture(scope="module")
def problem():
    own = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    # modal damping ratios go with the storey's own stiffness: here there is none
    return replace(own, model=replace(own.model, R=0 * own.model.R))


@pytest.mark.parametrize("law", [
    Clearance("storey2", 150.0, 1e-3, 150.0), Hysteresis("storey2", 150.0, 0.1, 2.0, 150.0),
])  # fmt: skip
def test_more_of_it_is_as_much_less_of_the_storey(problem, law):
    blank = Hypothesis(problem)
    moved = motions(problem, blank, np.zeros(len(blank.unknowns)))
    own = {}
    for name, parameter in law.parameters.items():
        value = law.values[name]
        own[name] = (np.log(value), 1.0) if parameter.scale == "log" else (value, 1.0)
    own["replaced"] = (1.0, 0.5)
    h = replace(blank, mechanisms=(law,), priors=(own,), scales=scales_of(problem, moved))
    names = [u.name for u in h.unknowns]
    share = names.index(f"{law.name} storey2 replaced")
    storey = names.index("stiffness storey2")
    z = np.zeros(len(names))
    before = evaluate(h, z, derivatives=False).log_likelihood
    z[share] = 30.0 / 150.0 / h.unknowns[share].deviation
    alone = evaluate(h, z, derivatives=False).log_likelihood
    k = h.unknowns[storey].value(0.0)
    z[storey] = np.log1p(30.0 / k) / h.unknowns[storey].deviation
    together = evaluate(h, z, derivatives=False).log_likelihood
    assert abs(alone - before) > 1.0
    assert together == pytest.approx(before, abs=1e-5)
