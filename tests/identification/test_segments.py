"""Segments: what is taken off, what another mode covers, and the input's two behaviours."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from wide_support import RATE, poles, record

from twin.identification import wide_result
from twin.identification.additions import without_what_another_covers
from twin.identification.holds import converted
from twin.identification.identify import identify
from twin.identification.segment import Segment
from twin.identification.segments import starting_drive, without
from twin.identification.separable import project, reanchored
from twin.identification.separable_terms import Drive, Terms
from twin.identification.spectra import spectrum
from twin.recording import Recording


@pytest.fixture
def exact():
    u, y = record(0, 8192, 0.0, 1)
    s = replace(spectrum(u, y, 1 / RATE, (40, 700)), transient=False, from_rest=u)
    return Terms((s,), "held", (0, 2, -2), float(s.omega[-1]))


def test_modes_are_taken_off_with_their_leakage(exact):
    drive = starting_drive(poles(), exact)
    psi = project(drive, exact, np.ones(exact.Y.shape), derivative=False).psi
    left = without(exact, drive, psi)
    assert np.linalg.norm(left.Y) < 1e-5 * np.linalg.norm(exact.Y)
    some = np.array([0, 3])
    rest = np.delete(np.arange(len(drive.omega)), some)
    part = without(without(exact, drive.only(some), psi[:, some]), drive.only(rest), psi[:, rest])
    np.testing.assert_allclose(part.Y, left.Y, atol=1e-9 * np.abs(exact.Y).max())


def test_the_drive_of_the_other_behaviour_has_the_same_modes_and_leads_back(exact):
    drive = starting_drive(poles(), exact)
    other = replace(exact, hold="band-limited")
    there = converted(drive, exact, other)
    back = converted(there, other, exact)
    np.testing.assert_allclose(back.v, drive.v, rtol=1e-12)
    np.testing.assert_array_equal(there.poles, drive.poles)


def test_a_double_of_a_mode_goes_and_two_close_modes_stay():
    u, y = record(0, 8192, 0.01, 1)
    s = replace(spectrum(u, y, 1 / RATE, (120, 145)), transient=False, from_rest=u)
    own = Terms((s,), "held", (0, 2, -2), float(s.omega[-1]))
    segment = Segment(float(s.omega[0]), float(s.omega[-1]) + 1)
    pair = starting_drive(poles()[2:4], own)
    double = Drive(
        np.append(pair.omega, pair.omega[0] * (1 + 1e-4)), np.append(pair.zeta, pair.zeta[0]),
        np.vstack([pair.v, pair.v[:1]]), np.append(pair.anchor, pair.anchor[0]),
    )  # fmt: skip
    floor = np.full(own.Y.shape[1], 1e-30)
    kept = without_what_another_covers(double, segment, own, floor)
    np.testing.assert_allclose(np.sort(kept.omega), np.abs(poles()[2:4]), rtol=1e-4)
    assert len(without_what_another_covers(pair, segment, own, floor).omega) == 2


def test_random_forces_and_far_modes_leave_no_bias(monkeypatch):
    """What far modes leak into a segment is no polynomial of the input."""
    monkeypatch.setattr(wide_result, "DATA", 1000)
    omega = 2 * np.pi * np.linspace(50, 680, 16)
    zeta = np.full(16, 0.003)
    shapes = np.random.default_rng(3).standard_normal((4, 16))
    errors = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        u = rng.standard_normal(8192)
        y = np.zeros((8192, 4))
        for i, pole in enumerate(omega * (-zeta + 1j * np.sqrt(1 - zeta**2))):
            x = signal.lfilter([0, 1], [1, -np.exp(pole / RATE)], u.astype(complex))
            y += np.real(np.outer(1j * x, shapes[:, i]))
        y += 0.01 * y.std(axis=0) * rng.standard_normal(y.shape)
        columns = {"force_floor1": u} | {f"acc_floor{o + 1}": y[:, o] for o in range(4)}
        hit = Recording.build(RATE, columns, source="shaken")
        modal = identify([hit], band_hz=(40, 700)).modal
        assert len(modal.natural_freq) == 16
        errors.append((modal.natural_freq - omega / (2 * np.pi)) / modal.natural_freq_std)
    assert np.sqrt(np.mean(np.square(errors))) < 1.3


def test_a_component_that_hardly_moves_a_mode_is_no_measure_for_the_others(exact):
    drive = starting_drive(poles(), exact)
    small = drive.v * np.array([1e-3])
    wrong = replace(drive, v=np.hstack([drive.v, small])[:, ::-1])
    both = replace(exact, spectra=tuple(replace(s, U=np.hstack([s.U, s.U])[:, ::-1],
                                                from_rest=np.hstack([s.from_rest] * 2))
                                        for s in exact.spectra))  # fmt: skip
    found = reanchored(replace(wrong, v=wrong.v / wrong.v[:, :1]), both)
    assert np.all(found.anchor == 1)
    np.testing.assert_allclose(found.v[:, 1], 1)
    np.testing.assert_allclose(found.v[:, 0], 1e-3)
