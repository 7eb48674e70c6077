"""Band-limited signals between their samples."""

import numpy as np
import pytest

from twin.estimation.low_pass import interpolated


@pytest.mark.parametrize("steps", [1, 4, 7])
def test_between_samples_a_band_limited_signal_is_found_again(steps):
    fine = np.arange(400 * steps) / steps
    tones = (0.03, 0.2, 0.37)  # cycles a sample, the last one at the edge of an analyser's band
    true = sum(np.cos(2 * np.pi * f * fine + i) for i, f in enumerate(tones))
    found = interpolated(true[::steps, None], steps)[:, 0]
    inside = slice(20 * steps, -20 * steps)
    assert np.max(np.abs(found - true)[inside]) < 1e-4
