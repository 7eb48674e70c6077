import numpy as np
import pytest

from twin.control.outcome import Outcome


def outcome(displacement, **other):
    steps = len(displacement)
    given = {
        "rate_hz": 1.0,
        "physics_hz": 2.0,
        "switch_s": steps / 4,
        "floors": ("floor1",),
        "displacement": np.reshape(displacement, (-1, 1)),
        "angle": np.zeros(steps),
        "known_input": "force_floor1",
        "excitation": np.zeros(steps),
        "channels": (),
        "measured": np.zeros((steps // 2, 0)),
        "torque": np.zeros(steps // 2),
        "estimates": (),
        "estimated": np.zeros((steps // 2, 0)),
        "qpos": np.zeros((steps // 2, 1)),
    }
    return Outcome(**{**given, **other})


def test_reductions_are_those_of_equation_60():
    found = outcome([1, -10, 4, 8, -6, 5, 1, 2]).reduction
    assert found.whole["floor1"] == pytest.approx(1 - 6 / 10)
    assert found.steady["floor1"] == pytest.approx(1 - 2 / 8)
    assert found.rms["floor1"] == pytest.approx(1 - np.sqrt(5 / 80))


def test_swing_counts_from_the_switch_on():
    angle = np.array([3.0, 0, 0, 0, -0.5, 0.2, 0, 0])
    found = outcome(np.ones(8), angle=angle)
    assert found.peak_swing_rad == 0.5
    assert not found.notes


def test_a_swing_beyond_the_horizontal_is_noted():
    angle = np.array([0.0, 0, 0, 0, -2.0, 0.2, 0, 0])
    assert "swung to 2.00 rad" in outcome(np.ones(8), angle=angle).notes[0]
