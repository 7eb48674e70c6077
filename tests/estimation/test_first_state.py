from dataclasses import replace

import numpy as np
import pytest
from estimation_support import CUBIC, TwoMasses, assert_gradient, shaken, two_masses
from scipy.linalg import solve_discrete_lyapunov

from twin.errors import NoLikelihoodError
from twin.estimation.averages import averages_at
from twin.estimation.first_state import measured, settled
from twin.estimation.kalman import gains
from twin.estimation.likelihood import evaluate, gaussian
from twin.estimation.passing import run
from twin.estimation.sensitivities import plants_of
from twin.estimation.system import Noise, sampled


class Begun(TwoMasses):
    """The two masses with another covariance of their first state, and outputs that are blurred."""

    def __init__(self, trial, width, blur=None, quiet=1.0, latent=False):
        super().__init__((trial,), latent=latent, ports=((1.0, 0.0),) if latent else ())
        object.__setattr__(self, "beginning", (width, blur, quiet))

    def assemble(self, z):
        width, blur, quiet = self.beginning
        here = super().assemble(z)
        noises = tuple(replace(n, start=width * n.start, held=quiet * n.held) for n in here.noises)
        return replace(here, noises=noises, blurs=(blur,))


def exactly(model, z):
    """Return the log likelihood by gains that follow every sample."""
    here = model.assemble(z)
    plants, trial = plants_of(here, model), here.trials[0]
    averages = averages_at(model, here, plants, 0)
    gain = gains(plants[0], here.noises[0], len(trial.y), missing=trial.missing)
    return gaussian(run(here, trial, plants[0], gain, averages=averages), trial).value


def late(trial):
    """Return the recording without its first and last outputs."""
    y = trial.y.copy()
    y[:25], y[-15:] = np.nan, np.nan
    return replace(trial, y=y)


TRIAL = shaken(300, 5)
SOME = np.zeros((300, 2))
SOME[[30, 31, 32, 90], [0, 0, 1, 1]] = 0.5
CASES = {
    "wide": Begun(TRIAL, 1e4),
    "known": Begun(TRIAL, 0.0),
    "late": Begun(late(TRIAL), 1.0),
    "late, latent": Begun(late(TRIAL), 1.0, latent=True),
    "slow to forget": Begun(TRIAL, 1.0, quiet=1e-3),
    "late and slow": Begun(late(TRIAL), 1.0, quiet=1e-3),
}
BLURRED = {
    "blurred": Begun(TRIAL, 1.0, SOME),
    "late and blurred": Begun(late(TRIAL), 1.0, SOME, quiet=1e-2),
}


@pytest.mark.parametrize("name", CASES)
def test_a_first_state_integrated_out_leaves_the_likelihood_of_a_filter_that_follows_it(name):
    model = CASES[name]
    z = 0.2 * np.random.default_rng(6).normal(size=len(model.unknowns))
    value = evaluate(model, z, derivatives=False).log_likelihood
    assert value == pytest.approx(exactly(model, z), abs=1e-6)


@pytest.mark.parametrize("name", BLURRED)
def test_beside_blurred_outputs_it_moves_innovations_as_the_predictor_says(name):
    model = BLURRED[name]
    z = 0.2 * np.random.default_rng(6).normal(size=len(model.unknowns))
    here = model.assemble(z)
    (plant,), (trial,), (noise,) = plants_of(here, model), here.trials, here.noises
    averages = averages_at(model, here, [plant], 0)
    found = settled(plant, noise, measured(trial.y), averages.blur)

    def moved(state):
        added = state, found.first
        return run(here, trial, plant, found.gain, averages=averages, added=added).e

    still = moved(np.zeros(4))
    slopes = np.stack([still - moved(unit) for unit in np.eye(4)], axis=-1)
    part = gaussian(run(here, trial, plant, found.gain, averages=averages), trial)
    white = part.whitened(slopes)[found.rows]
    np.testing.assert_allclose(found.slopes, white, atol=1e-9 * np.max(np.abs(white)))


