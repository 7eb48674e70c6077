"""Projection where noise levels are constant over runs of lines."""

from dataclasses import replace

import numpy as np
import pytest
from wide_support import FREQ, RATE, poles, record

from twin.identification.piecewise import by_runs, runs
from twin.identification.separable import project, start_drive
from twin.identification.separable_terms import Terms
from twin.identification.spectra import spectrum


def stepped(lines, outputs, seed=0):
    """Three runs of lines, the first and the last of one weight, of other levels by output."""
    levels = np.random.default_rng(seed).uniform(0.2, 5, (2, outputs))
    return levels[(np.arange(lines) // (lines // 3 + 1)) % 2]


def test_lines_of_one_weight_are_one_run_wherever_they_stand():
    weight = stepped(30, 3)
    found = runs(weight)
    assert len(found) == 2
    assert sorted(np.concatenate([r.rows for r in found])) == list(range(30))
    for run in found:
        np.testing.assert_array_equal(weight[run.rows], np.tile(run.weight, (len(run.rows), 1)))


@pytest.mark.parametrize("derivative", [False, True])
def test_products_shared_by_outputs_give_what_a_decomposition_for_every_output_gives(derivative):
    u, y = record(0, 2048, 0.01, 3)
    s = replace(spectrum(u, y, 1 / RATE, (40, 240)), transient=True)
    terms = Terms((s,), "held", (0, 2, -2), float(s.omega[-1]))
    inside = (FREQ > 40) & (FREQ < 240)
    drive = start_drive(poles()[inside] * (1 + 1e-4), terms, np.ones((len(s.Y), 1)))
    weight = stepped(*s.Y.shape)
    # Weights that differ from line to line, if by nothing that counts, share no products.
    uneven = weight * (1 + 1e-13 * np.arange(len(weight))[:, None])
    found = project(drive, terms, weight, derivative)
    expected = project(drive, terms, uneven, derivative)
    names = ["cost", "psi", "direct", "error", "loss"] + ["gram", "right"] * derivative
    for name in names:
        a, b = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(a, b, rtol=1e-7, atol=1e-8 * np.abs(b).max())


def test_regressors_that_nearly_depend_are_left_to_orthogonal_factors():
    rng = np.random.default_rng(1)
    Phi = rng.standard_normal((60, 3)) + 0j
    Phi[:, 2] = Phi[:, 1] * (1 + 1e-8)
    u, y = record(0, 2048, 0.01, 3)
    s = spectrum(u, y, 1 / RATE, (40, 240))
    terms = Terms((s,), "held", (0,), float(s.omega[-1]))
    drive = start_drive(poles()[:1], terms, np.ones((len(s.Y), 1)))
    Y = rng.standard_normal((60, 2)) + 0j
    assert by_runs(drive, Y, Phi, None, stepped(60, 2), np.array([0])) is None
    assert by_runs(drive, Y, Phi[:, :2], None, stepped(60, 2), np.array([0])) is not None
