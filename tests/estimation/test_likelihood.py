from dataclasses import replace

import numpy as np
import pytest
from estimation_support import (
    BUMPER,
    CUBIC,
    FRICTION,
    SLIDERS,
    SLIP,
    TwoMasses,
    assert_gradient,
    shaken,
)
from scipy.stats import multivariate_normal

from twin.estimation.likelihood import evaluate
from twin.estimation.low_pass import LowPass
from twin.estimation.model import Trial


def joint(model, z, trial):
    """Return mean and covariance of all outputs, by superposing unit disturbances."""
    from twin.estimation.system import sampled

    here = model.assemble(z)
    system, noise, data = here.systems[0], here.noises[trial], model.trials[trial]
    plant = sampled(system, data.step_s, here.steps, here.held)
    samples, n = len(data.y), len(plant.A)
    one = sampled(system, data.step_s, 1, here.held)
    x, mean = np.zeros(n), []
    for k in range(samples):
        mean.append(system.C @ x + system.D @ data.u[k])
        if k + 1 < samples:
            x = one.A @ x + one.B0 @ data.u[k] + one.B1 @ data.u[k + 1]
    # y = O x0 + sum of held disturbances and of steps of the latent force, each independent
    columns = []
    root = np.linalg.cholesky(noise.start)
    powers = [np.linalg.matrix_power(one.A, k) for k in range(samples)]
    columns.append(np.vstack([system.C @ powers[k] @ root for k in range(samples)]))
    for j in range(samples):
        rows = [np.zeros((2, system.W.shape[1]))] * j + [system.V * noise.held]
        rows += [system.C @ powers[k - j - 1] @ (one.W * noise.held) for k in range(j + 1, samples)]
        columns.append(np.vstack(rows))
        values, vectors = np.linalg.eigh(plant.Q)
        spread = vectors * np.sqrt(np.maximum(values, 0))
        rows = [np.zeros((2, n))] * (j + 1)
        rows += [system.C @ powers[k - j - 1] @ spread for k in range(j + 1, samples)]
        columns.append(np.vstack(rows))
    L = np.hstack(columns)
    return np.concatenate(mean), L @ L.T + np.diag(np.tile(noise.output**2, samples))


@pytest.mark.parametrize("latent", [False, True])
@pytest.mark.parametrize("missing", [False, True])
def test_the_log_likelihood_is_the_density_of_all_outputs_at_once(latent, missing):
    ports = ((1.0, 0.0),) if latent else ()
    trial = shaken(40, 3)
    y = trial.y.copy()
    if missing:
        y[[5, 20, 21, 22, 39], [0, 0, 0, 1, 1]] = np.nan
    model = TwoMasses((Trial(trial.u, trial.between, y, trial.step_s),), (), ports, latent=latent)
    z = 0.3 * np.random.default_rng(4).normal(size=len(model.unknowns))
    mean, covariance = joint(model, z, 0)
    seen = ~np.isnan(y.ravel())
    expected = multivariate_normal(mean[seen], covariance[np.ix_(seen, seen)]).logpdf(
        y.ravel()[seen]
    )
    filtered = evaluate(model, z, derivatives=False, filtered=True).log_likelihood
    assert filtered == pytest.approx(expected, abs=0.05)
    if not missing:  # the first state integrated out in closed form
        value = evaluate(model, z, derivatives=False).log_likelihood
        assert value == pytest.approx(expected, abs=1e-6)


