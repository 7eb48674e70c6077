"""Samples that are missing are those of the signal's own tones and resonances."""

import numpy as np

from twin.signals.interpolation import interpolated

TIME = np.arange(2000) / 200.0


def test_a_tone_is_continued_through_a_gap_of_half_a_period():
    tone = np.sin(2 * np.pi * 3.1 * TIME) + 0.5 * np.sin(2 * np.pi * 11.7 * TIME + 1.0)
    noisy = tone + 1e-3 * np.random.default_rng(1).standard_normal(len(tone))
    missing = np.zeros(len(tone), bool)
    for begin in range(100, 1900, 150):
        missing[begin : begin + 32] = True
    found = interpolated(np.where(missing, 99.0, noisy), missing)
    assert np.max(np.abs(found - tone)[missing]) < 0.02
    assert np.all(found[~missing] == noisy[~missing])


def test_nothing_is_said_where_no_stretch_is_whole():
    missing = np.arange(2000) % 20 == 0
    assert interpolated(np.sin(TIME), missing) is None
    assert interpolated(np.sin(TIME), np.zeros(2000, bool)) is None
    assert interpolated(np.zeros(10), np.ones(10, bool)) is None
