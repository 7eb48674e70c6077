"""Fits of a hypothesis: its parameters, how well they are known, and where the motion began."""

import numpy as np
import pytest
from diagnosis_support import TWO, error, exact_trial, lumped, recorded, rng

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import covariances, fit, log_likelihood, log_prior
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.refining import refined, with_slack

ALL = mechanisms.vocabulary()
TRUTH = {
    ("stiffness", "storey1"): -35.0,
    ("stiffness", "storey2"): 20.0,
    ("damping", "storey1"): 0.11,
    ("mass", "floor2"): 0.06,
}
QUIET = 1e-5


def true_mechanisms():
    return tuple(ALL[name](place, value) for (name, place), value in TRUTH.items())


def bench_of(*trials):
    return Bench(TWO, trials, between="linear")


def edited(mechanisms):
    model = TWO
    for mechanism in mechanisms:
        model = mechanism.edit(model)
    return model


def changes(hypothesis):
    return {(m.name, m.place): m.values["change"] for m in hypothesis.mechanisms}


def test_a_fit_finds_the_true_parameters_of_a_record_without_noise():
    bench = bench_of(exact_trial(true_mechanisms(), noise=0.0))
    found = fit(bench, base_hypothesis(TWO, 0.05, 0.3), QUIET, iterations=12)
    true, mine = (edited(m) for m in (true_mechanisms(), found.hypothesis.mechanisms))
    for name in "MRK":
        wanted = getattr(true, name)
        np.testing.assert_allclose(getattr(mine, name), wanted, atol=1e-4 * wanted.max())
        assert np.abs(getattr(TWO, name) - wanted).max() > 0.01 * wanted.max()


def test_the_fit_is_where_the_posterior_is_highest():
    bench = bench_of(exact_trial(true_mechanisms(), noise=0.02))
    found = fit(bench, base_hypothesis(TWO, 0.05, 0.3), QUIET, iterations=12, tolerance=1e-6)
    best = found.hypothesis.vector(found.unknowns)

    def posterior(vector):
        rows = bench.innovations(
            [found.hypothesis.at(found.unknowns, vector)], found.gains, found.starts
        )
        return log_likelihood([r[0] for r in rows]) + log_prior(found.unknowns, vector)

    assert posterior(best) == pytest.approx(found.log_posterior, abs=1e-6)
    for direction in np.diag(found.std):
        assert posterior(best + direction) < found.log_posterior
        assert posterior(best - direction) < found.log_posterior


def test_the_standard_deviation_is_the_scatter_of_noisy_records():
    hypothesis = Hypothesis(
        (), (), (ALL["stiffness"]("storey1", -20.0), ALL["mass"]("floor2", 0.05))
    )
    values, std = [], []
    for seed in range(20):
        clean = exact_trial((ALL["stiffness"]("storey1", -35.0),), noise=0.0, samples=384)
        noisy = clean.y + 0.05 * rng(seed).standard_normal(clean.y.shape)
        columns = {**clean.columns, **dict(zip(clean.outputs, noisy.T, strict=True))}
        trial = type(clean)(**{**vars(clean.with_columns(columns)), "output_noise": [0.05, 0.05]})
        found = fit(bench_of(trial), hypothesis, QUIET)
        values.append(found.hypothesis.vector(found.unknowns))
        std.append(found.std)
    scatter, told = np.std(values, axis=0, ddof=1), np.mean(std, axis=0)
    assert np.all(scatter < 1.6 * told)
    assert np.all(told < 1.6 * scatter)
    bias = np.abs(np.mean(values, axis=0) - [-35.0, 0.0])
    assert np.all(bias < 3 * told / np.sqrt(20))


def test_the_motion_at_the_first_sample_is_found_and_does_no_harm():
    start = np.array([5e-3, -8e-3, 0.1, 0.05])
    trial = exact_trial(true_mechanisms(), noise=1e-3, start=start)
    found = fit(bench_of(trial), base_hypothesis(TWO, 0.05, 0.3), QUIET, iterations=12)
    assert changes(found.hypothesis)["stiffness", "storey1"] == pytest.approx(-35.0, rel=0.02)
    assert error(found.starts[0], start) < 0.02
    e = found.innovations[0]
    assert np.sqrt(np.mean(e[:20] ** 2)) < 1.5e-3


def test_every_trial_has_its_own_start():
    starts = [np.array([5e-3, 0, 0, 0]), np.array([0, 0, 0.0, -0.2])]
    trials = [exact_trial((), seed=i, noise=1e-3, start=s) for i, s in enumerate(starts)]
    found = fit(bench_of(*trials), base_hypothesis(TWO), QUIET, iterations=8)
    for mine, start in zip(found.starts, starts, strict=True):
        assert error(mine, start) < 0.03


def test_a_prior_holds_what_the_data_do_not_tell():
    bench = bench_of(exact_trial(true_mechanisms(), noise=0.02))
    tight = fit(bench, base_hypothesis(TWO, 1e-6, 1e-6), QUIET, iterations=8)
    loose = fit(bench, base_hypothesis(TWO, 0.05, 0.3), QUIET, iterations=8)
    assert abs(changes(tight.hypothesis)["stiffness", "storey1"]) < 0.1
    assert changes(loose.hypothesis)["stiffness", "storey1"] == pytest.approx(-35.0, rel=0.1)
    np.testing.assert_allclose(tight.std, [u.prior_std for u in tight.unknowns], rtol=1e-2)


