"""Flexible beams: statics exact, dynamics against Hermitian beam elements with axial load."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

from twin.frame import FrameDesign, Storey
from twin.model import Twin

STOREYS = (Storey(0.65), Storey(1.55))
WEIGHTLESS = tuple(replace(storey, beam_density=1e-3) for storey in STOREYS)


def frequencies(**design):
    twin = Twin.of(FrameDesign(**design))
    return twin.linearisation().undamped_modes().natural_freq


def beam_elements(gravity, count=16):
    """Frequencies [Hz] of Euler-Bernoulli beams with level rods; consistent mass, axial load."""
    size = 2 * (2 * count + 1)
    M, K = np.zeros((size, size)), np.zeros((size, size))
    for number, s in enumerate(STOREYS):
        h = s.beam_length / count
        EJ, line = 2 * s.young_modulus * s.second_moment, s.beams_mass / s.beam_length
        bend = [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
        mass = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
        axial = [[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]
        turn = np.outer([1, h, 1, h], [1, h, 1, h])
        for e in range(count):
            carried = sum(q.floor_mass for q in STOREYS[number:]) + line * h * (count - e - 0.5)
            carried += sum(q.beams_mass for q in STOREYS[number + 1 :])
            i = 2 * (number * count + e)
            part = np.s_[i : i + 4, i : i + 4]
            K[part] += turn * (
                EJ / h**3 * np.array(bend) - carried * gravity / (30 * h) * np.array(axial)
            )
            M[part] += turn * line * h / 420 * np.array(mass)
        M[i + 2, i + 2] += s.floor_mass
    level = [2 * count + 1, 4 * count + 1]
    free = np.setdiff1d(np.arange(2, size), level)
    omega2 = linalg.eigh(K[np.ix_(free, free)], M[np.ix_(free, free)], eigvals_only=True)
    return np.sqrt(omega2) / (2 * np.pi)


@pytest.mark.parametrize(
    ("kind", "segments"),
    [("pseudo_rigid", 8), *[("hinge_chain", n) for n in (2, 3, 5, 8, 20)]],
)
def test_static_stiffness_is_that_of_clamped_beams_whatever_the_hinges(kind, segments):
    k = STOREYS[0].stiffness
    frame = Twin.of(FrameDesign(STOREYS, kind, segments, gravity=0.0))
    np.testing.assert_allclose(frame.second_order().K, [[2 * k, -k], [-k, k]], rtol=1e-9)


@pytest.mark.parametrize("kind", ["pseudo_rigid", "hinge_chain"])
def test_a_frame_pushed_slowly_leans_by_force_over_stiffness(kind):
    twin = Twin.of(FrameDesign((Storey(),), kind, 4, gravity=0.0, damping_ratio=(0.7,)))
    push = 0.01 * np.clip(np.arange(800) / 400, 0, 1)
    drift = twin.simulate({"force_floor1": push}, 100, 800).columns["disp_floor1"][-1]
    assert drift == pytest.approx(0.01 / Storey().stiffness, rel=1e-4)


def test_p_delta_alone_moves_the_lumped_frequencies_to_1_799_and_6_239_hz():
    assert frequencies(storeys=WEIGHTLESS) == pytest.approx([1.799, 6.239], abs=5e-4)


def test_weightless_beams_without_gravity_are_the_lumped_frame():
    lumped = frequencies(kind="lumped")
    assert frequencies(storeys=WEIGHTLESS, gravity=0.0) == pytest.approx(lumped, rel=1e-7)


def test_beam_elements_have_1_884_and_6_249_hz_without_and_1_723_and_5_771_hz_with_gravity():
    assert beam_elements(0.0)[:2] == pytest.approx([1.884, 6.249], abs=5e-4)
    assert beam_elements(9.81)[:2] == pytest.approx([1.723, 5.771], abs=5e-4)


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_pseudo_rigid_storeys_have_the_frequencies_of_the_beams_within_0_06_percent(gravity):
    found = frequencies(gravity=gravity)
    assert found == pytest.approx(beam_elements(gravity)[:2], rel=6e-4)


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_a_hinge_chain_converges_monotonically_and_with_second_order_to_the_beams(gravity):
    true = beam_elements(gravity)[:3]
    found = [frequencies(kind="hinge_chain", segments=n, gravity=gravity)[:3] for n in (4, 8, 16)]
    error = np.abs(np.array(found) - true)
    assert np.all(error[1:] < error[:-1])
    limit = (4 * found[2] - found[1]) / 3
    np.testing.assert_allclose(limit[:2], true[:2], rtol=2e-5)
    np.testing.assert_allclose(limit[2], true[2], rtol=2e-3)
    np.testing.assert_allclose(error[1, :2] / error[2, :2], 4, rtol=0.1)


def test_floors_stay_level():
    twin = Twin.load("two_storey")
    motion = twin.simulate({"force_floor2": np.full(500, 1.0)}, 250, 500)
    hinges = motion.qpos.reshape(500, 2, 2)
    assert np.abs(hinges).max() > 0.01
    assert np.abs(hinges.sum(axis=2)).max() < 1e-4 * np.abs(hinges).max()
