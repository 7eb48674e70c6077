"""What inputs do between samples: measured forces and a motor's commands are asked for apart."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, rng, tones
from diagnosis_support import recorded as frame

from twin.diagnosis.beginning import added, likeliest, moved_to, start_of
from twin.diagnosis.between import _better, again, choose, filter_in_words, in_words
from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.explanation import seen_otherwise
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.estimation.fit import WORTH, fit
from twin.estimation.likelihood import evaluate
from twin.estimation.low_pass import LowPass
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, Hammer, run
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.damping import Damping
from twin.mechanisms.shifting import later
from twin.model import Twin
from twin.recording import Recording

RATE, FINE, SAMPLES = 64.0, 64, 1024


def recorded(seed):
    """An absorber's frame: a smooth force, a torque held for four samples, and what they do."""
    twin = Twin.load("two_storey_absorber")
    force = tones(SAMPLES * FINE, RATE * FINE, seed, 0.3)
    torque = 2e-3 * np.repeat(rng(seed).standard_normal(SAMPLES // 4), 4)
    model = twin.linear(("force_floor1", "torque_pendulum"), ("acc_floor1", "acc_floor2"))
    moved = twin.simulate(
        {"force_floor1": force, "torque_pendulum": np.repeat(torque, FINE)},
        RATE * FINE, SAMPLES * FINE,
    )  # fmt: skip
    columns = {"force_floor1": force[::FINE], "torque_pendulum": torque}
    for name in model.outputs:
        noise = 1e-3 * rng(seed + 9).standard_normal(SAMPLES)
        columns[name] = moved.column(name)[::FINE] + noise
    return Recording.build(RATE, columns, f"seed{seed}.csv")


@pytest.fixture(scope="module")
def problem():
    return prepare(Twin.load("two_storey_absorber"), [recorded(1)], [recorded(2)]).train


def test_a_command_is_held_where_the_force_is_not(problem):
    assert problem.model.inputs == ("force_floor1", "torque_pendulum")
    chosen, _ = choose(problem)
    assert chosen.between[1] == "held"
    assert chosen.between[0] != "held"
    assert "torque_pendulum taken as held from sample to sample" in in_words(chosen)


def test_a_wrong_choice_is_mended_once_the_twin_fits(problem):
    wrong = Hypothesis(replace(problem, between=("held", "linear")))
    found, fitted = again(wrong, fit(wrong))
    found, fitted = again(found, fitted)
    assert found.problem.between == choose(problem)[0].between
    same, kept = again(found, fitted)
    assert same is found
    assert kept is fitted


def test_what_is_folded_is_that_of_the_structure_that_was_found():
    """A dashpot damps the modes above the band, through which a blow is folded."""
    damped, beam = Damping("hinge3", 0.05), Twin.load("cantilever")
    test = Experiment(Hammer(0.012, 0.6), ("force_mid",), Analyser(192.0, 4.0, physics_hz=6144.0),
                      instruments={"acc": Instrument(noise_fraction=0.005)})  # fmt: skip
    blows = [run(test, beam.including(damped), seed) for seed in (1, 2)]
    problem = prepare(beam, blows[:1], blows[1:]).train
    blank = Hypothesis(problem)
    h = added(blank, Candidate((damped,), priors_of((damped,))), damped)
    found = fit(h, moved_to(h, blank, start_of(blank), damped))
    after, better = again(h, found)
    assert after.problem.folding is not None
    assert better.log_evidence > found.log_evidence
    own = prepare(beam.including(damped), blows[:1], blows[1:]).train
    (wanted,), (told,), (nominal,) = (
        [t.blur for t in p.trials] for p in (own, after.problem, problem)
    )
    assert np.sum(np.abs(told - wanted)) < 0.1 * np.sum(np.abs(nominal - wanted))
    assert again(after, better)[0].problem.folding is after.problem.folding


@pytest.mark.parametrize(("channel", "samples"), [("acc_floor1", 0.4), ("acc_floor2", 0.8)])
def test_a_channel_that_is_late_is_not_taken_for_inputs_that_are_held(channel, samples):
    late = []
    for seed, floor in ((1, "floor1"), (2, "floor2")):
        clean = frame(lumped(), seed, at=floor)
        rate = clean.sampling_hz
        columns = {name: np.array(clean.column(name)) for name in clean.names}
        columns[channel] = later(columns[channel], samples / rate, rate)
        late.append(Recording.build(rate, columns, clean.source))
    found, _ = choose(prepare(lumped(), late, [frame(lumped(), 3)]).train)
    assert set(found.between) == {"band_limited"}


def test_how_a_jump_is_seen_is_said_where_a_law_jumps(problem):
    assert filter_in_words(Hypothesis(problem)) == ()
    rubs = Hypothesis(problem, (CoulombFriction("storey1", 0.1),))
    assert "edge 0.5 of the sampling rate" in filter_in_words(rubs)[0]
    for low_pass, words in ((LowPass(0.8, 8), "Butterworth's of order 8"), (None, "follow")):
        (said,) = filter_in_words(replace(rubs, problem=replace(problem, low_pass=low_pass)))
        assert words in said


def test_only_a_law_whose_force_jumps_is_simulated_or_follows_the_motion(problem):
    rubs = Hypothesis(problem, (CoulombFriction("storey1", 0.1),))
    assert [h.problem.low_pass is None for h in seen_otherwise(rubs)] == [False, True]
    stops = Hypothesis(problem, (Bumper("storey1", 1e3, 1e-3),), ({},))
    assert seen_otherwise(stops) == (stops,)
    assert stops.blurred
    assert not stops.jumps
    both = replace(stops, mechanisms=(*rubs.mechanisms, *stops.mechanisms))
    assert len(seen_otherwise(both)) == 2


@pytest.mark.parametrize(("off", "changed"), [(0.7, False), (2.5, True)])
def test_what_a_fit_s_own_further_steps_give_is_no_gain_of_other_inputs(off, changed):
    """From so many deviations off, steps give a quarter of a nat, and three."""
    twin = lumped()
    h = Hypothesis(prepare(twin, [frame(twin, 1)], [frame(twin, 2)]).train)
    best = fit(h, start_of(h))
    z = best.z.copy()
    z[0] += off / np.sqrt(np.linalg.inv(best.covariance)[0, 0])
    short = fit(h, z, enough=100.0)
    assert best.log_posterior - short.log_posterior == pytest.approx(off**2 / 2, rel=0.02)
    chosen, _ = _better(h, short, [replace(h.problem)], 5)
    assert (chosen is not h) is changed


def test_beside_a_fit_that_ended_early_others_take_no_step():
    """They are a tenth of a nat likelier where it ended, and three after a step of either."""
    twin = lumped()
    h = Hypothesis(prepare(twin, [frame(twin, 1)], [frame(twin, 2)]).train)
    best = fit(h, start_of(h))
    z = best.z.copy()
    z[0] += 2.5 / np.sqrt(np.linalg.inv(best.covariance)[0, 0])
    short = fit(h, z, enough=100.0)
    (passed,), (recording,) = evaluate(h, z, derivatives=False).runs, h.problem.recordings
    white = np.einsum("to,op,tp->", passed.e, np.linalg.inv(passed.gains.innovation[-1]), passed.e)
    other = replace(
        h.problem, recordings=(replace(recording, y=recording.y - 0.1 / white * passed.e),)
    )
    gained = likeliest(replace(h, problem=other), [z])[0] - short.log_posterior
    assert 0.02 < gained < WORTH
    assert _better(h, short, [other], 0)[0] is h
