"""A mode just above the analysed band is felt inside it: what it biases, and what is said of it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg
from tests_support import FS, analysed, noisy, random_force

from twin.identification import choice
from twin.identification.as_json import as_json
from twin.identification.discrete import realize
from twin.identification.identify import identify
from twin.identification.maximum_likelihood import fit_modal
from twin.identification.outside import with_pole_outside
from twin.identification.records import prepare
from twin.second_order import SecondOrderModel

STIFFNESS = 500.0
MASS = 0.65
DAMPING = 0.006
NOISE = 0.002
BAND = (0.5, 6.8)
"""Two of the column's modes, at 1.96 and 5.50 Hz, lie inside, the third, at 7.95 Hz, 17 % above."""


@pytest.fixture(scope="module")
def column() -> SecondOrderModel:
    """Three equal storeys, every mode damped alike."""
    M = MASS * np.eye(3)
    K = STIFFNESS * np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    square, shapes = linalg.eigh(K, M)
    R = M @ shapes @ np.diag(2 * DAMPING * np.sqrt(square)) @ shapes.T @ M
    return SecondOrderModel(M, R, K, ("floor1", "floor2", "floor3"))


@pytest.fixture(scope="module")
def clean(column):
    """Shaken at the first floor up to 12 Hz; the third has no sensor."""
    whole = analysed(column, random_force("floor1", 1), 32, 32)
    return whole.select(("force_floor1", "acc_floor1", "acc_floor2"))


@pytest.fixture(scope="module")
def found(clean):
    return identify([noisy(clean, NOISE, 0)], band_hz=BAND)


@pytest.fixture(scope="module")
def without(clean):
    """The same without a pole above the band."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(choice, "with_pole_outside", lambda fit, spectra: fit)
        return identify([noisy(clean, NOISE, 0)], band_hz=BAND)


def test_a_mode_above_the_band_biases_those_inside_unless_it_has_a_pole(clean, column, monkeypatch):
    true = column.modes()
    unseen = identify([clean], band_hz=BAND).modal
    monkeypatch.setattr(choice, "with_pole_outside", lambda fit, spectra: fit)
    missed = identify([clean], band_hz=BAND).modal
    for name in ("natural_freq", "damping_ratio"):
        error, bias = (np.abs(getattr(m, name) - getattr(true, name)[:2]) for m in (unseen, missed))
        assert np.all(bias > 100 * error), (name, bias, error)


def test_the_pole_above_the_band_explains_what_the_quadratic_term_leaves(found, without):
    assert without.nrmse > 10 * NOISE
    assert found.nrmse < 1.5 * NOISE


def test_the_pole_above_the_band_is_part_of_the_model_and_not_of_the_list(found, column):
    true = column.modes().natural_freq
    np.testing.assert_allclose(found.modal.natural_freq, true[:2], rtol=1e-4)
    assert len(found.natural_freq_bound) == len(found.damping_ratio_bound) == 2
    assert found.fit.outside == 1
    assert found.fit.parameters.omega[-1] / (2 * np.pi) == pytest.approx(true[2], rel=0.01)
    assert found.state_space.A.shape == (6, 6)
    assert found.order == 6
    assert len(as_json(found)["modes"]) == 2
    said = [note for note in found.notes if "felt inside it, but not measured" in note]
    assert len(said) == 1
    assert said[0].startswith("poles at 7.9")
    assert "(order 4)" in " ".join(found.notes)
    assert not any(note.startswith("warning") for note in found.notes)


def test_the_observer_leaves_the_pole_above_the_band_alone_and_is_stable(found):
    A, G, C = found.state_space.A, found.state_space.G, found.state_space.C
    assert np.all(G[:4] != 0)
    assert np.all(G[4:] == 0)
    assert np.abs(np.linalg.eigvals(A + G @ C)).max() < 1


def test_a_pole_above_half_the_sampling_rate_is_in_no_realization(found):
    p = found.fit.parameters
    above = replace(p, omega=np.append(p.omega[:2], 1.3 * np.pi * FS))
    pairs = prepare(found.recordings).pairs
    realized = realize(replace(found.fit, parameters=above), pairs, 1 / FS, None)
    assert realized.A.shape == (4, 4)


def test_masses_and_stiffnesses_are_those_of_the_measured_modes(found, without, column):
    _, shapes = linalg.eigh(column.K, column.M)
    seen = shapes[:2, :2]
    M = np.linalg.inv(seen @ seen.T)
    np.testing.assert_allclose(found.second_order.M, M, atol=0.01 * M.max())
    assert found.second_order_std is not None
    # With the flank in D the residues look like those of no structure at all.
    assert without.second_order_std is None


def test_no_pole_is_added_where_nothing_lies_above_the_band(frame):
    spectra = prepare([noisy(analysed(frame, random_force(), 32, 32), 0.01, 0)]).spectra(None, True)
    fit = fit_modal(spectra, frame.modes().poles, "band-limited")
    assert with_pole_outside(fit, spectra) is fit


def test_an_order_by_hand_holds_no_pole_above_the_band(clean):
    assert identify([noisy(clean, NOISE, 0)], order=6, band_hz=BAND).fit.outside == 0