def test_a_law_s_parameters_are_fitted_beside_those_of_the_base():
    law = ALL["quadratic_stiffness"]("storey2", 4000.0)
    bench = bench_of(exact_trial((), noise=1e-3))
    forced = bench.stepped([Hypothesis((), (), (law,))], deaf(bench), None)[0]
    trial = bench.trials[0]
    y = trial.y - forced[0][0]
    columns = {**trial.columns, **dict(zip(trial.outputs, y.T, strict=True))}
    bench = bench_of(trial.with_columns(columns))
    base = base_hypothesis(TWO)
    found = refined(bench, [base.including(law.scaled(0.5))], 1e-3)
    assert found.hypothesis.found[0].stiffness == pytest.approx(4000.0, rel=1e-3)
    nothing = refined(bench, [base], 1e-3)
    assert nothing.bic > found.bic + 100
    assert found.free == 1
    assert found.bic == pytest.approx(-2 * found.log_posterior + np.log(found.samples), rel=1e-12)


def test_a_parameter_that_only_its_prior_knows_is_no_freedom_to_explain_with():
    # play so weak that no trial says whose stiffness it takes
    slack = ALL["clearance"]("storey2", 1.0, 0.005, 1.0)
    bench = bench_of(exact_trial((), noise=1e-3))
    found = fit(bench, base_hypothesis(TWO).including(slack), QUIET)
    replaced = next(i for i, u in enumerate(found.unknowns) if u.name == "replaced")
    share = found.std[replaced] / found.unknowns[replaced].prior_std
    assert 0.9 < share < 1.0
    assert found.free == pytest.approx(3 - share**2)
    assert found.free < 2.2


def deaf(bench):
    """Gains of nothing, which turn the filter into a simulation."""
    gains = fit(bench, base_hypothesis(TWO), QUIET, iterations=1).gains
    return [type(g)(0 * g.filtered, 0 * g.carried, g.predicted, g.innovation) for g in gains]


def test_the_slack_is_little_where_the_model_is_right_and_more_where_it_is_not():
    base = base_hypothesis(TWO)
    right = bench_of(exact_trial((), noise=0.02))
    wrong = bench_of(exact_trial((ALL["stiffness"]("storey1", -200.0),), noise=0.02))
    slacks = [with_slack(b, fit(b, base, 3e-3, iterations=2)).slack for b in (right, wrong)]
    assert slacks[0] <= 1e-3 < 1e-2 <= slacks[1]


def test_the_log_likelihood_is_the_gaussian_s_at_its_best_covariance():
    e = rng(3).standard_normal((500, 2)) @ [[1.0, 0.3], [0.0, 2.0]]
    (S,) = covariances([e])
    inverse = np.linalg.inv(S)
    each = -0.5 * np.einsum("ki,ij,kj->k", e, inverse, e)
    each -= 0.5 * np.log(np.linalg.det(2 * np.pi * S))
    assert log_likelihood([e]) == pytest.approx(each.sum(), rel=1e-9)
    assert log_likelihood([e, e]) == pytest.approx(2 * each.sum(), rel=1e-9)


def test_innovations_that_are_not_finite_are_never_likely():
    e = rng(3).standard_normal((50, 2))
    e[7, 1] = np.nan
    assert log_likelihood([e]) == -np.inf
    assert log_likelihood([np.ones((50, 2))]) == -np.inf


def test_steps_shorten_until_one_gains():
    """From far off, along a law that is not linear, only a short step leads to the better side."""
    stop = ALL["bumper"]("storey1", 5000.0, 0.002)
    records = [recorded(lumped(stop), seed, 1.0, 6.0) for seed in (1, 2)]
    ready = prepare(lumped(), records[:1], records[1:])
    soft = base_hypothesis(ready.train.model).including(stop.with_values({"stiffness": 500.0}))
    before, after = (fit(ready.train, soft, 1e-2, iterations=n) for n in (0, 20))
    assert after.log_posterior > before.log_posterior + 1000
    assert after.hypothesis.found[0].stiffness > 2000.0


def test_slopes_that_are_known_lead_to_the_same_place():
    bench = bench_of(exact_trial(true_mechanisms(), noise=0.01))
    start = base_hypothesis(TWO, 0.05, 0.3)
    first = fit(bench, start, QUIET, iterations=1)
    found = fit(bench, first.hypothesis, QUIET, first.starts, iterations=12)
    theta = first.hypothesis.vector(first.unknowns)
    slopes = {}
    for i, unknown in enumerate(first.unknowns[:-1]):
        step = 1e-4 * unknown.size
        moved = first.hypothesis.at(first.unknowns, theta + step * np.eye(len(theta))[i])
        rows = bench.innovations([moved], first.gains, first.starts)
        here = bench.innovations([first.hypothesis], first.gains, first.starts)
        slopes[unknown.index, unknown.name] = [
            (a[0] - b[0]) / step for a, b in zip(rows, here, strict=True)
        ]
    known = fit(bench, first.hypothesis, QUIET, first.starts, iterations=12, slopes=slopes)
    assert known.log_posterior == pytest.approx(found.log_posterior, abs=0.5)
    wrong = {key: [0 * slope for slope in its] for key, its in slopes.items()}
    stuck = fit(bench, first.hypothesis, QUIET, first.starts, iterations=12, slopes=wrong)
    assert stuck.log_posterior < found.log_posterior - 5.0
    # where the prior does not pull, either, nothing moves
    still = fit(bench, start, QUIET, first.starts, iterations=12, slopes=wrong)
    names = [(u.index, u.name) for u in first.unknowns]
    moved = still.hypothesis.vector(first.unknowns) - start.vector(first.unknowns)
    assert np.abs(moved[[names.index(key) for key in wrong]]).max() < 1e-2
