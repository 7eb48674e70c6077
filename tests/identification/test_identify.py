import numpy as np
import pytest
from tests_support import analysed, noisy, one_hit, random_force, two_hits

from twin.errors import IdentificationError, RecordingError
from twin.identification.identify import identify
from twin.identification.unseen import unseen_nrmse
from twin.recording import Recording


@pytest.fixture(scope="module")
def exact(held_hit):
    return identify([held_hit])


@pytest.fixture(scope="module")
def hammer(frame):
    return identify([noisy(analysed(frame, one_hit(), 32, 32), 0.01, 0)])


def test_held_noise_free_data_give_the_modes_back(frame, exact):
    true = frame.modes()
    assert exact.order == 4
    np.testing.assert_allclose(exact.modal.natural_freq, true.natural_freq, rtol=1e-10)
    np.testing.assert_allclose(exact.modal.damping_ratio, true.damping_ratio, rtol=1e-8)


def test_held_noise_free_data_give_mass_and_stiffness_back_by_equation_41(frame, exact):
    np.testing.assert_allclose(exact.second_order.M, frame.M, atol=1e-8 * frame.M.max())
    np.testing.assert_allclose(exact.second_order.K, frame.K, atol=1e-8 * frame.K.max())
    np.testing.assert_allclose(exact.second_order.R, frame.R, atol=1e-6 * frame.R.max())


def test_the_realization_repeats_held_noise_free_data(held_hit, exact):
    y = exact.state_space.simulate(held_hit.matrix(exact.inputs))
    assert np.abs(y - held_hit.matrix(exact.outputs)).max() < 1e-10
    assert exact.nrmse < 1e-10


def test_the_observer_of_the_realization_is_stable(exact):
    A, G, C = exact.state_space.A, exact.state_space.G, exact.state_space.C
    assert np.abs(np.linalg.eigvals(A + G @ C)).max() < 1


def test_a_hit_shorter_than_a_sample_is_identified_within_its_intervals(frame, hammer):
    true = frame.modes()
    modal = hammer.modal
    assert "band-limited" in hammer.route
    assert np.all(np.abs(modal.natural_freq - true.natural_freq) < 4 * modal.natural_freq_std)
    assert np.all(np.abs(modal.damping_ratio - true.damping_ratio) < 4 * modal.damping_ratio_std)
    np.testing.assert_allclose(np.diag(hammer.second_order.M), np.diag(frame.M), rtol=0.02)


def test_a_held_input_is_recognised_in_noise(held_hit):
    assert "held" in identify([noisy(held_hit, 0.01, 1)]).route


@pytest.mark.parametrize("place", ["floor1", "floor2"])
def test_mass_and_stiffness_come_from_a_hit_on_any_floor(frame, place):
    found = identify([analysed(frame, one_hit(place), 32, 32)]).second_order
    np.testing.assert_allclose(found.M, frame.M, atol=2e-3 * frame.M.max())
    np.testing.assert_allclose(found.K, frame.K, atol=2e-3 * frame.K.max())


def test_two_shakers_at_once_are_identified_together(frame):
    forces = random_force("floor1", 1) | random_force("floor2", 2)
    found = identify([noisy(analysed(frame, forces, 32, 32), 0.002, 0)])
    assert found.inputs == ("force_floor1", "force_floor2")
    np.testing.assert_allclose(found.modal.natural_freq, frame.modes().natural_freq, rtol=1e-3)
    np.testing.assert_allclose(found.second_order.K, frame.K, atol=0.02 * frame.K.max())


def test_hits_on_different_floors_are_one_problem(frame):
    hits = [noisy(analysed(frame, one_hit(f"floor{i}"), 32, 32), 0.01, i) for i in (1, 2)]
    both, one = identify(hits), identify(hits[:1])
    assert both.inputs == ("force_floor1", "force_floor2")
    assert np.all(both.modal.natural_freq_std < one.modal.natural_freq_std)
    assert len(both.predicted) == 2


def test_ground_acceleration_gives_modes_but_no_masses(frame):
    # Seen from the ground, a_g acts as the force -m a_g; absolute acceleration adds a_g again.
    forces = random_force("floor1", 3)
    a_g = forces["force_floor1"]
    pushed = {"force_floor1": -0.65 * a_g, "force_floor2": -1.55 * a_g}
    relative = analysed(frame, pushed, 32, 32)
    ground = analysed(frame, {"force_floor1": a_g}, 32, 32).column("force_floor1")
    table = Recording.build(
        32.0,
        {
            "acc_ground": ground,
            "acc_floor1": relative.column("acc_floor1") + ground,
            "acc_floor2": relative.column("acc_floor2") + ground,
        },
    )
    found = identify([noisy(table, 0.005, 0)])
    np.testing.assert_allclose(found.modal.natural_freq, frame.modes().natural_freq, rtol=1e-3)
    assert found.second_order is None
    assert any("driving point" in note for note in found.notes)


