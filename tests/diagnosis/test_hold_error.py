"""What straight lines miss, as a function of the structure."""

import numpy as np
import pytest
from beam_support import INPUTS, OUTPUTS, RATE, SAMPLES, answer, problem_of, random_force

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.straight import FREQUENCIES, hold_error
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, RandomShaking, run
from twin.mechanisms.damping import Damping
from twin.model import Twin


def test_what_lines_miss_is_that_of_the_structure_at_the_values_that_are_asked_for():
    u = random_force(50.0, 1)
    start = Damping("hinge3", 0.02)
    blank = Hypothesis(problem_of(u, np.ones((SAMPLES, 2)), 1e-3))
    h = added(blank, Candidate((start,), priors_of((start,))), start)
    z = moved_to(h, blank, np.zeros(len(blank.unknowns)), start)
    z[0] = 3.0
    (trial,) = h.assemble(z).trials
    structure = start.edit(h.problem.base(z[: len(h.problem.base_unknowns)]))
    wanted = hold_error(structure, 1 / RATE).of(u)
    assert trial.missed == pytest.approx(wanted, abs=1e-9 * np.max(np.abs(wanted)))
    nominal = hold_error(h.problem.model, 1 / RATE).of(u)
    assert np.max(np.abs(wanted - nominal)) > 0.01 * np.max(np.abs(wanted))


def test_between_its_frequencies_what_lines_miss_is_smooth():
    u = random_force(120.0, 1)
    model = Twin.load("cantilever").linear(INPUTS, OUTPUTS)
    coarse = hold_error(model, 1 / RATE)
    exact = hold_error(model, 1 / RATE, 4 * (FREQUENCIES - 1) + 1)
    change = (coarse.of(u) - exact.of(u))[64:-64]
    y = answer(model, u)
    assert np.max(np.std(change, axis=0) / np.std(y, axis=0)) < 1e-5


def test_the_gradient_knows_that_what_lines_miss_changes_with_the_structure():
    u = random_force(70.0, 1)
    y = answer(Damping("hinge3", 0.02).edit(Twin.load("cantilever").linear(INPUTS, OUTPUTS)), u)
    start = Damping("hinge3", 0.01)
    blank = Hypothesis(problem_of(u, y, 1e-3 * float(np.std(y))))
    h = added(blank, Candidate((start,), priors_of((start,))), start)
    z = moved_to(h, blank, np.zeros(len(blank.unknowns)), start)
    gradient, step = evaluate(h, z).gradient, 1e-4
    for i in (0, len(blank.problem.base_unknowns)):
        low, high = (evaluate(h, z + s * step * (np.arange(len(z)) == i), False).log_likelihood
                     for s in (-1, 1))  # fmt: skip
        assert gradient[i] == pytest.approx((high - low) / (2 * step), rel=2e-3), h.unknowns[i].name


@pytest.mark.parametrize("share", [0.25, 1.5])
def test_a_dashpot_is_found_as_strong_as_it_is_though_modes_above_the_band_feel_it(share):
    dashpot = Damping("hinge3", 0.01)
    shaking = Experiment(
        RandomShaking(0.03, (0.5, 70.0)),
        ("force_mid", "force_tip"),
        Analyser(192.0, 6.0, physics_hz=32 * 192.0),
        instruments=dict.fromkeys(("acc", "force"), Instrument(noise_fraction=0.005)),
    )
    true = Twin.load("cantilever").including(dashpot)
    train, test = run(shaking, true, 1), run(shaking, true, 2)
    problem = prepare(Twin.load("cantilever"), [train], [test], None, 0.1, None).train
    start = dashpot.with_values({"change": share * dashpot.change})
    blank = Hypothesis(problem)
    h = added(blank, Candidate((start,), priors_of((dashpot,))), start)
    found = fit(h, moved_to(h, blank, np.zeros(len(blank.unknowns)), start))
    assert found.code == "converged"
    assert h.at(found.z)[0].change == pytest.approx(dashpot.change, rel=0.02)
