"""H1, H2 and Hv: where each is free of bias, and whether its variance is what it says."""

import numpy as np
import pytest

from twin.errors import RecordingError
from twin.signals.estimators import repetition
from twin.signals.frf import averaged, measured_response

TRUE = 2.0 - 1.0j
BLOCK = 64


def records(noise_u, noise_y, blocks=64, seed=0, inputs=1):
    """A response that is the same at every line, in blocks that are periodic."""
    rng = np.random.default_rng(seed)
    U = rng.standard_normal((blocks, BLOCK // 2 + 1, inputs, 2)) @ [1, 1j]
    gain = TRUE * np.arange(1, inputs + 1)
    y = np.fft.irfft(U @ gain, BLOCK, axis=1).reshape(-1, 1)
    u = np.fft.irfft(U, BLOCK, axis=1).reshape(-1, inputs)
    for x, level in ((u, noise_u), (y, noise_y)):
        x += level * x.std(axis=0) * rng.standard_normal(x.shape)
    return [(u, y)]


def estimated(estimator, noise_u, noise_y, **options):
    found = averaged(
        records(noise_u, noise_y, **options), 1.0, BLOCK, "boxcar", estimator=estimator
    )
    return found, found.H[2:-2]


@pytest.mark.parametrize(
    ("estimator", "noise"), [("H1", (0, 0.5)), ("H2", (0.5, 0)), ("Hv", (0.5, 0.5))]
)
def test_each_is_free_of_bias_where_its_noise_is(estimator, noise):
    _, H = estimated(estimator, *noise, blocks=4000)
    assert np.mean(H) == pytest.approx(TRUE, rel=0.01)
    for other in {"H1", "H2", "Hv"} - {estimator}:
        _, H = estimated(other, *noise, blocks=4000)
        assert abs(np.mean(H) / TRUE - 1) > 0.05


@pytest.mark.parametrize(
    ("estimator", "noise"), [("H1", (0, 0.5)), ("H2", (0.5, 0)), ("Hv", (0.3, 0.3))]
)
def test_the_variance_is_the_mean_square_of_the_error(estimator, noise):
    ratios = []
    for seed in range(20):
        found, H = estimated(estimator, *noise, blocks=40, seed=seed)
        ratios.append(np.mean(np.abs(H - TRUE) ** 2) / np.mean(found.variance[2:-2]))
    assert np.mean(ratios) == pytest.approx(1, abs=0.12)


@pytest.mark.parametrize("estimator", ["H1", "Hv"])
def test_several_inputs_each_get_their_own_response(estimator):
    _, H = estimated(estimator, 0, 1e-6, inputs=3)
    np.testing.assert_allclose(np.mean(H, axis=0)[0], TRUE * np.arange(1, 4), rtol=1e-3)


def test_overlapping_hann_blocks_count_for_a_little_less():
    """Half overlapping: 1 + 2 (1/6)^2 = 1.056 for many blocks (Welch 1967)."""
    assert repetition(np.hanning(1001)[:-1], 500, 1000) == pytest.approx(1 + 2 / 36, rel=2e-3)
    assert repetition(np.ones(64), 64, 10) == 1


def test_what_cannot_be_is_said():
    with pytest.raises(RecordingError, match="H2 is for one input"):
        averaged(records(0, 0.1, inputs=2), 1.0, BLOCK, "boxcar", estimator="H2")
    with pytest.raises(RecordingError, match="no estimator 'H3'"):
        measured_response(records(0, 0.1), 1.0, "H3")
