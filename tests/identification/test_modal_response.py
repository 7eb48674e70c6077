import numpy as np
import pytest
from tests_support import analysed, two_hits

from twin.identification.maximum_likelihood import pack, unpack
from twin.identification.modal_response import jacobian, respond
from twin.identification.modal_start import from_poles
from twin.identification.spectra import spectrum


@pytest.fixture(scope="module")
def hit(frame):
    return analysed(frame, two_hits(), 32, 32)


def spectra_of(recording, edge=0):
    u, y = recording.matrix(recording.inputs), recording.matrix(recording.outputs)
    return spectrum(u, y, 1 / recording.sampling_hz, (0, 12.5), edge)


def test_the_band_limited_model_is_exact_for_what_an_analyser_records(frame, hit):
    s = spectra_of(hit)
    p = from_poles(frame.modes().poles, [s], "band-limited", s.omega[-1], False)
    error = s.Y - respond(p, s, 0, "band-limited", s.omega[-1])
    assert np.abs(error).max() < 1e-5 * np.abs(s.Y).max()


def test_the_held_model_is_exact_for_a_held_input(frame, held_hit):
    s = spectra_of(held_hit)
    p = from_poles(frame.modes().poles, [s], "held", s.omega[-1], False)
    error = s.Y - respond(p, s, 0, "held", s.omega[-1])
    assert np.abs(error).max() < 1e-12 * np.abs(s.Y).max()


@pytest.mark.parametrize("hold", ["band-limited", "held"])
@pytest.mark.parametrize("residual", [False, True])
def test_derivatives_agree_with_finite_differences(frame, hit, hold, residual):
    s = spectra_of(hit, edge=2)
    top = s.omega[-1]
    p = from_poles(1.01 * frame.modes().poles, [s], hold, top, residual)
    x = pack(p, residual)
    J = jacobian(p, s, 0, hold, top, residual)
    for i in range(len(x)):
        step = np.zeros_like(x)
        step[i] = 1e-6 * max(abs(x[i]), 1e-3)
        up, down = (respond(unpack(x + d, p, residual), s, 0, hold, top) for d in (step, -step))
        numeric = (up - down) / (2 * step[i])
        assert np.abs(numeric - J[:, :, i]).max() < 2e-5 * np.abs(J[:, :, i]).max(), i


def test_packing_and_unpacking_return_the_same_parameters(frame, hit):
    s = spectra_of(hit, edge=3)
    p = from_poles(frame.modes().poles, [s], "held", s.omega[-1], True)
    q = unpack(pack(p, True), p, True)
    for name in ("omega", "zeta", "psi", "participation", "D", "D2", "transient"):
        np.testing.assert_allclose(getattr(q, name), getattr(p, name), rtol=1e-12, err_msg=name)
    np.testing.assert_array_equal(q.edges[0], p.edges[0])
