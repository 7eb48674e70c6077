"""Many modes from records too long for the fit of all modes at once."""

from dataclasses import replace

import numpy as np
import pytest
from wide_support import FREQ, OUTPUTS, RATE, ZETA, poles, record

from twin import shaker_test
from twin.errors import IdentificationError
from twin.identification import segment, wide_result
from twin.identification.clusters import clusters, diagram
from twin.identification.complex_frequency import denominator
from twin.identification.identify import identify
from twin.identification.records import prepare
from twin.identification.segment import segments
from twin.identification.segments import families, starting_drive
from twin.identification.separable import solve
from twin.identification.separable_terms import Drive, Terms
from twin.identification.spectra import spectrum
from twin.identification.unseen import unseen_nrmse
from twin.identification.wide_band import fit_wide, starting_poles
from twin.model import Twin
from twin.recording import Recording


def spectra(noise=0.01, samples=8192):
    found = []
    for seed in (1, 2):
        u, y = record(0, samples, noise, seed)
        found.append(replace(spectrum(u, y, 1 / RATE, (40, 700)), transient=False, from_rest=u))
    return found


def recording(seed, noise=0.01, samples=8192):
    u, y = record(0, samples, noise, seed)
    names = {"force_floor1": u[:, 0]} | {f"acc_floor{i + 1}": y[:, i] for i in range(OUTPUTS)}
    return Recording.build(RATE, names, source=f"hit {seed}")


def test_the_denominator_of_exact_data_has_the_poles_of_the_structure():
    found = denominator(spectra(0.0), 40).poles(40)
    for pole in poles():
        assert np.min(np.abs(found - pole)) < 0.01 * -pole.real


def test_the_columns_of_stable_poles_are_the_modes():
    exact = spectra(0.01)
    found = diagram(denominator(exact, 60), range(2, 61, 2), 2 * np.pi / 4)
    kept = [c for c in clusters(found, 2 * np.pi / 4) if c.orders >= 12]
    for f in FREQ:
        assert min(abs(abs(c.pole) / 2 / np.pi - f) for c in kept) < 1e-3 * f


def test_segments_hold_few_modes_and_cover_the_band():
    omega = np.arange(1.0, 40.0)
    parts = segments(omega, 0.5, 40.0, 0.01)
    assert max(np.sum(p.holds(omega)) for p in parts) <= 6
    assert sum(np.sum(p.holds(omega)) for p in parts) == len(omega)


def by_segments(monkeypatch, operations=0):
    """Few data are taken for many; all modes at once only where so many operations are allowed."""
    monkeypatch.setattr(wide_result, "DATA", 1000)
    monkeypatch.setattr(wide_result, "OPERATIONS", operations)


@pytest.mark.parametrize("operations", [0, wide_result.OPERATIONS])
def test_every_mode_is_found_and_no_other_and_the_intervals_hold(monkeypatch, operations):
    by_segments(monkeypatch, operations)
    found = identify([recording(1), recording(2)], band_hz=(40, 700))
    np.testing.assert_allclose(found.modal.natural_freq, FREQ, rtol=1e-4)
    error = found.modal.natural_freq - FREQ
    assert np.all(np.abs(error) < 4 * found.modal.natural_freq_std)
    assert np.all(np.abs(found.modal.damping_ratio - ZETA) < 4 * found.modal.damping_ratio_std)
    assert np.all(found.modal.damping_ratio_std < 0.2 * ZETA)
    assert unseen_nrmse(found, recording(3)) < 0.012
    assert found.nrmse < 0.012


def test_the_force_that_is_held_is_told_from_one_that_is_band_limited(monkeypatch):
    by_segments(monkeypatch)
    assert "input held" in identify([recording(1)], band_hz=(40, 700)).route


def test_noise_alone_gives_no_mode():
    rng = np.random.default_rng(0)
    s = spectrum(*(rng.standard_normal((8192, 2)) for _ in range(2)), 1 / RATE, (40, 700))
    with pytest.raises(IdentificationError, match=r"no mode pays|no pole stays"):
        fit_wide([s], "held", *starting_poles([s]))


def test_progress_is_told(monkeypatch):
    by_segments(monkeypatch, wide_result.OPERATIONS)
    told = []
    identify([recording(1)], band_hz=(40, 300), progress=lambda *step: told.append(step))
    steps = {"least-squares complex frequency", "refining", "all modes at once"}
    assert {what for what, _, _ in told} == steps
    assert all(1 <= step <= steps for _, step, steps in told)


