"""Steps of what is added to a fit beside those of a fit of everything."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.adjusted import Adjusted
from twin.diagnosis.beginning import added, moved_to, start_of
from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.linearised import Linearised
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.mechanisms.sensor_delay import SensorDelay
from twin.mechanisms.stiffness import Stiffness


@pytest.fixture(scope="module")
def fitted():
    train, test = (recorded(lumped(), seed, source=f"seed{seed}.csv") for seed in (1, 2))
    hypothesis = Hypothesis(prepare(lumped(), [train], [test], 0.01).train)
    found = fit(hypothesis, start_of(hypothesis))
    model = Linearised.of(hypothesis, evaluate(hypothesis, found.z, derivatives=False).runs)
    return hypothesis, found, model


def grown_by(fitted, starts):
    hypothesis, found, model = fitted
    grown = added(hypothesis, Candidate(starts, priors_of(starts)), starts[0])
    return model.beside(grown), moved_to(grown, hypothesis, found.z, starts[0])


@pytest.mark.parametrize("start", [1e-3, -5e-4])
def test_a_delay_comes_to_where_a_fit_of_everything_brings_it(fitted, start):
    _, found, model = fitted
    grown, z = grown_by(fitted, (SensorDelay("acc_floor1", start),))
    adjusted = Adjusted(model, found)
    value, moved = adjusted.steps(grown, z, 6)
    free = np.array([u.role != "noise" for u in grown.unknowns])
    whole = fit(grown, z, free=free)
    assert moved[free] == pytest.approx(whole.z[free], abs=0.02)
    assert value - adjusted.log_posterior == pytest.approx(
        whole.log_posterior - found.log_posterior, abs=0.1
    )


def test_a_delay_does_not_make_up_for_where_the_fits_own_unknowns_begin(fitted):
    _, found, model = fitted
    grown, z = grown_by(fitted, (SensorDelay("acc_floor1", 1e-3), SensorDelay("acc_floor1", -1e-3)))
    at = [u.name for u in grown.unknowns].index("sensor_delay acc_floor1 delay")
    off = 0.1 * np.array([u.name == "stiffness storey1" for u in grown.unknowns])
    adjusted = Adjusted(model, found)
    (_, near), (_, away) = (adjusted.steps(grown, begun, 1) for begun in (z, z + off))
    deviation = np.sqrt(fit(grown, z, most=3).covariance[at, at])
    assert abs(near[at] - away[at]) < deviation


def test_what_the_fits_own_unknowns_can_do_brings_nothing_beyond_their_priors(fitted):
    hypothesis, found, model = fitted
    k = hypothesis.problem.model.K[0, 0]
    grown, z = grown_by(fitted, (Stiffness("storey1", 0.05 * k), Stiffness("storey1", -0.05 * k)))
    adjusted = Adjusted(model, found)
    begin, _ = adjusted.steps(grown, z, 0)
    value, moved = adjusted.steps(grown, z, 4)
    at = [u.name for u in grown.unknowns].index("stiffness storey1 change")
    assert begin < adjusted.log_posterior < value + 0.5
    assert abs(moved[at]) < 0.2 < abs(z[at])
