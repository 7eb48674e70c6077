import numpy as np
import pytest
from scipy import signal

from twin.errors import RecordingError
from twin.second_order import SecondOrderModel
from twin.signals.frf import averaged, common_period, force_window, is_transient, measured_response

RATE = 64.0


def damped_frame(damping: float = 0.05):
    """Two storeys, discrete at RATE with the force held: its FRF is known in closed form."""
    M = np.diag([0.65, 1.55])
    K = 518.6 * np.array([[2.0, -1.0], [-1.0, 1.0]])
    R = 2 * damping * 12.0 * M
    model = SecondOrderModel(M, R, K, ("floor1", "floor2"))
    return model.acceleration_response(("floor1", "floor2")).held(1 / RATE)


def single_input(system):
    return type(system)(system.A, system.B[:, :1], system.C, system.D[:, :1], system.dt)


def relative_error(response, system, lines=slice(None)):
    truth = system.frequency_response(response.frequency_hz)
    return np.abs(response.H - truth)[lines].max() / np.abs(truth[lines]).max()


def hammer(samples: int, at: int = 4) -> np.ndarray:
    u = np.zeros((samples, 1))
    u[at : at + 2, 0] = 8.0, 3.0
    return u


def test_a_hit_whose_response_dies_out_gives_the_closed_form_response():
    system = single_input(damped_frame())
    u = hammer(8192)
    response = measured_response([(u, system.simulate(u))], RATE)
    assert "force window" in response.method
    assert response.H.shape == (4097, 2, 1)
    assert relative_error(response, system) < 1e-9


def test_a_steady_multisine_gives_the_closed_form_response_once_its_first_period_is_left_out():
    system = single_input(damped_frame())
    rng = np.random.default_rng(1)
    period = 1024
    lines = np.zeros(period // 2 + 1, complex)
    lines[10:300] = np.exp(2j * np.pi * rng.random(290))
    u = np.tile(np.fft.irfft(lines, period), 6)[:, None]
    response = measured_response([(u, system.simulate(u))], RATE)
    assert response.blocks == 5
    assert "periods of 16 s" in response.method
    excited = response.excited()
    np.testing.assert_array_equal(np.flatnonzero(excited), np.arange(10, 300))
    assert relative_error(response, system, excited) < 1e-5


def test_random_excitation_gives_the_closed_form_response_within_its_variance():
    system = single_input(damped_frame(0.2))
    u = np.random.default_rng(2).standard_normal((60_000, 1))
    response = averaged([(u, system.simulate(u))], RATE, 1024, "hann", overlap=0.5)
    assert response.coherence is not None
    assert response.blocks == 116
    assert relative_error(response, system, slice(2, None)) < 0.05
    assert response.coherence[5:].min() > 0.9


def test_noise_lowers_the_coherence_to_the_share_the_input_explains():
    rng = np.random.default_rng(3)
    u = rng.standard_normal((200_000, 1))
    y = u + rng.standard_normal(u.shape)
    response = averaged([(u, y)], RATE, 256, "hann", overlap=0.5)
    assert response.coherence is not None
    assert np.mean(response.coherence[3:-3]) == pytest.approx(0.5, abs=0.01)


def test_two_inputs_are_separated_by_two_records():
    system = damped_frame()
    first, second = np.hstack([hammer(8192), np.zeros((8192, 1))]), np.zeros((8192, 2))
    second[7:9, 1] = 5.0, 2.0
    records = [(u, system.simulate(u)) for u in (first, second)]
    response = measured_response(records, RATE)
    assert response.coherence is None
    assert relative_error(response, system) < 1e-9


def test_two_random_inputs_at_once_are_separated_by_averaging():
    system = damped_frame(0.2)
    u = np.random.default_rng(4).standard_normal((60_000, 2))
    response = averaged([(u, system.simulate(u))], RATE, 1024, "hann", overlap=0.5)
    assert relative_error(response, system, slice(2, None)) < 0.05


def test_agrees_with_scipy_for_one_input():
    rng = np.random.default_rng(5)
    u, y = rng.standard_normal((4096, 1)), rng.standard_normal((4096, 1))
    response = averaged([(u, y)], RATE, 256, "hann", overlap=0.5)
    settings = {"fs": RATE, "nperseg": 256, "detrend": "constant"}
    f, S_uy = signal.csd(u[:, 0], y[:, 0], **settings)
    _, S_uu = signal.welch(u[:, 0], **settings)
    _, coherence = signal.coherence(u[:, 0], y[:, 0], **settings)
    np.testing.assert_allclose(response.frequency_hz, f)
    np.testing.assert_allclose(response.H[:, 0, 0], S_uy / S_uu, rtol=1e-9)
    assert response.coherence is not None
    np.testing.assert_allclose(response.coherence[:, 0], coherence, rtol=1e-9, atol=1e-12)


def test_shorter_records_are_filled_up_and_averaged_with_the_long_ones():
    system = single_input(damped_frame(0.2))
    records = [(u, system.simulate(u)) for u in (hammer(4096), hammer(3000, at=9))]
    response = measured_response(records, RATE)
    assert response.blocks == 2
    assert relative_error(response, system) < 1e-6


def test_fewer_blocks_than_inputs_are_refused():
    with pytest.raises(RecordingError, match=r"1 blocks of 64 samples .* 2 inputs"):
        averaged([(np.ones((64, 2)), np.ones((64, 1)))], RATE, 64, "boxcar")


def test_a_silent_input_is_refused():
    with pytest.raises(RecordingError, match="not zero throughout"):
        averaged([(np.zeros((64, 1)), np.ones((64, 1)))], RATE, 64, "boxcar")


def test_no_record_is_refused():
    with pytest.raises(RecordingError, match="at least one record"):
        measured_response([], RATE)


def test_the_force_window_keeps_the_hit_and_drops_the_noise_between():
    u = hammer(1000, at=500) + 0.05 * np.random.default_rng(6).standard_normal((1000, 1))
    kept = force_window(u)
    np.testing.assert_array_equal(kept[484:518], u[484:518])
    assert not kept[:484].any()
    assert not kept[518:].any()


def test_a_hit_is_transient_and_random_noise_or_a_sine_is_not():
    noise = np.random.default_rng(7).standard_normal((1024, 1))
    assert is_transient(hammer(1024) + 0.08 * noise)
    assert not is_transient(noise)
    assert not is_transient(np.sin(np.arange(1024.0))[:, None])
    assert not is_transient(np.zeros((1024, 1)))


@pytest.mark.parametrize(("period", "level"), [(500, 0.0), (500, 0.02), (1024, 0.02)])
def test_the_period_of_a_multisine_is_found_through_its_noise(period, level):
    rng = np.random.default_rng(8)
    lines = np.zeros(period // 2 + 1, complex)
    lines[4 : period // 20] = np.exp(2j * np.pi * rng.random(period // 20 - 4))
    u = np.tile(np.fft.irfft(lines, period), 5)[:, None]
    u += level * u.std() * rng.standard_normal(u.shape)
    assert common_period([u]) == period


def test_noise_has_no_period():
    assert common_period([np.random.default_rng(9).standard_normal((4096, 1))]) is None
    assert common_period([np.zeros((4096, 1))]) is None