CASES = {
    "linear": ((), ()),
    "cubic": ((CUBIC,), ((1.0, 0.0),)),
    "friction": ((FRICTION,), ((-1.0, 1.0),)),
    "bumper": ((BUMPER,), ((1.0, 0.0),)),
    "slip": ((SLIP,), ((1.0, 0.0),)),
    "sliders": ((SLIDERS,), ((1.0, 0.0),)),
    "sliders beside friction": ((SLIDERS, FRICTION), ((-1.0, 1.0), (1.0, 0.0))),
    "two laws": ((FRICTION, CUBIC), ((1.0, 0.0), (1.0, 0.0))),
    "slip beside friction": ((SLIP, FRICTION), ((-1.0, 1.0), (1.0, 0.0))),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("latent", [False, True])
@pytest.mark.parametrize(
    ("low_pass", "yielding"), [(None, 0.0), (LowPass(0.9), 0.0), (LowPass(0.9), 1.0)],
    ids=["followed", "simulated", "yielding"],
)  # fmt: skip
def test_sensitivities_are_those_of_finite_differences(name, latent, low_pass, yielding):
    laws, ports = CASES[name]
    if latent and not ports:
        ports = ((1.0, 0.0),)
    trial = shaken(300, 5, laws, ports if laws else ())
    model = TwoMasses((trial,), laws, ports, latent=latent, low_pass=low_pass,
                      yielding=yielding)  # fmt: skip
    z = 0.2 * np.random.default_rng(6).normal(size=len(model.unknowns))
    here = evaluate(model, z, filtered=True)
    settled = len(here.runs[0].gains.state) - 1
    for i, unknown in enumerate(model.unknowns):
        h = 1e-6  # corners of laws lie hardly ever between both steps
        up, low = z.copy(), z.copy()
        up[i] += h
        low[i] -= h
        # what the laws do on the average is held while differences are taken
        averages = [run.averages for run in here.runs]
        a, b = (evaluate(model, q, derivatives=False, averages=averages, filtered=True)
                for q in (up, low))  # fmt: skip
        slope = (a.runs[0].e - b.runs[0].e) / (2 * h)
        found = here.runs[0].de[:, :, i]
        # where the gains have settled, and where no corner of a law lies between both steps
        error = np.abs(found - slope)[settled:]
        size = np.sqrt(np.mean(slope[settled:] ** 2))
        assert np.quantile(error, 0.9) < 0.01 * size, unknown.name
        change = (a.log_likelihood - b.log_likelihood) / (2 * h)
        spread = np.sqrt(here.information[i, i])
        assert here.gradient[i] == pytest.approx(change, abs=0.15 * spread), unknown.name


class Quiet(TwoMasses):
    """The two masses with hardly any noise, their first state as uncertain as ever."""

    def assemble(self, z):
        here = super().assemble(z)
        quiet = [replace(n, held=1e-4 * n.held, output=1e-4 * n.output) for n in here.noises]
        return replace(here, noises=tuple(quiet))


def test_beside_a_first_state_of_wide_prior_the_gradient_is_right_to_a_hundredth_of_its_spread():
    model = Quiet((shaken(300, 5, noise=(5e-6, 2e-6)),))
    z = np.zeros(len(model.unknowns))
    here = evaluate(model, z)
    for i, unknown in enumerate(model.unknowns):
        step = np.zeros(len(z))
        step[i] = 0.01 / np.sqrt(here.information[i, i])
        a, b = (evaluate(model, z + s * step, derivatives=False) for s in (1, -1))
        change = (a.log_likelihood - b.log_likelihood) / (2 * step[i])
        spread = np.sqrt(here.information[i, i])
        assert here.gradient[i] == pytest.approx(change, abs=0.01 * spread), unknown.name


def test_with_gaps_the_gradient_is_that_of_the_likelihood_to_a_fraction_of_its_spread():
    # the gains' derivatives in a gap are taken as those without it
    model = TwoMasses((shaken(300, 5, missing=0.01),))
    z = 0.2 * np.random.default_rng(6).normal(size=len(model.unknowns))
    assert_gradient(model, z, of_spread=0.5)


def test_where_a_recording_begins_without_outputs_the_gradient_is_as_right_as_with_them():
    whole = shaken(300, 5)
    y = whole.y.copy()
    y[:40], y[40:60, 0], y[-20:] = np.nan, np.nan, np.nan
    for trial in (whole, replace(whole, y=y)):
        model = TwoMasses((trial,))
        z = 0.2 * np.random.default_rng(6).normal(size=len(model.unknowns))
        assert_gradient(model, z, of_spread=0.03)


def test_noise_levels_of_one_recording_leave_the_others_alone():
    trials = (shaken(120, 7), shaken(150, 8))
    both = evaluate(TwoMasses(trials), np.zeros(5))
    first = evaluate(TwoMasses(trials[:1]), np.zeros(3))
    second = evaluate(TwoMasses(trials[1:]), np.zeros(3))
    assert both.log_likelihood == pytest.approx(first.log_likelihood + second.log_likelihood)
    assert both.gradient[1:3] == pytest.approx(first.gradient[1:])
    assert both.gradient[3:] == pytest.approx(second.gradient[1:])
    assert both.gradient[0] == pytest.approx(first.gradient[0] + second.gradient[0])
    assert both.information[1:3, 3:] == pytest.approx(np.zeros((2, 2)))


def test_information_is_the_spread_of_the_gradient():
    draws = [evaluate(TwoMasses((shaken(150, 100 + s),)), np.zeros(3)) for s in range(60)]
    gradients = np.array([d.gradient for d in draws])
    expected = np.mean([d.information for d in draws], axis=0)
    ratio = np.var(gradients, axis=0) / np.diag(expected)
    assert np.all(np.abs(np.log(ratio)) < np.log(2.0)), ratio


def test_derivatives_with_respect_to_some_unknowns_are_those_among_all():
    trials = (shaken(120, 5, (CUBIC,), ((1.0, 0.0),)), shaken(90, 6, (CUBIC,), ((1.0, 0.0),)))
    model = TwoMasses(trials, (CUBIC,), ((1.0, 0.0),))
    z = 0.1 * np.random.default_rng(7).normal(size=len(model.unknowns))
    whole = evaluate(model, z)
    free = np.arange(len(z)) % 2 == 0
    some = evaluate(model, z, free=free)
    assert some.log_likelihood == whole.log_likelihood
    assert some.gradient == pytest.approx(np.where(free, whole.gradient, 0.0), rel=1e-9)
    assert some.information == pytest.approx(
        np.where(np.outer(free, free), whole.information, 0.0), rel=1e-9, abs=1e-9
    )
