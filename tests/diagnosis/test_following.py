"""Wind does not know how far the frame moves; a law that was left out does."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import RATE, TWO, exact_trial, rng
from scipy.signal import butter, sosfilt

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.filtering import recursion
from twin.diagnosis.fitting import fit
from twin.diagnosis.following import _correlation, follows_motion
from twin.diagnosis.plant import build, sampled

Force = mechanisms.vocabulary()["unmeasured_force"]
OUTPUTS = ("acc_floor1", "acc_floor2")
SAMPLES = 2048


def envelope(samples):
    """A hit, and silence after it, twice."""
    t = np.arange(samples) % (samples // 2) / RATE
    return np.exp(-t / 1.5)


def pushed(seed, level):
    """A trial in which broad noise pushes the second floor, as strong as the level says."""
    trial = exact_trial(seed=seed, noise=1e-3, samples=SAMPLES)
    trial = replace(trial, u=trial.u * envelope(SAMPLES)[:, None])
    measured = sampled(build(TWO, (), trial.inputs, OUTPUTS), 1 / RATE)
    hidden = sampled(build(TWO, (), ("force_floor2",), OUTPUTS), 1 / RATE)
    noise = sosfilt(butter(2, 12.0, fs=RATE, output="sos"), rng(9 + seed).standard_normal(SAMPLES))
    y = rng(90 + seed).standard_normal((SAMPLES, 2)) * 1e-3
    for plant, u in ((measured, trial.u), (hidden, (noise * level)[:, None])):
        after = np.concatenate([u[1:], u[-1:]])
        x = recursion(plant.A, u @ plant.B0.T + after @ plant.B1.T)
        y = y + x @ plant.plant.C.T + u @ plant.plant.D.T
    return replace(trial, y=y)


@pytest.mark.parametrize(
    ("level", "follows"), [(np.ones(SAMPLES), False), (envelope(SAMPLES), True)],
    ids=["steady", "dies away with every hit"],
)  # fmt: skip
def test_a_force_that_dies_away_with_the_motion_follows_it_and_a_steady_one_does_not(
    level, follows
):
    bench = Bench(TWO, tuple(pushed(seed, 0.5 * level) for seed in (1, 2)), between="linear")
    base = base_hypothesis(TWO)
    nothing = fit(bench, base, 1e-2)
    found = fit(bench, base.including(Force("floor2", 0.5, 5.0, 10.0)), 1e-4)
    assert follows_motion(bench, nothing, found) is follows


def test_a_lorry_that_shakes_the_frame_by_itself_is_no_law():
    comes_later = np.roll(envelope(SAMPLES), SAMPLES // 4)
    bench = Bench(TWO, tuple(pushed(s, 40.0 * comes_later) for s in (1, 2)), between="linear")
    base = base_hypothesis(TWO)
    nothing = fit(bench, base, 1e-2)
    found = fit(bench, base.including(Force("floor2", 40.0, 5.0, 10.0)), 1e-4)
    assert not follows_motion(bench, nothing, found)


@pytest.mark.parametrize(
    ("heard", "outputs"),
    [
        ([np.ones(10)], [np.ones((10, 2))]),  # shorter than a window
        ([np.zeros(2048)], [np.ones((2048, 2))]),  # silent
        ([np.ones(2048)], [np.arange(4096.0).reshape(2048, 2)]),  # always the same
    ],
    ids=["short", "silent", "steady"],
)
def test_what_cannot_tell_does_not_follow(heard, outputs):
    with np.errstate(all="raise"):
        assert _correlation(heard, outputs, 64) == 0.0


def test_powers_that_go_together_correlate_whatever_their_scale():
    t = np.arange(2048) / RATE
    force = np.exp(-t / 4) * rng(1).standard_normal(2048)
    assert _correlation([force], [1e3 * np.column_stack([force, force])], 64) > 0.99