@pytest.mark.parametrize("name", [*CASES, *BLURRED])
def test_its_gradient_is_that_of_the_likelihood(name):
    model = (CASES | BLURRED)[name]
    z = 0.2 * np.random.default_rng(6).normal(size=len(model.unknowns))
    here = evaluate(model, z)
    value = evaluate(model, z, derivatives=False).log_likelihood
    assert here.log_likelihood == pytest.approx(value, abs=1e-6)
    near = 5e-3 if name in CASES else 3e-2  # that outputs are blurred is left out of what is told
    # derivatives of levels are differences over 3e-4 of a deviation
    assert_gradient(model, z, near, rel=3e-4)


def test_its_information_is_that_of_the_filter_but_for_what_the_gains_that_follow_it_tell():
    model = Begun(TRIAL, 1.0)
    z = np.zeros(len(model.unknowns))
    one, other = evaluate(model, z), evaluate(model, z, filtered=True)
    np.testing.assert_allclose(one.information, other.information, rtol=0.05, atol=0.5)
    assert np.linalg.slogdet(one.information)[1] == pytest.approx(
        np.linalg.slogdet(other.information)[1], abs=0.05
    )


def test_laws_that_follow_the_motion_find_the_first_state_from_where_it_is_far():
    ports = ((1.0, 0.0),)
    trial = shaken(600, 5, (CUBIC,), ports)
    late = replace(trial, u=trial.u[200:], between=trial.between[200:], y=trial.y[200:])
    model = TwoMasses((late,), (CUBIC,), ports)
    z = np.zeros(len(model.unknowns))
    here = evaluate(model, z)
    value = evaluate(model, z, derivatives=False).log_likelihood
    assert here.log_likelihood == pytest.approx(value, abs=0.01)
    filtered = evaluate(model, z, derivatives=False, filtered=True).log_likelihood
    assert value > filtered + 1000  # a filter that begins at rest linearises about another motion
    # the first state, and what laws do on the average, are held while the gradient is taken
    assert_gradient(model, z, 0.4)


def test_what_a_first_state_tells_sums_over_the_samples_that_were_measured():
    plant = sampled(two_masses(), 1 / 64, 1, np.zeros(1, bool))
    noise = Noise(np.array([0.3, 0.2]), np.array([0.1, 0.2]), np.diag([1e-2] * 4))
    many = settled(plant, noise, slice(0, 4000))
    seen = plant.system.C.T @ np.linalg.solve(many.gain.innovation[-1], plant.system.C)
    every = solve_discrete_lyapunov(many.closed.T, seen)
    np.testing.assert_allclose(many.gramian, every, rtol=1e-9, atol=1e-9 * np.max(every))
    few = settled(plant, noise, slice(3, 13))
    last = np.linalg.matrix_power(many.closed, 10)
    np.testing.assert_allclose(few.gramian, every - last.T @ every @ last, rtol=1e-9,
                               atol=1e-9 * np.max(every))  # fmt: skip
    assert few.first == 3
    assert len(few.slopes) == 20
    # as wide a prior as can be leaves what is told, none leaves nothing
    wide = settled(plant, replace(noise, start=1e8 * np.eye(4)), slice(0, 4000))
    np.testing.assert_allclose(wide.posterior, np.linalg.inv(every), rtol=1e-5)


def test_samples_that_are_missing_between_others_are_none_to_begin_with():
    y = np.ones((10, 2))
    assert measured(y) == slice(0, 10)
    y[:2], y[8:] = np.nan, np.nan
    assert measured(y) == slice(2, 8)
    y[5, 1] = np.nan
    assert measured(y) is None
    assert measured(np.full((4, 2), np.nan)) is None


def test_a_first_state_that_may_be_anywhere_has_no_likelihood():
    plant = sampled(two_masses(), 1 / 64, 1, np.zeros(1, bool))
    noise = Noise(np.array([0.3, 0.2]), np.array([0.1, 0.2]), np.diag([np.inf, 1, 1, 1]))
    with pytest.raises(NoLikelihoodError, match="anywhere"):
        settled(plant, noise, slice(0, 10))


def test_outputs_without_noise_are_said():
    plant = sampled(two_masses(), 1 / 64, 1, np.zeros(1, bool))
    blind = replace(plant, system=replace(plant.system, C=0 * plant.system.C, V=0 * plant.system.V))
    noise = Noise(np.array([0.3, 0.2]), np.zeros(2), np.eye(4))
    with pytest.raises(np.linalg.LinAlgError):
        settled(blind, noise, slice(0, 10))
