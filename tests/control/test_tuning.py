from dataclasses import replace

import numpy as np
import pytest

from twin.control.loop import spectral_radius
from twin.control.plant import frame_frequencies
from twin.control.study import Settings
from twin.control.tuning import (
    Limits,
    Trial,
    candidates,
    evaluate,
    front,
    identity,
    pick,
    robustness,
    trials,
    worst_reduction,
)
from twin.control.uncertainty import Uncertainty
from twin.control.weights import Weights
from twin.errors import ControlError


def result(reduction, swing, torque, p5=1.0):
    return {
        "stable": 1.0,
        "reduction": reduction,
        "reduction_p5": p5,
        "worst_reduction": reduction,
        "worst_swing_rad": swing,
        "worst_torque_nm": torque,
    }


def test_draws_scale_storeys_and_floors_alone(believed):
    rng = np.random.default_rng(0)
    s, drift = believed.structure, np.array([[1.0, 0, 0], [-1, 1, 0], [0, 0, 1]])
    for _ in range(20):
        drawn = Uncertainty(0.05).drawn(believed, rng).structure
        storeys = [
            np.linalg.solve(drift.T, np.linalg.solve(drift.T, m.K).T).diagonal() for m in (drawn, s)
        ]
        ratio = storeys[0] / storeys[1]
        assert np.abs(ratio[:2] - 1).max() <= 0.05 + 1e-12
        assert ratio[2] == pytest.approx(1.0)
        mass = drawn.M.diagonal() / s.M.diagonal()
        assert np.abs(mass[:2] - 1).max() <= 0.05 + 1e-12
        assert mass[2] == pytest.approx(1.0)
        assert np.array_equal(drawn.R, s.R)
    assert not np.allclose(ratio[:2], 1, atol=1e-3)


def test_draws_on_a_free_ground_keep_rigid_motion_free(absorber_twin):
    from twin.control.plant import Plant

    model = Plant(absorber_twin, "force_ground").linear()
    s = model.structure
    together = np.array([float(name != "pendulum") for name in s.coordinates])
    drawn = Uncertainty(0.05).drawn(model, np.random.default_rng(1)).structure
    assert together @ drawn.K @ together == pytest.approx(together @ s.K @ together)
    assert np.allclose(drawn.K, drawn.K.T)


def test_the_stated_covariance_spreads_frequencies(believed):
    rng = np.random.default_rng(2)
    drawn = [Uncertainty(0.0, 0.01, 0.1).drawn(believed, rng) for _ in range(300)]
    first = np.array([frame_frequencies(m.structure)[1] for m in drawn])
    assert first.std() / first.mean() == pytest.approx(0.01, rel=0.15)


def test_candidates_are_the_same_for_the_same_seed_and_begin_with_the_base():
    base = Settings()
    first, again, other = (candidates(9, seed, base) for seed in (0, 0, 1))
    assert first == again
    assert first != other
    assert first[0] == base
    assert len(set(first)) == 9


def test_a_campaigns_identity_tells_it_from_others(believed, floor_plant):
    one, same, other = (
        identity(trials(candidates(3, seed, Settings()), believed, floor_plant, Uncertainty(), 0))
        for seed in (0, 0, 1)
    )
    assert one == same != other


def test_the_front_keeps_what_nothing_beats():
    results = {
        "a": result(0.9, 0.5, 0.3),
        "b": result(0.9, 0.6, 0.3),
        "c": result(0.8, 0.2, 0.4),
        "d": result(0.7, 0.3, 0.1),
        "e": {"stable": 0.5},
    }
    assert front(results) == ("a", "c", "d")


def test_the_pick_is_the_best_to_be_relied_on_within_the_limits():
    results = {
        "reckless": result(0.99, 0.9, 0.3),
        "fragile": result(0.97, 0.5, 0.3, p5=0.4),
        "sound": result(0.95, 0.5, 0.3),
        "weak": result(0.6, 0.1, 0.1),
    }
    assert pick(results, Limits(0.8, 0.5)) == "sound"
    assert pick(results, Limits(0.2, 0.5)) == "weak"


def test_limits_that_nothing_meets_are_told_with_what_is_missing():
    results = {"a": result(0.9, 0.5, 0.3), "b": result(0.9, 0.25, 0.4)}
    with pytest.raises(ControlError, match=r"swings 0\.25 rad, 0\.05 more than 0\.2$"):
        pick(results, Limits(0.2, 0.5))
    with pytest.raises(ControlError, match=r"0\.2 more than 0\.1"):
        pick({"a": result(0.9, 0.5, 0.3)}, Limits(0.8, 0.1))
    with pytest.raises(ControlError, match="the best is for 50%"):
        pick({"a": {"stable": 0.5}, "b": {"stable": 0.25}}, Limits())


def test_the_default_controller_stands_its_uncertainty(believed, floor_plant):
    found = evaluate(Trial(Settings(), believed, floor_plant, Uncertainty(), draws=10))
    assert found["stable"] == 1.0
    assert found["reduction_p5"] > 0.9
    assert found["worst_reduction"] >= 0.9
    assert found["worst_swing_rad"] < 0.8


def test_a_controller_that_stands_no_delay_is_not_simulated(believed, floor_plant):
    eager = replace(Settings(), weights=Weights(velocity=10.0, torque=1e-5), extra_delay=0.0)
    trial = Trial(eager, believed, floor_plant, Uncertainty(), draws=5)
    found = evaluate(trial)
    assert found["stable"] < 1
    assert "reduction" not in found
    controller = eager.design(believed, 1)
    share, reductions = robustness(controller, trial)
    assert share == found["stable"]
    late = spectral_radius(controller, believed, 2)
    assert (worst_reduction(controller, believed, 2) == -1) == (late >= 1)
    assert late >= 1
    assert reductions.min() == -1


@pytest.mark.parametrize("name", ["swing_rad", "torque_nm"])
def test_limits_are_positive(name):
    with pytest.raises(ControlError, match=name):
        Limits(**{name: 0.0})


def test_settings_survive_json():
    settings = replace(Settings(), weights=Weights(velocity=0.7), ramp_s=3.0)
    assert Settings.from_json(settings.as_json()) == settings
    with pytest.raises(ControlError, match="no settings of a controller"):
        Settings.from_json({"weights": {}})
    with pytest.raises(ControlError, match="no settings of a controller"):
        Settings.from_json({**settings.as_json(), "speed": 1.0})
