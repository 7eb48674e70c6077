"""Large motion of the user's own model is no missing physics."""

from dataclasses import replace

import numpy as np

from twin import hammer_test
from twin.diagnosis.beginning import added, likeliest, moved_to, start_of
from twin.diagnosis.between import again, choose, motion_in_words
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import nrmse, predictors
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import WORTH, fit
from twin.estimation.likelihood import passes
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.model import Twin
from twin.model.free_run import free_run
from twin.recording import Recording


def hits(peak):
    """Blows on a frame of hinges, which leans by up to 0.02 rad at 20 N."""
    return [hammer_test("two_storey", peak_n=peak, seed=seed) for seed in range(2)]


def evidence(problem):
    """Evidence of the nominal model within its tolerances [nat]."""
    blank = Hypothesis(problem)
    return fit(blank, start_of(blank)).log_evidence


def test_a_frame_hit_hard_is_itself_where_linear_equations_would_bend_it():
    ready = prepare(Twin.load("two_storey"), hits(20.0)[:1], hits(20.0)[1:])
    assert ready.train.geometry is not None
    assert evidence(ready.train) > evidence(replace(ready.train, large=False)) + 20


def test_a_frame_hit_gently_needs_no_geometry():
    ready = prepare(Twin.load("two_storey"), hits(0.5)[:1], hits(0.5)[1:])
    assert ready.train.geometry is None


def test_a_free_run_needs_no_output_to_bend_as_mujoco_does():
    first, second = hits(20.0)
    ready = prepare(Twin.load("two_storey"), [first], [second])
    [test] = ready.test.recordings
    deaf = replace(test, geometric=None)  # what was measured of the motion is not told
    blank = Hypothesis(replace(ready.test, recordings=(deaf,)))
    [beside] = predictors(blank, start_of(blank))
    measured = second.matrix(ready.test.model.outputs)
    assert nrmse([measured], [beside.from_rest()]) < 0.013
    flat = Hypothesis(replace(ready.test, large=False))
    [linear] = predictors(flat, start_of(flat))
    assert nrmse([measured], [linear.from_rest()]) > 0.025


def linear(recording):
    """What a structure of the same masses and springs does that moves on straight lines, noisy."""
    model = prepare(Twin.load("two_storey"), [recording], hits(20.0)[1:]).train.model
    u = recording.matrix(model.inputs)
    y = free_run(model, u, recording.sampling_hz)
    noise = 0.003 * np.std(y) * np.random.default_rng(1).standard_normal(y.shape)
    columns = dict(zip((*model.inputs, *model.outputs), np.hstack([u, y + noise]).T, strict=True))
    return Recording.build(recording.sampling_hz, columns, "linear.csv")


def test_a_structure_that_moves_far_on_straight_lines_is_taken_as_it_moves():
    first, second = hits(20.0)
    ready = prepare(Twin.load("two_storey"), [linear(first)], [second])
    problem = ready.train
    assert problem.geometry is not None
    chosen, z = choose(problem)
    assert chosen.geometry is None
    # a calibration that goes on from the one without large motion ends there as well
    begun, there = choose(problem, ready.known)
    assert begun.geometry is None
    (first_end, _), (end, _) = (likeliest(Hypothesis(chosen), [at]) for at in (z, there))
    assert abs(first_end - end) < WORTH
    assert motion_in_words(problem) == ()
    assert "linear in its geometry" in motion_in_words(chosen)[0]
    ready = prepare(Twin.load("two_storey"), [first], [second])
    kept, _ = choose(ready.train, ready.known)
    assert kept.geometry is not None
    assert motion_in_words(kept) == ()


def shaken(seed, twin=None, level=0.15):
    """A portal shaken sideways, whose floors turn by up to 0.01 rad."""
    twin = twin or Twin.load("portal_3d")
    rate, fine, rng = 128.0, 8, np.random.default_rng(seed)
    time = np.arange(1536 * fine) / (rate * fine)
    waves = [np.cos(2 * np.pi * f * time + rng.uniform(0, 6.3)) for f in np.linspace(0.5, 12, 100)]
    ground = level * np.sum(waves, axis=0) * np.minimum(time, 1.0)
    moved = twin.simulate({}, rate * fine, len(ground), {"y": ground})
    names = [f"acc_floor{i}_{end}.{axis}" for i in (1, 2) for end in "ab" for axis in "xy"]
    columns = {f"{name} [m/s^2]": moved.column(name)[::fine] for name in names}
    columns = {n: x + 1e-3 * np.std(x) * rng.standard_normal(len(x)) for n, x in columns.items()}
    columns["acc_ground.y [m/s^2]"] = ground[::fine]
    return Recording.build(rate, columns, f"shaken{seed}.csv")


def test_a_structure_of_unknown_numbers_that_is_shaken_far_is_no_other_model():
    # what identifies such numbers simulates linear equations; what they leave out is said
    unknown = prepare(Twin.load("portal_3d"), [shaken(1)], [shaken(2)], 1.0, 1.0)
    assert unknown.simulated
    assert any("too far for linear equations" in note for note in unknown.notes)
    known = prepare(Twin.load("portal_3d"), [shaken(1)], [shaken(2)])
    assert known.train.geometry is not None
    assert not any("too far" in note for note in known.notes)


def test_motion_that_is_hardly_read_is_that_of_the_calibrated_twin():
    # sideways shaking hardly moves it along; of slow motion there accelerations tell nothing
    problem, z = choose(prepare(Twin.load("portal_3d"), [shaken(1)], [shaken(2)]).train)
    assert problem.geometry is not None
    blank = Hypothesis(problem)
    deviations = dict(zip((u.name for u in blank.unknowns), z, strict=True))
    own = {name: x for name, x in deviations.items() if name.startswith(("stiffness", "mass"))}
    assert max(abs(x) for x in own.values()) < 1.0


def test_what_a_law_accelerates_has_turned_as_well():
    cubic = CubicStiffness("storey1_column1_y", 3e6)
    hardened = Twin.load("portal_3d").including(cubic)
    first, second = (shaken(seed, hardened, 0.08) for seed in (1, 2))
    problem, z = choose(prepare(Twin.load("portal_3d"), [first], [second]).train)
    blank = Hypothesis(problem)
    scales = scales_of(problem, motions(problem, blank, z))
    grown = added(replace(blank, scales=scales), Candidate((cubic,), priors_of((cubic,))), cubic)
    begin = moved_to(grown, blank, z, cubic)  # but for the noise that stood for the law
    begin = np.where([u.role == "noise" for u in grown.unknowns], 0.0, begin)
    hypothesis, found = again(grown, fit(grown, begin))
    assert hypothesis.problem.geometry is not None
    for run in passes(hypothesis, found.z, found.averages):
        white = run.e / np.sqrt(np.diagonal(run.gains.innovation[-1]))
        late, early = white[1:], white[:-1]
        along = [np.corrcoef(a, b)[0, 1] for a, b in zip(late.T, early.T, strict=True)]
        assert np.max(np.abs(along)) < 0.15
