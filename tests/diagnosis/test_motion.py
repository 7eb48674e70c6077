"""An estimated motion, and its accelerations where there are few samples in a period."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.candidates import motions, priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import Motion, begun_with
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.estimation.likelihood import passes
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.coulomb_friction import CoulombFriction


@pytest.mark.parametrize(("samples_a_period", "error"), [(5.0, 0.01), (10.0, 1e-3), (20.0, 1e-4)])
def test_accelerations_are_of_fourth_order(samples_a_period, error):
    h = 0.03
    w = 2 * np.pi / (samples_a_period * h)
    t = h * np.arange(200)
    q, v = np.sin(w * t)[:, None], w * np.cos(w * t)[:, None]
    found = Motion(q, v, 0 * v).acceleration(h)[1:-1]
    true = -(w**2) * q[1:-1]
    assert np.max(np.abs(found - true)) < error * np.max(np.abs(true))


@pytest.mark.parametrize("hanging", [(), (Appendage("floor2", 0.01, 9.0, 0.05),)])
def test_velocities_are_those_of_the_displacements_whatever_hangs_on_the_structure(hanging):
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    priors = tuple({n: (np.log(m.values[n]), 0.1) for n in m.parameters} for m in hanging)
    hypothesis = Hypothesis(problem, hanging, priors)
    (motion,) = motions(problem, hypothesis, np.zeros(len(hypothesis.unknowns)))
    assert motion.q.shape[1] == len(problem.model.coordinates)
    slopes = np.gradient(motion.q, problem.step_s, axis=0)
    left = np.std(motion.v - slopes, axis=0)
    assert np.all(left < 0.05 * np.std(motion.v, axis=0))


def test_what_friction_began_with_goes_on_in_a_twin_that_has_more():
    law = CoulombFriction("storey2", 0.05, 1e-3)
    whole = recorded(lumped(law), 1)
    moving = whole.trim(600, whole.samples)  # it begins in motion
    problem = prepare(lumped(), [moving], [recorded(lumped(law), 2)]).train
    scales = Scales({"storey2": (1.0, 1e-3, 0.05)})
    alone = Hypothesis(problem, (law,), (priors_of([law]),), scales)
    (run,) = passes(alone, np.zeros(len(alone.unknowns)))
    known = begun_with(run)
    assert np.any(np.abs(known) > 1e-6)
    hanging = Appendage("floor2", 0.01, 9.0, 0.05)
    priors = {n: (np.log(hanging.values[n]), 0.1) for n in hanging.parameters}
    more = replace(alone, mechanisms=(law, hanging), priors=(*alone.priors, priors),
                   begun=(known,))  # fmt: skip
    (grown,) = passes(more, np.zeros(len(more.unknowns)))
    assert len(grown.averages.start) > len(run.averages.start)
    assert begun_with(grown)[[0, 1, 3, 4]] == pytest.approx(known, rel=0.2, abs=1e-4)


def test_what_has_no_laws_began_with_nothing_that_is_known():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    blank = Hypothesis(problem)
    (run,) = passes(blank, np.zeros(len(blank.unknowns)))
    assert begun_with(run) is None
