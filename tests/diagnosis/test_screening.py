"""The shortlist: what is screened once, what is raced, and what several channels have at once."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded, rng, tones

from twin.diagnosis.adjusted import Adjusted
from twin.diagnosis.beginning import added, from_nominal, moved_to, nominal, start_of
from twin.diagnosis.candidates import Candidate, motions, priors_of, scales_of, surroundings
from twin.diagnosis.directions import directions_of, nearest
from twin.diagnosis.drawing import far_off
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.linearised import Linearised
from twin.diagnosis.pipeline import diagnose
from twin.diagnosis.prepare import prepare
from twin.diagnosis.score_test import ScoreTest
from twin.diagnosis.screening import screen
from twin.diagnosis.valleys import _nearer, of_valleys
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.base_compliance import BaseCompliance
from twin.mechanisms.clock import Clock
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.damping import Damping
from twin.mechanisms.sensor_delay import SensorDelay
from twin.mechanisms.sensor_gain import SensorGain
from twin.mechanisms.sensor_highpass import SensorHighpass
from twin.mechanisms.sensor_resonance import SensorResonance
from twin.mechanisms.stiffness import Stiffness
from twin.recording import Recording


def test_guesses_that_differ_in_strength_only_are_one_direction():
    starts = [Stiffness("storey1", x) for x in (-4.0, -1.0, 1.0, 4.0)]
    ((first, alike),) = directions_of(starts)
    assert first == starts[0]
    assert [ratio for _, ratio in alike] == pytest.approx([1.0, 0.25, -0.25, -1.0])
    ((_, gains),) = directions_of([SensorGain("acc", 0.9), SensorGain("acc", 1.2)])
    assert [g.scaled(1).gain for g, _ in gains] == [0.9, 1.2]
    assert gains[1][1] == pytest.approx(np.log(1.2) / np.log(0.9))


def test_guesses_of_another_frequency_are_another_direction():
    starts = [Appendage("floor1", m, f, 0.03) for f in (2.0, 5.0) for m in (0.1, 0.2)]
    assert [len(alike) for _, alike in directions_of(starts)] == [2, 2]
    corners = [SensorHighpass("acc", f) for f in (0.1, 0.4)]
    directions = directions_of(corners)
    for first, alike in directions:
        for start, ratio in alike:
            assert first.scaled(ratio).values == pytest.approx(start.values)


def test_mountings_of_other_frequencies_are_no_stronger_or_weaker_ones():
    mountings = [SensorResonance("acc", f) for f in np.array([6.25, 8.77, 0.5])]
    assert [len(alike) for _, alike in directions_of(mountings)] == [1, 1, 1]


def test_of_guesses_that_are_only_stronger_the_one_that_is_told_is_followed():
    masses = [Appendage("floor1", m, 5.0, 0.03) for m in (0.1, 0.5)]
    ((first, alike),) = directions_of(masses)
    assert nearest(alike, 0.8) == [first]
    assert nearest(alike, 7.0) == [masses[1]]
    assert nearest(alike, -3.0) == [first]
    delays = [SensorDelay("acc", d) for d in (-1e-3, 1e-3, 5e-3)]
    ((_, either),) = directions_of(delays)
    assert nearest(either, 2.0) == delays


def test_a_base_that_resonates_is_told_from_a_light_appendage():
    soft = lumped().including(BaseCompliance("ground", 7000.0, 3.0, 3.0, 3.0))
    found = diagnose(lumped(), [recorded(soft, 1)], [recorded(soft, 2)])
    first = found.findings[0]
    assert (first.mechanism.name, first.location) == ("base_compliance", "ground")
    assert not [f for f in found.findings if f.mechanism.name == "appendage"]


def test_a_base_that_a_calibration_stands_for_is_found_from_the_nominal_twin():
    base = BaseCompliance("ground", 500.0, 1.0, 3.0, 3.0)
    soft = lumped().including(base)
    train, test = [recorded(soft, 1), recorded(soft, 4, at="floor1")], [recorded(soft, 2)]
    blank = Hypothesis(prepare(lumped(), train, test, 0.3).train)
    calibrated = fit(blank, start_of(blank))
    assert far_off(blank.problem, calibrated.z)
    moved = motions(blank.problem, blank, calibrated.z)
    starts = BaseCompliance.starts("ground", surroundings(blank.problem, moved, "ground"))
    giving = Candidate(starts, priors_of(starts))
    runs = evaluate(blank, calibrated.z, derivatives=False).runs
    (score,) = of_valleys(calibrated, Linearised.of(blank, runs), [giving])
    true = added(blank, giving, base)
    brought = fit(true, from_nominal(true, moved_to(true, blank, calibrated.z, base)))
    assert score.gain > 0.5 * (brought.log_posterior - calibrated.log_posterior)
    assert score.start.stiffness == pytest.approx(500.0, rel=0.05)


def test_a_dashpot_that_a_calibration_stands_for_is_followed_from_where_it_is_likelier():
    damped = lumped(Damping("storey1", 3.0))
    train = [recorded(damped, 1, scale=1.0, at="floor1"), recorded(damped, 2, scale=1.0)]
    blank = Hypothesis(prepare(lumped(), train, [recorded(damped, 3)]).train)
    calibrated = fit(blank, start_of(blank))
    twice = Damping("storey1", 6.0)
    one = Candidate((twice,), {"change": (0.0, 1.0)})
    runs = evaluate(blank, calibrated.z, derivatives=False).runs
    grown, linear = added(blank, one, twice), Linearised.of(blank, runs)
    beside = moved_to(grown, blank, calibrated.z, twice)
    options = (beside, nominal(grown, beside))
    adjusted = Adjusted(linear, calibrated)
    _, begun, _ = _nearer(adjusted, calibrated, linear.beside(grown), options)
    assert np.array_equal(begun, options[1])
    few = [fit(grown, z, most=3).log_posterior for z in options]
    assert few[1] > few[0] + 100
    # slopes where the calibration stands for it would have the others adjust themselves to both
    told = [adjusted.steps(linear.beside(grown), z, 0)[0] for z in options]
    assert told[0] > told[1]
    # straight lines tell of it in two ways, and it is followed once
    moved = motions(blank.problem, blank, calibrated.z)
    starts = Damping.starts("storey1", surroundings(blank.problem, moved, "storey1"))
    followed = screen(calibrated, blank, [Candidate(starts, priors_of(starts))], moved).valleys
    assert [c.label for c in followed] == [("damping", "storey1")]


def test_a_clock_that_is_off_by_many_samples_is_found_though_no_straight_line_tells_of_it():
    wrong = Clock("acc_floor2", 3e-3)  # six samples at the end

    def slow(seed):
        r = recorded(lumped(), seed, seconds=16.0)
        columns = wrong.distort({n: r.column(n) for n in r.names}, r.sampling_hz)
        # what the recording does not reach is none of the clock's
        return Recording.build(r.sampling_hz, {n: x[:-8] for n, x in columns.items()}, r.source)

    found = diagnose(lumped(), [slow(1)], [slow(2)])
    (only,) = found.findings
    assert (only.mechanism.name, only.location) == ("clock", "acc_floor2")
    assert only.mechanism.rate == pytest.approx(3e-3, rel=1e-3)


def test_a_delay_to_which_the_twin_has_adjusted_itself_is_followed_though_its_slope_is_flat(
    monkeypatch,
):
    late = SensorDelay("acc_floor1", 5.4e-3)

    def heard(seed):
        x = recorded(lumped(), seed)
        columns = late.distort({n: x.column(n) for n in x.names}, x.sampling_hz)
        return Recording.build(x.sampling_hz, columns, x.source)

    h = Hypothesis(prepare(lumped(), [heard(1)], [heard(2)], None, 0.1, None).train)
    found = fit(h, start_of(h))
    moved = motions(h.problem, h, found.z)
    h = replace(h, scales=scales_of(h.problem, moved))
    candidates = []
    for kind, place in ((SensorDelay, "acc_floor1"), (Damping, "storey1")):
        starts = kind.starts(place, surroundings(h.problem, moved, place))
        candidates.append(Candidate(starts, priors_of(starts)))

    def flat(self, pairs):
        late = [isinstance(start, SensorDelay) for _, start in pairs]
        return [(0.0 if flat else 10.0, 1.0, np.zeros(len(self.names))) for flat in late]

    monkeypatch.setattr(ScoreTest, "along", flat)
    told = screen(found, h, candidates, moved)
    first, second = told.followed(*told.valleys, *told.hidden)
    assert first.candidate.label == ("sensor_delay", "acc_floor1")
    assert second.gain > np.log(len(candidates)), "something is unexplained"
    assert first.gain > second.gain + 100
    assert first.start.delay == pytest.approx(late.delay, rel=0.3)


def test_hum_on_all_channels_is_hum_on_all_channels():
    def humming(seed):
        r = recorded(lumped(), seed)
        columns = {n: r.column(n) for n in r.names}
        time = np.arange(r.samples) / r.sampling_hz
        for k, name in enumerate(("acc_floor1", "acc_floor2")):
            level = 0.05 * np.std(columns[name]) * np.sqrt(2)
            columns[name] = columns[name] + level * np.sin(2 * np.pi * 50.0 * time + k)
        return Recording.build(r.sampling_hz, columns, r.source)

    found = diagnose(lumped(), [humming(1)], [humming(2)])
    assert found.verdict == "measurement"
    assert {(f.mechanism.name, f.location) for f in found.findings} == {
        ("sensor_hum", "acc_floor1"),
        ("sensor_hum", "acc_floor2"),
    }


def test_a_race_on_the_first_seconds_promises_no_more_than_all_samples_bring():
    hung = lumped().including(Appendage("floor1", 0.05, 5.0, 0.03))
    fine, rate, samples = 8, 128.0, 4096
    force = tones(samples * fine, rate * fine, 1, 0.3)
    force[2 * int(rate) * fine :] = 0.0  # what follows is noise
    moved = hung.simulate({"force_floor2": force}, rate * fine, len(force)).columns
    columns = {"force_floor2": force[::fine]}
    for floor in ("floor1", "floor2"):
        clean = moved[f"acc_{floor}"][::fine]
        columns[f"acc_{floor}"] = clean + 2e-3 * rng(2).standard_normal(samples)
    blow = Recording.build(rate, columns, "blow.csv")
    problem = prepare(lumped(), [blow], [recorded(lumped(), 3)]).train
    blank = Hypothesis(problem)
    calibrated = fit(blank, start_of(blank))
    starts = tuple(Appendage("floor1", 0.04, f, 0.03) for f in (4.5, 5.2))
    hanging = Candidate(starts, priors_of(starts))
    runs = evaluate(blank, calibrated.z, derivatives=False).runs
    (score,) = of_valleys(calibrated, Linearised.of(blank, runs), [hanging])
    grown = added(blank, hanging, score.start)
    brought = fit(grown, moved_to(grown, blank, calibrated.z, score.start))
    gain = brought.log_posterior - calibrated.log_posterior
    assert 0.3 * gain < score.gain <= gain + 1.0


def test_an_effect_far_weaker_than_the_first_guess_is_promising():
    weak, guess = CubicStiffness("storey1", 2e4), CubicStiffness("storey1", 1e7)
    ready = prepare(lumped(), [recorded(lumped(weak), 1, 0.6)], [recorded(lumped(), 2)])
    h = Hypothesis(ready.train)
    fitted = fit(h, start_of(h))
    told = screen(
        fitted, h, [Candidate((guess,), priors_of([guess]))], motions(h.problem, h, fitted.z)
    )
    (score,) = told.best()
    assert not told.by_chance
    assert score.gain > 20
    assert score.start.stiffness == pytest.approx(2e4, rel=0.3)


def test_a_light_appendage_is_heard_in_all_samples_at_its_own_frequency():
    hung = lumped().including(Appendage("floor2", 5e-4, 3.1, 0.015))
    problem = prepare(lumped(), [recorded(hung, 1, seconds=40.0)], [recorded(hung, 2)]).train
    blank = Hypothesis(problem)
    fitted = fit(blank, start_of(blank))
    found = candidates_of(problem, blank, fitted)
    told = screen(fitted, *found)
    first = told.followed(*told.valleys, *told.hidden)[0]
    assert first.candidate.label == ("appendage", "floor2")
    assert first.start.frequency == pytest.approx(3.1, rel=0.03)
    assert first.start.mass == pytest.approx(5e-4, rel=0.5)


def test_what_chance_may_promise_is_told_from_what_it_may_not():
    guess = CubicStiffness("storey1", 1e7)
    for strength, chance in ((0.0, True), (2e4, False)):
        ready = prepare(
            lumped(), [recorded(lumped(CubicStiffness("storey1", strength)), 1, 0.6)],
            [recorded(lumped(), 2)],
        )  # fmt: skip
        h = Hypothesis(ready.train)
        fitted = fit(h, start_of(h))
        moved = motions(h.problem, h, fitted.z)
        base = BaseCompliance.starts("ground", surroundings(h.problem, moved, "ground"))
        candidates = [Candidate(starts, priors_of(starts)) for starts in ((guess,), base)]
        told = screen(fitted, h, candidates, moved)
        assert told.by_chance == chance
        assert bool(told.hidden) != chance, "nothing is looked for where nothing promises"


def test_each_of_many_frequencies_has_a_part_of_the_odds_of_all(monkeypatch):
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    h = Hypothesis(problem)
    fitted = fit(h, start_of(h))
    moved = motions(problem, h, fitted.z)
    gains = [(5.0, 1.0, np.zeros(len(h.unknowns)))]
    monkeypatch.setattr(ScoreTest, "along", lambda self, pairs: gains * len(pairs))
    for count, promises in ((1, True), (2, True), (400, False)):
        starts = [Appendage("floor1", 0.01, f, 0.03) for f in np.linspace(5.0, 50.0, count)]
        told = screen(fitted, h, [Candidate(tuple(starts), priors_of(starts))], moved)
        assert any(starts[0] in c.starts for c in told.valleys) == promises


def candidates_of(problem, blank, fitted):
    """The appendages at both floors, beside the fit."""
    moved = motions(problem, blank, fitted.z)
    around = {place: surroundings(problem, moved, place) for place in ("floor1", "floor2")}
    starts = [Appendage.starts(place, around[place]) for place in around]
    return (
        replace(blank, scales=scales_of(problem, moved)),
        [Candidate(s, priors_of(s)) for s in starts],
        moved,
    )


def test_a_damper_that_the_twins_own_damping_stood_for_promises_what_it_brings():
    damped = lumped().including(Damping("storey2", 2.0))
    problem = prepare(lumped(), [recorded(damped, 1)], [recorded(damped, 2)]).train
    blank = Hypothesis(problem)
    fitted = fit(blank, start_of(blank))
    moved = motions(problem, blank, fitted.z)
    here = replace(blank, scales=scales_of(problem, moved))
    starts = Damping.starts("storey2", surroundings(problem, moved, "storey2"))
    candidate = Candidate(starts, priors_of(starts))
    told = screen(fitted, here, [candidate], moved)
    (score,) = told.followed(*told.valleys, *told.hidden)
    grown = added(here, candidate, score.start)
    brought = fit(grown, moved_to(grown, here, fitted.z, score.start))
    gain = brought.log_posterior - fitted.log_posterior
    assert 0.9 * gain < score.gain <= gain + 1.0
