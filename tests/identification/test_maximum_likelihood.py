import numpy as np
import pytest
from tests_support import analysed, noisy, one_hit, random_force

from twin.errors import IdentificationError
from twin.estimation.noise import NoiseLevels, covariance, fit_noise, whitener
from twin.identification.maximum_likelihood import fit_modal
from twin.identification.records import prepare

DRAWS = 40


def fits_of(recording, start, draws=DRAWS, share=0.01):
    found = []
    for seed in range(draws):
        spectra = prepare([noisy(recording, share, seed)]).spectra(None, edges=True)
        found.append(fit_modal(spectra, start, "band-limited"))
    return found


@pytest.mark.parametrize("force", [one_hit, random_force], ids=["hammer", "shaker"])
def test_errors_reach_the_cramer_rao_bound_that_is_stated(frame, force):
    true = frame.modes()
    fits = fits_of(analysed(frame, force(), 32, 32), true.poles * 1.002)
    for name, exact in (("omega", true.natural_freq), ("zeta", true.damping_ratio)):
        values = np.array([getattr(f.parameters, name) for f in fits])
        if name == "omega":
            values = values / (2 * np.pi)
        stated = np.mean([f.modal_std(bound=True)[name == "zeta"] for f in fits], axis=0)
        ratio = np.sqrt(np.mean((values - exact) ** 2, axis=0)) / stated
        # 40 draws know a standard deviation within 11 %; four times that on either side.
        assert np.all(ratio < 1.45), (name, ratio)
        assert np.all(ratio > 0.55), (name, ratio)


def test_both_noise_levels_are_found(frame):
    recording = analysed(frame, random_force(), 32, 64)
    fits = fits_of(recording, frame.modes().poles, draws=10)
    level = 0.01 * np.sqrt(np.mean(recording.data**2, axis=0))
    found_input = np.sqrt(np.mean([f.noise.input for f in fits]))
    found_output = np.sqrt(np.mean([f.noise.output for f in fits], axis=0))
    assert found_input == pytest.approx(level[0], rel=0.15)
    np.testing.assert_allclose(found_output, level[1:], rtol=0.1)


def test_a_residual_larger_than_the_noise_widens_the_standard_deviation(frame):
    # A second resonance beside the first, which a model with two modes cannot hold.
    recording = analysed(frame, one_hit(), 32, 32)
    t = recording.time - 0.5
    ghost = np.where(t > 0, np.exp(-0.15 * t) * np.sin(2 * np.pi * 1.96 * t), 0)
    data = recording.data + 0.05 * np.outer(ghost, [0, 1, 1])
    other = type(recording)(32.0, recording.channels, data)
    spectra = prepare([noisy(other, 0.001, 0)]).spectra(None, edges=True)
    fit = fit_modal(spectra, frame.modes().poles, "band-limited")
    assert fit.modal_std()[0][0] > 1.5 * fit.modal_std(bound=True)[0][0]


def test_more_unknowns_than_data_are_refused(frame):
    recording = analysed(frame, one_hit(), 32, 2)
    spectra = prepare([recording]).spectra((1, 3), edges=False)
    with pytest.raises(IdentificationError, match="too many for"):
        fit_modal(spectra, frame.modes().poles, "band-limited")


def test_whitening_turns_the_noise_covariance_into_the_unit_matrix():
    rng = np.random.default_rng(0)
    G = rng.standard_normal((7, 3, 2)) + 1j * rng.standard_normal((7, 3, 2))
    C = covariance(NoiseLevels(np.array([1.0, 2, 3]), np.array([0.5, 0.1])), G)
    W = whitener(C)
    np.testing.assert_allclose(
        W @ C @ W.conj().transpose(0, 2, 1), np.broadcast_to(np.eye(3), C.shape), atol=1e-12
    )


def test_noise_levels_are_those_the_residual_was_made_with():
    rng = np.random.default_rng(1)
    k = 4000

    def complex_noise(*shape):
        return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)

    G = 10 * complex_noise(k, 2, 1)
    U = complex_noise(k, 1)
    e = complex_noise(k, 2) * [0.1, 0.2] - np.einsum("kmr,kr->km", G, 0.05 * complex_noise(k, 1))
    noise = fit_noise([e], [G], [U], 0)
    np.testing.assert_allclose(np.sqrt(noise.output), [0.1, 0.2], rtol=0.1)
    assert np.sqrt(noise.input[0]) == pytest.approx(0.05, rel=0.1)
