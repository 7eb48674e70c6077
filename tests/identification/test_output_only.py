"""Modes from responses alone."""

import json

import numpy as np
import pytest
from scipy import signal
from tests_support import FS

from twin.cli import main
from twin.errors import IdentificationError
from twin.formats import write_recording
from twin.identification.output_only import covariances, identify_output_only
from twin.modal import mac
from twin.recording import Recording


def shaken(frame, seed=0, seconds=2000, noise=0.02):
    """The frame under white forces on both floors that nobody measures."""
    model = frame.acceleration_response(("floor1", "floor2"))
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((int(seconds * FS), 2))
    y = model.held(1 / FS).simulate(u)
    y += noise * y.std(axis=0) * rng.standard_normal(y.shape)
    return Recording.build(FS, {"acc_floor1": y[:, 0], "acc_floor2": y[:, 1]}, source="wind.csv")


@pytest.fixture(scope="module")
def recording(frame):
    return shaken(frame)


def test_frequencies_damping_and_shapes_without_scale(frame, recording):
    found = identify_output_only([recording])
    true = frame.modes()
    np.testing.assert_allclose(found.modal.natural_freq, true.natural_freq, rtol=2e-3)
    np.testing.assert_allclose(found.modal.damping_ratio, true.damping_ratio, rtol=0.3)
    assert np.all(np.diag(mac(found.modal.mode_shape, true.mode_shape)) > 0.999)
    assert any("no scale" in note for note in found.notes)


def test_the_intervals_hold_the_truth(frame):
    """Six records, two modes, two numbers each: the error in deviations has mean square one."""
    true = frame.modes()
    errors = []
    for seed in range(6):
        modal = identify_output_only([shaken(frame, seed, 600)]).modal
        assert len(modal.natural_freq) == 2
        errors.append((modal.natural_freq - true.natural_freq) / modal.natural_freq_std)
        errors.append((modal.damping_ratio - true.damping_ratio) / modal.damping_ratio_std)
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.6
    assert np.mean(np.abs(errors) < 2.1) > 0.8


def test_covariances_are_those_of_a_plain_sum():
    y = np.random.default_rng(0).standard_normal((100, 2))
    sums, counts = covariances([y], 5, 30)
    assert counts.sum() == 95
    for lag in (0, 3):
        plain = y[lag : 95 + lag].T @ y[:95]
        np.testing.assert_allclose(sums.sum(axis=0)[lag], plain, atol=1e-9)


def test_noise_alone_has_no_modes():
    y = np.random.default_rng(0).standard_normal((20000, 2))
    quiet = Recording.build(FS, {"acc_floor1": y[:, 0], "acc_floor2": y[:, 1]}, source="noise.csv")
    with pytest.raises(IdentificationError, match=r"noise\.csv: no pole stays"):
        identify_output_only([quiet])


def test_a_record_sampled_much_faster_than_its_band_is_slowed(frame, recording):
    y = signal.resample_poly(recording.data, 8, 1, axis=0)
    fast = Recording.build(
        8 * FS, {"acc_floor1": y[:, 0], "acc_floor2": y[:, 1]}, source="fast.csv"
    )
    found = identify_output_only([fast], band_hz=(0.5, 12))
    np.testing.assert_allclose(found.modal.natural_freq, frame.modes().natural_freq, rtol=2e-3)


def test_the_command_needs_no_input(recording, tmp_path, capsys):
    write_recording(recording, tmp_path / "wind.csv")
    with pytest.raises(SystemExit) as stop:
        main(["identify", str(tmp_path / "wind.csv"), "--out", str(tmp_path / "o"), "--json", "-"])
    assert stop.value.code == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["modes"]) == 2
    assert found["inputs"] == []


def test_a_force_that_does_not_move_is_no_reason_to_do_without(recording, tmp_path, capsys):
    y = {n: recording.column(n) for n in recording.names}
    still = Recording.build(FS, y | {"force_floor1": np.ones(recording.samples)}, source="x")
    write_recording(still, tmp_path / "still.csv")
    with pytest.raises(SystemExit) as stop:
        main(["identify", str(tmp_path / "still.csv"), "--out", str(tmp_path / "o")])
    assert stop.value.code == 2
    assert "constant" in capsys.readouterr().err
