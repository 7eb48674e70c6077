from dataclasses import replace

import numpy as np
import pytest
from wide_support import FREQ, RATE, ZETA, poles, record

from twin.identification.separable import project, solve, start_drive
from twin.identification.separable_terms import Drive, Terms
from twin.identification.spectra import spectrum


def terms(noise=0.0, from_rest=True, samples=2048, band=(40, 240)):
    spectra = []
    for place in (0, 0):
        u, y = record(place, samples, noise, 3 + len(spectra))
        s = spectrum(u, y, 1 / RATE, band)
        spectra.append(replace(s, transient=not from_rest, from_rest=u if from_rest else None))
    return Terms(tuple(spectra), "held", (0, 2, -2), float(spectra[0].omega[-1]))


def inside(band=(40, 240)):
    return (band[0] < FREQ) & (band[1] > FREQ)


def drive(t, off=1e-3):
    start = poles()[inside()] * (1 + off)
    return start_drive(start, t, np.ones((len(t.Y), 1)))


@pytest.mark.parametrize("from_rest", [True, False])
@pytest.mark.parametrize("kind", ["alike", "by output", "joint"])
def test_gauss_newton_has_the_slope_of_the_cost(kind, from_rest):
    t = terms(0.01, from_rest)
    d = drive(t)
    if not from_rest:
        d = replace(d, v=d.v + 1e-4 * np.exp(1j * np.arange(d.v.size)).reshape(d.v.shape))
    rng = np.random.default_rng(0)
    lines, outputs = t.Y.shape
    weight = np.ones((lines, outputs))
    if kind == "by output":
        weight = rng.uniform(0.5, 2, (lines, outputs))
    if kind == "joint":
        weight = np.eye(outputs) + 0.2 * rng.standard_normal((lines, outputs, outputs))
    here = project(d, t, weight)
    size = np.sqrt(np.maximum(np.diag(here.gram), 1e-300)).reshape(*d.v.shape, 2)
    for index in [(0, 0, 0), (1, 0, 1), (2, 0, 0), (3, 0, 1)] + [(1, 1, 1)] * (not from_rest):
        step = np.zeros_like(size)
        step[index] = 1e-5 * np.sqrt(here.cost) / size[index]
        up, down = (project(d.moved(s * step), t, weight, False).cost for s in (1, -1))
        expected = -2 * here.right.reshape(size.shape)[index] * step[index]
        assert (up - down) / 2 == pytest.approx(expected, rel=1e-3, abs=1e-7 * here.cost)


def test_a_record_cut_off_while_it_rings_has_no_leakage_where_it_starts_at_rest():
    """The model is exact: what is left is the response above the band, which is smooth."""
    samples = 1024
    u, y = record(0, samples, 0.0, 0)
    s = replace(spectrum(u, y, 1 / RATE, (40, 700)), transient=False, from_rest=u)
    t = Terms((s,), "held", (0,), float(s.omega[-1]))
    d = start_drive(poles(), t, np.ones((len(t.Y), 1)))
    left = project(d, t, np.ones(t.Y.shape), derivative=False)
    assert left.cost < 1e-16 * np.sum(np.abs(t.Y) ** 2)


def test_poles_are_found_from_a_start_that_is_off():
    t = terms(0.0, band=(40, 700))
    start = start_drive(poles() * (1 + 2e-4), t, np.ones((len(t.Y), 1)))
    found, _ = solve(start, t, np.ones(t.Y.shape))
    np.testing.assert_allclose(found.omega / 2 / np.pi, FREQ, rtol=1e-8)
    np.testing.assert_allclose(found.zeta, ZETA, rtol=1e-5)


def test_what_a_mode_is_worth_is_what_its_absence_costs():
    t = terms(0.01)
    d = drive(t, 0.0)
    weight = np.ones(t.Y.shape)
    full = project(d, t, weight, False)
    for i in range(len(d.omega)):
        without = project(d.without(np.array([i])), t, weight, False)
        assert without.cost - full.cost == pytest.approx(full.loss[i], rel=1e-6)


def test_a_damping_ratio_stays_positive_whatever_the_step():
    d = Drive(np.ones(1), np.full(1, 1e-3), np.ones((1, 1), complex), np.zeros(1, int))
    assert d.moved(np.full((1, 1, 2), -1e6)).zeta[0] > 0