def test_poles_that_share_a_bandwidth_and_a_shape_are_listed_as_one(monkeypatch):
    """A damping that falls as the motion dies away takes more than one pole and is one mode."""
    by_segments(monkeypatch)
    u, _ = record(0, 8192, 0.0, 0)
    t = np.arange(8192) / RATE
    start = 42 / RATE
    after = np.maximum(t - start, 0)
    decay = np.exp(-3 * after) + 0.5 * np.exp(-1.2 * after)
    y = np.where(t >= start, decay * np.sin(2 * np.pi * 300 * (t - start)), 0)
    y += 0.002 * np.random.default_rng(1).standard_normal(len(t))
    hit = Recording.build(RATE, {"force_floor1": u[:, 0], "acc_floor1": y}, source="hit")
    found = identify([hit], band_hz=(40, 700))
    assert len(found.modal.natural_freq) == 1
    assert found.modal.natural_freq[0] == pytest.approx(300, rel=1e-3)
    assert 1.2 < 2 * np.pi * 300 * found.modal.damping_ratio[0] < 3.3
    assert found.nrmse < 0.05


def test_a_broad_pole_between_two_resonances_does_not_make_them_one():
    """One sensor: every shape is alike, only distance parts modes."""
    omega = np.array([1000.0, 1010.0, 1020.0])
    drive = Drive(omega, np.array([1e-3, 1.2e-2, 1e-3]), np.ones((3, 1), complex), np.zeros(3, int))
    found = families(drive, np.array([[1.0, 0.5, 0.9]], complex))
    assert [list(members) for members in found] == [[0, 1], [2]]


def test_a_neighbour_keeps_its_pole():
    """It has no lines of its own in the segment and would settle on another mode's."""
    (s,) = spectra(0.01)[:1]
    terms = Terms((s,), "held", (0, 2, -2), float(s.omega[-1]))
    first = starting_drive(poles(), terms)
    here, _ = solve(first, terms, np.ones(s.Y.shape), 1e-6, 3, held=np.array([0, 9]))
    np.testing.assert_array_equal(here.omega[[0, 9]], first.omega[[0, 9]])
    assert np.all(here.omega[1:9] != first.omega[1:9])


def test_a_hit_early_in_the_record_starts_at_rest_though_the_filter_rings_before_it():
    u, y = record(0, 4096, 0.0, 0)
    u[28:40, 0] = 2 * (-1.0) ** np.arange(12)
    u, y = u[30:], y[30:]
    hit = Recording.build(RATE, {"force_floor1": u[:, 0], "acc_floor1": y[:, 0]}, source="hit")
    assert not prepare([hit]).wide_spectra((40, 700))[0].transient


def test_a_mode_close_beyond_the_band_is_felt_and_not_listed(monkeypatch):
    by_segments(monkeypatch)
    found = identify([recording(1), recording(2)], band_hz=(100, 585))
    inside = FREQ[(FREQ > 100) & (FREQ < 585)]
    np.testing.assert_allclose(found.modal.natural_freq, inside, rtol=1e-4)
    assert found.nrmse < 0.012
    assert any("beyond the band" in note for note in found.notes)


def test_noise_of_the_measured_inputs_is_known_where_the_structure_is_loud(monkeypatch):
    """A segment knows one level; a force that is measured badly is loud at the resonances."""
    shaken = shaker_test(
        "portal_3d", ("force_floor1_x", "force_floor2_y"), level_n=0.05, band_hz=(0.5, 20.0),
        rate_hz=64.0, duration_s=64.0, input_noise=0.01, seed=2,
    )  # fmt: skip
    modes = Twin.load("portal_3d").linearisation().generalised.modes()
    off = {}
    for name, operations in (("segments", 0), ("at once", wide_result.OPERATIONS)):
        by_segments(monkeypatch, operations)
        modal = identify([shaken]).modal
        error = modal.natural_freq - modes.natural_freq[:, None]
        near = np.argmin(np.abs(error), axis=1)
        error = error[np.arange(len(near)), near] / modal.natural_freq_std[near]
        off[name] = np.max(np.abs(error))
    assert len(modal.natural_freq) == len(modes.natural_freq)
    assert off["at once"] < 3.5
    assert off["segments"] > 1.5 * off["at once"]


def test_modes_do_not_depend_on_where_the_band_is_cut(monkeypatch):
    """Errors of neighbours in other segments enter a mode's own until all are fitted at once."""
    found = []
    for modes in (1, 6):
        monkeypatch.setattr(segment, "MODES", modes)
        poles, shown = starting_poles(spectra(0.05, 2048))
        found.append(fit_wide(spectra(0.05, 2048), "held", poles, shown))
    a, b = (np.array([f.omega / (2 * np.pi), f.zeta]) for f in found)
    assert a.shape == b.shape
    assert np.all(np.abs(a - b) < 0.35 * found[0].std)
