import numpy as np
import pytest

from twin.control.excitation import WorstCase
from twin.errors import ControlError
from twin.laboratory.excitation import TimeBase

BASE = TimeBase(1024.0, 32, 0, 1024 * 64, 2048)


def test_the_harmonics_are_those_of_57():
    force = WorstCase((1.9, 6.8), (0.1, 0.2), 0.0).history(BASE, np.random.default_rng(0))
    t = np.arange(1024 * 64) / 1024
    expected = 0.1 * np.sin(2 * np.pi * 1.9 * t) + 0.2 * np.sin(2 * np.pi * 6.8 * t)
    assert force == pytest.approx(expected, abs=1e-12)


def test_the_noise_is_as_strong_as_said_and_within_its_band():
    quiet, loud = (
        WorstCase(noise_std=std, noise_band_hz=10.0).history(BASE, np.random.default_rng(0))
        for std in (0.0, 0.03)
    )
    noise = loud - quiet
    assert noise.std() == pytest.approx(0.03)
    power = np.abs(np.fft.rfft(noise)) ** 2
    outside = np.fft.rfftfreq(len(noise), 1 / 1024) > 10.0
    assert power[outside].sum() < 1e-20 * power.sum()


@pytest.mark.parametrize("wrong", [{"frequencies": (1.0,)}, {"noise_std": -1.0}])
def test_impossible_excitations_are_refused(wrong):
    with pytest.raises(ControlError, match=r"\(57\)"):
        WorstCase(**wrong)