def test_an_order_by_hand_is_kept(frame):
    found = identify([noisy(analysed(frame, two_hits(), 32, 32), 0.01, 0)], order=2)
    assert found.order == 2
    assert found.second_order is None


def test_an_unseen_recording_is_explained_down_to_its_noise(frame, hammer):
    other = noisy(analysed(frame, two_hits(), 32, 32), 0.01, 7)
    assert unseen_nrmse(hammer, other) == pytest.approx(0.01, rel=0.3)


def test_proportional_damping_is_that_of_the_modes(frame, exact):
    omega = 2 * np.pi * frame.modes().natural_freq
    np.testing.assert_allclose(
        exact.alpha / (2 * omega) + exact.beta * omega / 2, [0.0118, 0.0039], rtol=1e-8
    )


def test_a_recording_without_excitation_is_refused(held_hit):
    still = held_hit.select(("acc_floor1", "acc_floor2"))
    with pytest.raises(IdentificationError, match="no input moves"):
        identify([still])


def test_a_constant_force_is_refused(held_hit):
    data = held_hit.data.copy()
    data[:, 0] = 3.0
    with pytest.raises(IdentificationError, match="constant"):
        identify([Recording(32.0, held_hit.channels, data)])


def test_a_dead_channel_is_left_out_and_named(held_hit):
    data = held_hit.data.copy()
    data[:, 2] = 0.0
    found = identify([Recording(32.0, held_hit.channels, data)])
    assert found.outputs == ("acc_floor1",)
    assert "acc_floor2 never moves and was left out" in found.notes


def test_a_recording_whose_outputs_are_all_dead_is_refused(held_hit):
    data = held_hit.data.copy()
    data[:, 1:] = 1.0
    with pytest.raises(IdentificationError, match="'acc_floor1' is constant"):
        identify([Recording(32.0, held_hit.channels, data)])


@pytest.mark.parametrize("scale", [1e-300, 1e150])
def test_absurd_scales_are_refused_with_the_channel(held_hit, scale):
    with pytest.raises(IdentificationError, match=r"'force_floor1' peaks at .* check its unit"):
        identify([Recording(32.0, held_hit.channels, held_hit.data * scale)])


def test_a_single_enormous_outlier_ends_in_a_result_or_one_clear_error(held_hit):
    data = noisy(held_hit, 0.01, 0).data.copy()
    data[500, 1] = 1e6
    message, freq = "", np.array([np.nan])
    try:
        freq = identify(
            [Recording(32.0, held_hit.channels, data, "outlier.csv")]
        ).modal.natural_freq
    except IdentificationError as error:
        message = str(error)
    assert "outlier.csv" in message or np.all(np.isfinite(freq))


def test_an_unknown_input_lists_the_channels(held_hit):
    with pytest.raises(RecordingError, match=r"no channel 'force_floor9'; it has force_floor1"):
        identify([held_hit], inputs=["force_floor9"])


def test_a_channel_cannot_drive_and_respond(held_hit):
    with pytest.raises(IdentificationError, match="'force_floor1' is named twice"):
        identify([held_hit], outputs=["acc_floor1", "force_floor1"])


def test_the_spread_of_mass_and_stiffness_is_stated_and_true(frame):
    hits = [noisy(analysed(frame, one_hit(), 32, 32), 0.01, seed) for seed in range(12)]
    found = [identify([hit]) for hit in hits]
    off = np.array([f.second_order.K - frame.K for f in found])
    stated = np.mean([f.second_order_std.K for f in found], axis=0)
    ratio = np.sqrt(np.mean(off**2, axis=0)) / stated
    # 12 draws know a standard deviation within 20 %.
    assert np.all((ratio > 0.4) & (ratio < 1.8)), ratio


def test_different_rates_are_refused_with_the_remedy(held_hit):
    other = Recording(64.0, held_hit.channels, held_hit.data)
    with pytest.raises(RecordingError, match=r"64 Hz .* 32 Hz; convert one with --resample"):
        identify([held_hit, other])


def test_too_few_samples_are_refused(held_hit):
    with pytest.raises(IdentificationError, match="20 samples are too few"):
        identify([held_hit.trim(0, 20)])


def test_an_order_beyond_the_data_is_refused(held_hit):
    with pytest.raises(IdentificationError, match="order of 40 is not possible"):
        identify([held_hit], order=40)
