"""A channel that is late is read as it was, whatever the inputs do between samples."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.mending import mended
from twin.diagnosis.prepare import prepare
from twin.diagnosis.trials import trial_of
from twin.mechanisms.clock import Clock
from twin.mechanisms.sensor_delay import SensorDelay
from twin.model.free_run import free_run

FINER, MARGIN = 32, 60


@pytest.fixture(scope="module")
def straight():
    """A problem with inputs that are straight between samples, and its outputs on a finer grid."""
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    samples = 1500
    u = np.zeros((samples, len(problem.model.inputs)))
    u[:, 0] = np.random.default_rng(4).standard_normal(samples)
    times = np.arange(samples * FINER) / FINER
    fine = np.column_stack([np.interp(times, np.arange(samples), x) for x in u.T])
    return (
        replace(problem, between=("linear",) * len(problem.model.inputs)),
        u,
        free_run(problem.model, fine, FINER * problem.sampling_hz),
    )


def recording_of(problem, u, y):
    return replace(problem, recordings=(replace(problem.recordings[0], u=u, y=y),))


@pytest.mark.parametrize("late", [5, 37, -11])
def test_a_late_channel_is_shifted_with_its_corners(straight, late):
    problem, u, fine = straight
    true = fine[::FINER]
    column = problem.model.outputs.index("acc_floor2")
    y = true.copy()
    y[:, column] = np.roll(fine[:, column], late)[::FINER]
    fault = SensorDelay("acc_floor2", late / FINER / problem.sampling_hz)
    errors = []
    for between in ("linear", "band_limited"):
        told = replace(recording_of(problem, u, y), between=(between,) * len(problem.between))
        (trial,) = mended(told, [fault])
        error = (trial.y - true)[MARGIN:-MARGIN]
        errors.append(np.max(np.abs(error)) / np.std(true[:, column]))
    assert errors[0] < 2e-3
    assert errors[1] > 20 * errors[0]


@pytest.mark.parametrize("samples", [3.2, -3.2])
def test_what_is_hidden_moves_with_a_late_channel_and_stays_hidden_where_it_was(straight, samples):
    problem, u, fine = straight
    y = fine[::FINER].copy()
    column = problem.model.outputs.index("acc_floor2")
    y[700:760] = np.nan
    fault = SensorDelay("acc_floor2", samples / problem.sampling_hz)
    (trial,) = mended(recording_of(problem, u, y), [fault])
    gone = np.flatnonzero(np.isnan(trial.y[:1400, column]))
    # a late reading belongs to an earlier time
    assert (gone[0], gone[-1]) == ((696, 759) if samples > 0 else (700, 763))
    assert len(gone) == 64
    others = np.delete(trial.y[:1400], column, axis=1)
    assert np.array_equal(np.flatnonzero(np.isnan(others).any(axis=1)), np.arange(700, 760))


def test_a_clock_gains_with_the_time():
    clock = Clock("acc_floor2", 1e-3)
    assert clock.moment(np.array([0.0, 10.0])) == pytest.approx([0.0, 10.01])


def test_a_fault_of_outputs_leaves_what_the_inputs_do():
    """The recording is read again, its inputs as they are; one of an input is read anew."""
    train = [recorded(lumped(), seed) for seed in (1, 3)]
    problem = prepare(lumped(), train, [recorded(lumped(), 2)]).train
    problem = replace(problem, between=("band_limited",) * len(problem.model.inputs))
    fault = SensorDelay("acc_floor2", 0.3 / problem.sampling_hz)
    for recording, before, trial in zip(
        problem.recordings, problem.trials, mended(problem, [fault]), strict=True
    ):
        assert trial.u is before.u
        assert np.any(before.missed)
        names = dict(zip(problem.model.outputs, recording.y.T, strict=True))
        y = np.column_stack([*fault.undo(names, problem.sampling_hz).values()])
        anew = trial_of(problem, recording, recording.u, y)
        assert trial.y == pytest.approx(anew.y, nan_ok=True, abs=1e-12)
        assert trial.missed == pytest.approx(anew.missed)
    (moved, *_) = mended(problem, [SensorDelay("force_floor2", 0.3 / problem.sampling_hz)])
    assert not np.allclose(moved.u, problem.trials[0].u)
