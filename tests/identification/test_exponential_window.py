"""What an exponential window adds to the damping comes off again."""

import numpy as np
import pytest
from tests_support import FS, analysed, noisy, one_hit

from twin.cli import main
from twin.errors import IdentificationError
from twin.formats import write_recording
from twin.identification.exponential_window import (
    identification_without_window,
    without_window,
)
from twin.identification.identify import identify
from twin.modal import ModalModel
from twin.recording import Recording

TAU = 6.0


@pytest.fixture(scope="module")
def windowed(frame):
    hit = noisy(analysed(frame, one_hit(), 32, 32), 0.002, 0)
    data = hit.data * np.exp(-hit.time / TAU)[:, None]
    return Recording(hit.sampling_hz, hit.channels, data, "windowed.csv")


def test_the_structures_damping_and_its_realization_come_back(frame, windowed):
    true = frame.modes()
    raw = identify([windowed])
    assert np.all(raw.modal.damping_ratio > 1.2 * true.damping_ratio)
    found = identification_without_window(raw, TAU)
    np.testing.assert_allclose(found.modal.natural_freq, true.natural_freq, rtol=1e-3)
    np.testing.assert_allclose(found.modal.damping_ratio, true.damping_ratio, rtol=0.05)
    values = np.linalg.eigvals(found.state_space.A)
    rates = np.sort(np.abs(np.log(values[values.imag > 0]) * FS)) / (2 * np.pi)
    np.testing.assert_allclose(rates, found.modal.natural_freq, rtol=1e-4)
    assert "6 s was taken off" in " ".join(found.notes)


def test_the_damped_frequency_stays():
    modal = ModalModel(np.array([1.0]), np.array([0.1]), np.ones((1, 1)), ("a",))
    left, _ = without_window(modal, 5.0)
    np.testing.assert_allclose(left.poles.imag, modal.poles.imag)
    np.testing.assert_allclose(left.poles.real, modal.poles.real + 0.2)


def test_a_window_that_was_not_used_is_refused_and_one_that_hides_a_mode_leaves_it_out():
    std = np.array([1e-5, 1e-5])
    modal = ModalModel(
        np.array([1.0, 9.0]), np.array([0.01, 0.01]), np.ones((1, 2)), ("a",), std, std
    )
    with pytest.raises(IdentificationError, match="damps more than the mode at 1 Hz"):
        without_window(modal, 1.0)
    vague = ModalModel(
        np.array([1.0, 9.0]), np.array([0.01, 0.01]), np.ones((1, 2)), ("a",), std, 1e3 * std
    )
    left, kept = without_window(vague, 15.0)
    assert list(kept) == [1]
    assert len(left.natural_freq) == 1
    with pytest.raises(IdentificationError, match="not possible"):
        without_window(modal, -1.0)


def test_the_command_takes_the_time_constant(windowed, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("twin.view.report.write_identification", lambda *_, **__: [])
    write_recording(windowed, tmp_path / "w.csv")
    with pytest.raises(SystemExit) as stop:
        main(["identify", str(tmp_path / "w.csv"), "--exponential-window", "6", "--out",
              str(tmp_path / "o")])  # fmt: skip
    assert stop.value.code == 0
    assert "was taken off" in capsys.readouterr().out
