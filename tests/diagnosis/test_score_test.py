"""The score test against fits, and what needs no race."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.diagnosis.score_test import ScoreTest
from twin.estimation.fit import fit
from twin.estimation.likelihood import gaussian
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.sensor_swap import SensorSwap


def candidate(*starts):
    return Candidate(starts, priors_of(starts))


def score_of(*mechanisms):
    train = [recorded(lumped(), seed) for seed in (1, 2)]
    if mechanisms:
        train = [swapped(r) for r in train]
    problem = prepare(lumped(), train, [recorded(lumped(), 3)]).train
    blank = Hypothesis(problem)
    return ScoreTest(blank, fit(blank))


def swapped(recording):
    data = np.array(recording.data)
    first, second = (recording.names.index(f"acc_floor{i}") for i in (1, 2))
    data[:, [first, second]] = data[:, [second, first]]
    return replace(recording, data=data)


@pytest.fixture(scope="module")
def sound():
    return score_of()


def test_gains_are_those_of_least_squares_with_the_priors_as_rows(sound):
    draw = np.random.default_rng(1)
    shapes = [run.e.shape for run in sound.runs]
    changes = [draw.standard_normal((*shape, 3)) for shape in shapes]
    found = sound.of_changes(lambda i, some: changes[i][..., some], 3)

    unknowns = sound.hypothesis.unknowns
    shared = [i for i, u in enumerate(unknowns) if u.role != "noise"]
    rows, w, d = [np.eye(len(shared))], [sound.fit.z[shared]], [np.zeros((len(shared), 3))]
    for index, run in enumerate(sound.runs):
        part = gaussian(run, sound.hypothesis.trials[index])
        own = [i for i, u in enumerate(unknowns) if u.trial in (None, index)]
        rows.append(part.whitened(run.de[:, :, [own.index(i) for i in shared]]))
        w.append(part.white.ravel())
        d.append(part.whitened(changes[index]))
    J, w, d = np.vstack(rows), np.concatenate(w), np.vstack(d)
    for column in range(3):
        both = np.column_stack([J, d[:, column]])
        step, *_ = np.linalg.lstsq(both, -w, rcond=None)
        alone, *_ = np.linalg.lstsq(J, -w, rcond=None)
        gain = 0.5 * (np.sum((w + J @ alone) ** 2) - np.sum((w + both @ step) ** 2))
        assert found[0][column] == pytest.approx(gain, abs=1e-6)
        assert found[1][column] == pytest.approx(step[-1], rel=1e-4, abs=1e-9)
        assert step[-1] * found[2][:, column] == pytest.approx(step[:-1] - alone, abs=1e-7)


def test_a_change_that_the_twin_itself_can_make_promises_nothing(sound):
    own = [run.de[:, :, :1] for run in sound.runs]
    gains, _, _ = sound.of_changes(lambda i, some: 1e3 * own[i], 1)
    assert gains[0] < 1.0


def test_a_gain_promises_what_its_fit_brings():
    sound = score_of()
    start = SensorGain("acc_floor1", 1.02)
    ((gain, _, _),) = sound.along([(candidate(start), start)])
    grown = replace(sound.hypothesis, mechanisms=(start,), priors=(priors_of([start]),))
    brought = fit(grown).log_posterior - sound.fit.log_posterior
    assert gain == pytest.approx(brought, abs=1.0)


def test_a_swap_is_worth_a_race_only_where_channels_are_swapped(sound):
    swap = SensorSwap("acc_floor1+acc_floor2")
    assert sound.whole(candidate(swap), swap) < 0
    assert score_of(swap).whole(candidate(swap), swap) > 100.0


def test_freeing_a_parameter_promises_what_least_squares_with_a_second_one_bring(sound):
    unknowns = sound.hypothesis.unknowns
    shared = [i for i, u in enumerate(unknowns) if u.role != "noise"]
    rows, w = [np.eye(len(shared))], [sound.fit.z[shared]]
    for index, run in enumerate(sound.runs):
        part = gaussian(run, sound.hypothesis.trials[index])
        own = [i for i, u in enumerate(unknowns) if u.trial in (None, index)]
        rows.append(part.whitened(run.de[:, :, [own.index(i) for i in shared]]))
        w.append(part.white.ravel())
    J, w, wide = np.vstack([*rows, np.zeros(len(shared))]), np.concatenate([*w, [0.0]]), 12.0
    alone, *_ = np.linalg.lstsq(J, -w, rcond=None)
    for free in range(len(shared)):
        second = J[:, free].copy()
        second[free], second[-1] = 0.0, 1 / wide
        both = np.column_stack([J, second])
        step, *_ = np.linalg.lstsq(both, -w, rcond=None)
        gain = 0.5 * (np.sum((w + J @ alone) ** 2) - np.sum((w + both @ step) ** 2))
        found = sound.freed(unknowns[shared[free]].name, wide)
        assert found[0] == pytest.approx(gain, rel=1e-3, abs=1e-6)
        assert found[1] == pytest.approx(step[-1], rel=1e-3, abs=1e-6)
        assert step[-1] * found[2] == pytest.approx(step[:-1] - alone, rel=1e-3, abs=1e-5)


def test_a_law_beside_a_stop_puts_another_discrepancy_there():
    stop, spring = Bumper("storey2", 300.0, 5e-3), CubicStiffness("storey2", 1e4)
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    scales = Scales({"storey2": (1.0, 1e-3, 0.05)})
    alone = Hypothesis(problem, (stop,), (priors_of([stop]),), scales)
    score = ScoreTest(alone, fit(alone))
    assert "discrepancy storey2 share" in score.names
    assert np.isfinite(score.whole(candidate(spring), spring))
