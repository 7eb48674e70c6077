"""A force that jumps within a part of a sample, beside one known at each of 256 instants."""

import numpy as np
import pytest
from test_simulated import FORCE, NOISE, model, truth

from twin.estimation import passing
from twin.estimation.jumps import as_early
from twin.estimation.kalman import gains
from twin.estimation.laws import no_memory
from twin.estimation.low_pass import LowPass, in_moments, weights
from twin.estimation.sensitivities import no_slopes, numbers_of, plants_of
from twin.estimation.simulated import filtered

LOW_PASS, PARTS, FINELY, SAMPLES = LowPass(1.0), 4, 256, 200
MIDDLE = slice(30, -30)


def seen(force, parts):
    none = np.zeros((len(force), 1, 0))
    known = in_moments(weights, LOW_PASS, parts)
    return filtered(force[:, None], none, known, parts, SAMPLES)[0][MIDDLE, 0]


def test_a_filter_sees_a_jump_where_it_is_in_a_part():
    rng, within = np.random.default_rng(3), FINELY // PARTS
    jumps = np.zeros((SAMPLES + 40) * PARTS, int)
    jumps[::7] = rng.integers(1, within, len(jumps[::7]))
    first = np.cumsum(jumps > 0) % 2 * -2.0 + 1.0  # each part's first force, then the other sign
    first = np.where(jumps > 0, -first, first)
    early = np.arange(within) < jumps[:, None]
    force = np.where((jumps > 0)[:, None] & early, first[:, None], 0.0)
    force = np.where((jumps > 0)[:, None] & ~early, -first[:, None], force)
    force = np.where((jumps == 0)[:, None], first[:, None], force)
    means, w = force.mean(axis=1), jumps / within
    more = np.where(jumps > 0, 2 * first * (w * (1 - w) - 1 / 6) / 4, 0.0)
    exact = seen(force.ravel(), FINELY)
    by_means, by_both = (np.std(seen(x, PARTS) - exact) for x in (means, as_early(means, more)))
    assert by_both < 0.4 * by_means


def simulation(steps):
    of = model(LOW_PASS, steps)
    here = of.assemble(truth(of))
    (plant,) = plants_of(here, of)
    none = no_slopes(plant, gains(plant, here.noises[0]), numbers_of(here))
    found = passing.simulated(
        plant, here, here.trials[0], np.zeros(4), np.zeros((4, 0)), no_memory(here.laws), 0.0, none
    )
    return found.f[50:-20, 0], found.e[50:-20]


@pytest.mark.parametrize("steps", [4, 8])
def test_what_a_few_parts_of_a_sample_are_off_by_falls_with_their_square(steps):
    (force, read), (exact, told) = simulation(steps), simulation(FINELY)
    assert np.std(force - exact) < 0.002 * FORCE * (4 / steps) ** 2
    assert np.std(read - told) < NOISE * (4 / steps) ** 2


def test_parts_without_a_jump_stay_as_they_are():
    force = np.arange(5.0)
    assert np.array_equal(as_early(force, np.zeros(5)), force)
