"""An instrument with states of its own may stand before an input, too: a base accelerometer's."""

import numpy as np
import pytest
from shaken_support import FINE, chain, ground, shaken

from twin.diagnosis.beginning import added, moved_to, start_of
from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import fit
from twin.mechanisms.sensor_highpass import SensorHighpass
from twin.recording import Recording

MASSES, STIFFNESSES, RATE, NOISE = np.array([1.0, 1.0]), np.array([400.0, 300.0]), 50.0, 5e-3


def recorded(seed, corner):
    """A chain on a shaken ground whose own accelerometer may lose what is slow."""
    wave = ground(20, RATE, seed, 1.0)
    sound = shaken(MASSES, STIFFNESSES, [0.3, 0.3], wave, RATE, f"{seed}.csv", noise=NOISE)
    wave = (wave + np.concatenate([[0.0], wave[:-1]])) / 2  # it was held from step to step
    read = SensorHighpass("acc_ground", corner).distort({"acc_ground": wave}, RATE * FINE)
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(wave) // FINE)
    columns = {name: np.array(sound.column(name)) for name in sound.names}
    columns["acc_ground"] = read["acc_ground"][::FINE] + noise
    return Recording.build(RATE, columns, sound.source)


def fitted(corner, *instruments):
    train, test = recorded(1, corner), recorded(2, corner)
    hypothesis = Hypothesis(prepare(chain(MASSES, STIFFNESSES), [train], [test]).train)
    z = start_of(hypothesis)
    for start in instruments:
        grown = added(hypothesis, Candidate((start,), priors_of((start,))), start)
        hypothesis, z = grown, moved_to(grown, hypothesis, z, start)
    return fit(hypothesis, z)


def test_a_high_pass_of_the_base_s_accelerometer_is_told_from_the_structure():
    sound, blind = fitted(0.0), fitted(0.3)
    found = fitted(0.3, SensorHighpass("acc_ground", 0.1))
    corner = found.values["sensor_highpass acc_ground corner"]
    assert corner == pytest.approx(0.3, rel=0.05)
    for name in ("stiffness storey1", "stiffness storey2"):
        assert found.values[name] == pytest.approx(sound.values[name], rel=3e-3)
    # what is lost of the slow part tells a little less
    assert found.log_likelihood == pytest.approx(sound.log_likelihood, abs=100)
    assert blind.log_likelihood < sound.log_likelihood - 500
