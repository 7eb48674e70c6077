from dataclasses import dataclass, replace

import numpy as np
import pytest
from estimation_support import CUBIC, FRICTION, TwoMasses, shaken

from twin.errors import NoLikelihoodError
from twin.estimation.fit import FARTHEST, FASTEST, fit
from twin.estimation.likelihood import evaluate
from twin.estimation.model import Unknown


def cubic(samples=600, seed=11):
    ports = ((1.0, 0.0),)
    return TwoMasses((shaken(samples, seed, (CUBIC,), ports),), (CUBIC,), ports)


def test_known_parameters_are_recovered_from_two_prior_deviations_away():
    model = replace(cubic(), steps=16)
    start = np.full(len(model.unknowns), 2.0) * [1, 1, -1, 1]
    found = fit(model, start)
    assert found.code == "converged"
    truth = {"stiffness": 400.0, "law 0 number 0": 4e5, "output noise 0": 0.05}
    for name, value in truth.items():
        assert abs(found.values[name] - value) < 4 * found.deviations[name], name
    # and the same from the prior's mean
    other = fit(model)
    assert other.z == pytest.approx(found.z, abs=0.3)
    assert other.log_evidence == pytest.approx(found.log_evidence, abs=0.05)


def test_covariances_cover_what_is_true():
    normed = []
    for seed in range(40):
        model = TwoMasses((shaken(200, 200 + seed),))
        found = fit(model)
        at = [u.name for u in model.unknowns].index("stiffness")
        normed.append((found.z[at] - 0.0) / np.sqrt(found.covariance[at, at]))
    assert 0.7 < np.std(normed) < 1.4
    assert abs(np.mean(normed)) < 0.6


@dataclass(frozen=True)
class Few:
    """A model of which only some unknowns are unknown; the others stay at the prior's mean."""

    whole: TwoMasses
    names: tuple[str, ...]

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        return tuple(u for u in self.whole.unknowns if u.name in self.names)

    @property
    def trials(self):
        return self.whole.trials

    def assemble(self, z):
        full = dict.fromkeys((u.name for u in self.whole.unknowns), 0.0)
        full |= dict(zip((u.name for u in self.unknowns), z, strict=True))
        return self.whole.assemble(np.array(list(full.values())))

    blurred = False

    def blur(self, forces, system):
        raise AssertionError("nothing is blurred")


def posterior(model, *z):
    point = np.array(z)
    value = evaluate(model, point, derivatives=False).log_likelihood
    return value - 0.5 * float(point @ point) - 0.5 * len(point) * np.log(2 * np.pi)


@pytest.mark.parametrize("name", ["stiffness", "law 0 number 0", "output noise 0"])
def test_laplace_evidence_is_the_integral_over_one_parameter(name):
    model = Few(cubic(150), (name,))
    found = fit(model)
    top, spread = found.log_posterior, np.sqrt(found.covariance[0, 0])
    grid = found.z[0] + spread * np.linspace(-6, 6, 121)
    area = np.trapezoid([np.exp(posterior(model, z) - top) for z in grid], grid)
    assert found.log_evidence == pytest.approx(top + np.log(area), abs=0.1)


def test_laplace_evidence_is_the_integral_over_two_parameters():
    model = Few(cubic(100), ("stiffness", "law 0 number 0"))
    found = fit(model)
    root = np.linalg.cholesky(found.covariance)

    grid = np.linspace(-5, 5, 41)
    heights = [
        [np.exp(posterior(model, *(found.z + root @ [a, b])) - found.log_posterior) for a in grid]
        for b in grid
    ]
    area = np.trapezoid(np.trapezoid(heights, grid), grid) * np.linalg.det(root)
    expected = found.log_posterior + np.log(area)
    assert found.log_evidence == pytest.approx(expected, abs=0.15)


def test_a_fit_that_begins_far_away_takes_bounded_steps_and_says_how_it_ended():
    model = cubic(200)
    with pytest.raises(NoLikelihoodError, match="runs away"):
        fit(model, np.array([0.0, 6.0, -5.0, 5.0]))
    away = fit(model, np.array([0.0, 2.5, 4.0, 4.0]), most=40)
    near = fit(model)
    assert away.code == "converged"
    assert away.log_posterior == pytest.approx(near.log_posterior, abs=0.1)
    assert fit(model, np.array([0.0, 0.5, 0.0, 0.0]), most=1).code == "stopped"
    tight = replace(model, loose=1e-4)
    beyond = fit(replace(tight, trials=(two_stiff(),)), most=2)
    assert np.max(np.abs(beyond.z)) > FARTHEST
    assert beyond.code == "ran away"


def test_levels_that_are_far_too_high_fall_by_no_more_than_a_factor_in_a_step():
    model = cubic(200)
    levels = np.array([u.level for u in model.unknowns])
    deviations = np.array([u.deviation for u in model.unknowns])
    start = np.where(levels, 12.0, 0.0)
    fallen = (start - fit(model, start, most=1).z)[levels] * deviations[levels]
    assert np.max(fallen) == pytest.approx(FASTEST, rel=1e-6)
    assert fit(model, start).log_posterior == pytest.approx(fit(model).log_posterior, abs=0.1)


def two_stiff():
    trial = shaken(300, 12, (CUBIC,), ((1.0, 0.0),))
    return replace(trial, y=1.2 * trial.y)


def test_a_short_fit_ends_at_the_same_place_though_nobody_asks_how_curved_it_is_there():
    model, start = cubic(), np.ones(4)
    asked = {True: 0, False: 0}
    ends = {}
    for curved in asked:

        def counted(z, derivatives=True, *rest, curved=curved):
            asked[curved] += derivatives
            return evaluate(model, z, derivatives, *rest)

        ends[curved] = fit(model, start, most=3, likelihood=counted, curved=curved)
    assert asked == {True: 4, False: 3}
    assert np.array_equal(ends[True].z, ends[False].z)
    assert ends[True].log_posterior == ends[False].log_posterior


def test_what_is_held_stays():
    model = cubic(200)
    free = np.array([True, False, True, True])
    found = fit(model, np.array([0.0, 1.0, 0.0, 0.0]), free=free)
    assert found.z[1] == 1.0
    assert found.covariance[1] == pytest.approx([0, 1, 0, 0])


def test_kinks_of_friction_do_not_stop_a_fit():
    ports = ((1.0, 0.0),)
    model = TwoMasses((shaken(500, 14, (FRICTION,), ports),), (FRICTION,), ports, steps=4)
    found = fit(model, np.array([1.0, 1.5, 2.0, 1.0, -1.0]), most=40)
    assert found.code == "converged"
    assert abs(found.values["law 0 number 0"] - 0.6) < 5 * found.deviations["law 0 number 0"]


def test_a_fit_that_need_not_be_exact_ends_sooner_and_near():
    asked = []

    def counted(z, *given):
        asked.append(given)
        return evaluate(model, z, *given)

    model = cubic()
    start = np.full(len(model.unknowns), 2.0) * [1, 1, -1, 1]
    exact = fit(model, start, likelihood=counted)
    steps = len(asked)
    rough = fit(model, start, likelihood=counted, enough=2.0)
    assert len(asked) - steps < steps
    assert exact.log_posterior - 2.0 < rough.log_posterior <= exact.log_posterior
