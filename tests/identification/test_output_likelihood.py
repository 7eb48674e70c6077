"""Likelihood of modes from responses alone, near their resonances."""

import numpy as np
import pytest

from twin.identification.output_likelihood import (
    ALONE,
    REACH,
    expected,
    groups,
    lines,
    refine,
)
from twin.identification.output_refined import refined
from twin.modal import ModalModel

RATE = 20.0


def poles_of(frequency_hz, damping):
    w, zeta = 2 * np.pi * np.asarray(frequency_hz), np.asarray(damping)
    return w * (-zeta + 1j * np.sqrt(1 - zeta**2))


def coordinates(frequency_hz, damping, rng, samples, forces=None, noise=0.02):
    """Displacements of modes under white forces, from their steady state, with noise."""
    found = []
    for k, pole in enumerate(poles_of(frequency_hz, damping)):
        freq = np.fft.rfftfreq(8 * samples, 1 / RATE)
        s = 2j * np.pi * freq
        f = rng.standard_normal(8 * samples) if forces is None else forces[k]
        q = np.fft.irfft(np.fft.rfft(f) / ((s - pole) * (s - pole.conj())), 8 * samples)
        found.append(q[-samples:])
    q = np.column_stack(found)
    return q + noise * q.std(axis=0) * rng.standard_normal(q.shape)


def test_a_short_record_smears_its_resonance_as_its_covariances_say():
    samples, pole = 1200, poles_of([1.0], [0.01])
    freq = np.fft.rfftfreq(64 * samples, 1 / RATE)
    endless = np.abs(1 / ((2j * np.pi * freq - pole) * (2j * np.pi * freq - pole.conj()))) ** 2
    covariance = np.fft.irfft(endless)
    lag = np.minimum(np.arange(64 * samples), np.arange(64 * samples, 0, -1))
    seen = np.fft.rfft(covariance * np.maximum(1 - lag / samples, 0)).real
    near = np.abs(freq - 1) < 0.2
    got = expected(
        2 * np.pi * freq[near], samples / RATE, pole, 0, np.ones((1, 1), complex), np.zeros(1)
    )
    np.testing.assert_allclose(got[:, 0, 0].real, seen[near], rtol=0.01)
    assert np.abs(endless[near] / seen[near] - 1).max() > 0.2


def test_the_lines_used_hold_the_stated_share_of_what_is_known_of_damping():
    def known(reach):
        w, zeta = 2 * np.pi, 0.002
        omega = np.linspace(w * (1 - reach * zeta), w * (1 + reach * zeta), 20001)
        size = np.zeros((3, len(omega)))
        for i, step in enumerate(1e-5 * np.eye(3)):
            ends = []
            for t in (step, -step):
                pole = poles_of(np.exp([t[0]]), zeta * np.exp([t[1]]))
                s = 1j * omega
                ends.append(t[2] - 2 * np.log(np.abs((s - pole) * (s - pole.conj()))))
            size[i] = (ends[0] - ends[1]) / 2e-5
        return 1 / np.linalg.inv(size @ size.T * (omega[1] - omega[0]))[1, 1]

    # Without end: what 200 half bandwidths lack falls as their reciprocal.
    all_of_it = 2 * known(200) - known(100)
    assert known(REACH) / all_of_it == pytest.approx(0.85, abs=0.01)
    assert known(ALONE) / all_of_it == pytest.approx(0.52, abs=0.01)


def test_errors_are_those_stated():
    frequency, damping = np.array([1.5]), np.array([0.01])
    scores = []
    for seed in range(40):
        q = coordinates(frequency, damping, np.random.default_rng(seed), 6000)
        ((_, band),) = groups(frequency, damping)
        found = refine(lines([q], RATE, band), frequency * 1.002, damping * 1.6, 0)
        scores.append([
            (found.frequency_hz[0] - 1.5) / found.std[0, 0],
            (found.damping[0] - 0.01) / found.std[1, 0],
        ])  # fmt: skip
    rms = np.sqrt(np.mean(np.square(scores), axis=0))
    # 40 draws know a deviation to 11 %.
    assert np.all((rms > 0.7) & (rms < 1.3))


def test_two_close_modes_of_one_force_are_told_apart():
    frequency, damping = np.array([1.5, 1.56]), np.array([0.01, 0.012])
    rng = np.random.default_rng(5)
    force = rng.standard_normal(8 * 20000)
    q = coordinates(frequency, damping, rng, 20000, forces=[force, force])
    ((members, band),) = groups(frequency, damping)
    assert members == [0, 1]
    found = refine(lines([q], RATE, band), frequency, damping * 1.5, 0)
    assert np.all(np.abs(found.frequency_hz - frequency) < 3 * found.std[0])
    assert np.all(np.abs(found.damping - damping) < 3 * found.std[1])
    assert np.all(found.std[1] < 0.15 * damping)


def test_bands_end_halfway_to_the_next_mode():
    frequency = np.array([1.0, 1.3, 5.0])
    found = groups(frequency, np.full(3, 0.01))
    assert [members for members, _ in found] == [[0], [1], [2]]
    assert found[0][1] == pytest.approx((1 - 0.2, 1.15))
    assert found[1][1] == pytest.approx((1.15, 1.3 + 0.26))
    assert found[2][1] == pytest.approx((4.0, 6.0))


def test_too_few_outputs_for_a_group_leave_its_modes_as_they_are():
    frequency, damping = np.array([1.5, 1.52]), np.array([0.01, 0.01])
    modal = ModalModel(frequency, damping, np.ones((1, 2)), ("a",), 0.01 * frequency, 0.1 * damping)
    y = coordinates(frequency, damping, np.random.default_rng(0), 4000).sum(axis=1)
    found, likeliest = refined(modal, [y[:, None]], RATE, 0)
    np.testing.assert_array_equal(found.natural_freq, frequency)
    assert not likeliest.any()
