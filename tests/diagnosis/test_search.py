"""The search on rigs with one thing concealed: found where it is, or said not to be known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_support import TWO, concealed, exact_trial, lumped, recorded

from twin import mechanisms
from twin.diagnosis import search as searching
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.evidence import probabilities
from twin.diagnosis.fitting import fit
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.predict import from_rest, nrmse
from twin.diagnosis.prepare import prepare
from twin.diagnosis.rig import heights_of
from twin.diagnosis.search import search
from twin.diagnosis.stage import Stage
from twin.diagnosis.unnamed import _outdone

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")  # as the command line does

ALL = mechanisms.vocabulary()
SECONDS = 8.0


def searched(make, most=1):
    """What a search finds in two recordings, and a third one to try it on."""
    records = [make(seed) for seed in (1, 2, 3)]
    ready = prepare(lumped(), records[:2], records[2:])
    base = base_hypothesis(ready.train.model)
    return search(ready.train, base, heights_of(ready.twin), most), ready.test


def errors(found, test):
    """Free-run errors on an unseen recording: of the model as it was, and with what was found."""
    return [
        nrmse(test.trials, from_rest(test, hypothesis, found.best.slack))
        for hypothesis in (Hypothesis((), ()), found.best.hypothesis)
    ]


def test_where_nothing_is_concealed_nothing_is_found():
    found, test = searched(lambda seed: recorded(lumped(), seed, 0.6, SECONDS), most=3)
    assert found.best is found.nothing
    assert found.best.hypothesis.found == ()
    assert found.named is None
    assert len(found.stages) == 1
    assert errors(found, test)[1] < 0.003


CONCEALED = [
    (ALL["coulomb_friction"]("storey2", 0.05), {"force": 0.02}, 0.02),
    (ALL["bumper"]("storey2", 2000.0, 0.004), {"stiffness": 0.02, "gap": 0.01}, 0.02),
    # a gain: what is lost may be the weight above as well
    (ALL["stiffness"]("storey1", 40.0), {"change": 0.02}, 0.003),
]


@pytest.mark.parametrize(
    ("mechanism", "allowed", "reached"), CONCEALED, ids=[m.name for m, _, _ in CONCEALED]
)
def test_what_is_concealed_is_found_at_its_place(mechanism, allowed, reached):
    found, test = searched(lambda seed: recorded(lumped(mechanism), seed, 0.6, SECONDS))
    assert found.best.hypothesis.labels == ((mechanism.name, mechanism.place),)
    values = found.best.hypothesis.found[0].values
    for name, share in allowed.items():
        assert values[name] == pytest.approx(mechanism.values[name], rel=share), name
    before, after = errors(found, test)
    assert after < reached
    assert before > 10 * after
    (stage,) = found.stages
    if mechanism.verdict == "missing_physics":  # a changed part is what a calibration takes up
        assert max(stage.where, key=stage.where.get) == mechanism.place
    assert probabilities(stage.fits)[0] > 0.9
    assert stage.candidates[0].gain > 100


def softening(drift, rate):
    """A spring that is soft at first and hardens at once: no mechanism's law."""
    return 250 * drift - np.tanh(drift / 0.004)


def test_a_law_without_a_name_is_modelled_and_not_called_something_else():
    found, test = searched(lambda seed: concealed(softening, np.array([-1.0, 1.0]), seed))
    (law,) = found.best.hypothesis.found
    assert (law.name, law.place) == ("restoring_force", "storey2")
    assert law.verdict == "unexplained"
    assert found.named is not None
    assert found.named.bic > found.best.bic + 200
    before, after = errors(found, test)
    assert after < 0.02 < 0.2 < before
    # by its shape: the force on the drifts that the storey went through
    drift = np.linspace(-0.6, 0.6, 41) * law.reach
    wanted, modelled = softening(drift, 0.0), law.force(drift, 0 * drift, 0 * drift, 0.0)
    spring = np.polyfit(drift, wanted - modelled, 1)[0]  # the base may hold a little of it
    assert abs(spring) < 10
    assert np.abs(modelled + spring * drift - wanted).max() < 0.05 * np.abs(wanted).max()


def rival(mechanism, bic):
    return SimpleNamespace(hypothesis=Hypothesis((), (), (mechanism,)), bic=bic)


BROAD, STOP = ALL["unmeasured_force"]("floor1", 0.1, 5.0, 4.0), ALL["bumper"]("storey1", 2e3, 4e-3)


@pytest.mark.parametrize("follows", [True, False])
def test_a_broad_force_that_follows_the_motion_gives_way_to_the_laws(monkeypatch, follows):
    monkeypatch.setattr(searching, "follows_motion", lambda *_: follows)
    nothing, stage = (
        rival(STOP, 0.0),
        Stage(None, {}, (), (rival(BROAD, -900.0), rival(STOP, -500.0))),
    )
    lawful = searching._lawful(None, nothing, stage)
    assert [f.bic for f in lawful.fits] == ([-500.0] if follows else [-900.0, -500.0])


def test_without_any_law_to_put_in_its_place_a_broad_force_stays(monkeypatch):
    monkeypatch.setattr(searching, "follows_motion", lambda *_: True)
    stage = Stage(None, {}, (), (rival(BROAD, -900.0), rival(STOP, -1.0)))
    assert searching._lawful(None, rival(STOP, 0.0), stage) is stage
    alone = Stage(None, {}, (), (rival(BROAD, -900.0),))
    assert searching._lawful(None, rival(STOP, 0.0), alone) is alone


@pytest.mark.parametrize(
    ("explains", "chosen", "tried"),
    [
        ({"first"}, "first", []),
        ({"other"}, "other", ["other"]),
        (set(), "third", ["other", "third"]),
    ],
)
def test_another_beginning_is_tried_only_as_long_as_nothing_explains(
    monkeypatch, explains, chosen, tried
):
    bics = {"first": 3.0, "other": 2.0, "third": 1.0}
    ends = {name: SimpleNamespace(name=name, bic=bic) for name, bic in bics.items()}
    began = []

    def followed(path, *_):
        (name,) = path.stages
        began.append(name)
        return searching._Path(None, None, ends[name], (name,))

    monkeypatch.setattr(searching, "_followed", followed)
    monkeypatch.setattr(searching, "is_poor", lambda _, __, fit: fit.name not in explains)
    monkeypatch.setattr(searching, "other_beginnings", lambda *_: iter(["other", "third"]))
    monkeypatch.setattr(searching, "_comparable", lambda _, fit: fit)
    path = searching._Path(None, None, None, ("first",))
    first = searching._Path(None, None, ends["first"], ("first",))
    ended = searching._explaining(path, first, {}, 5, lambda message: None)
    assert ended.current.name == chosen
    assert began == tried


@pytest.fixture(scope="module")
def softened():
    """A bench on which one storey is softer, and the fit that says so."""
    softer = ALL["stiffness"]("storey1", -60.0)
    bench = Bench(TWO, (exact_trial((softer,), seed=1),), "linear")
    return bench, fit(bench, base_hypothesis(TWO).including(softer), 1e-3)


@pytest.mark.parametrize(("more", "outdone"), [(100.0, True), (1.0, False), (-100.0, False)])
def test_laws_that_explain_less_than_a_force_that_follows_the_motion_explain_poorly(
    softened, more, outdone
):
    bench, follower = softened
    assert _outdone(bench, rival(STOP, follower.bic + more), follower) is outdone


def test_neither_a_fault_of_an_instrument_nor_a_judge_that_trusts_the_forces_is_outdone(softened):
    bench, follower = softened
    fault = ALL["sensor_clipping"]("acc_floor1", 1.0)
    assert not _outdone(bench, rival(fault, follower.bic + 100), follower)
    trusting = replace(bench, slacks=bench.slacks[:1])
    assert not _outdone(trusting, rival(STOP, follower.bic + 100), follower)
    assert not _outdone(bench, rival(STOP, np.inf), None)


def explained(bic, name):
    return SimpleNamespace(bic=bic, hypothesis=SimpleNamespace(found=(name,)))


@pytest.fixture
def rubbing(monkeypatch):
    """A path that stands at friction, with two candidates whose order jumps turn round."""
    nothing, rubs = explained(0.0, ""), explained(-1e5, "friction")
    misled, right = explained(-2e5, "appendage"), explained(-1e5, "damping")
    again = [explained(bic, f.hypothesis.found[0]) for bic, f in
             ((-1.5e5, rubs), (-1.6e5, misled), (-1.9e5, right))]  # fmt: skip
    stage = Stage(rubs, {}, (), (misled, right))
    less = SimpleNamespace(samples=900)
    for name, does in {
        "next_stage": lambda *_: stage,
        "is_poor": lambda *_: False,
        "is_narrow": lambda _: True,
        "has_friction": lambda _: True,
        "without_jumps": lambda bench, current: (bench, current),
        "without_any_jumps": lambda *_: (less, again[0], (again[2], again[1])),
        "promoted": lambda *_: None,
    }.items():
        monkeypatch.setattr(searching, name, does)
    begun = Stage(nothing, {}, (), (rubs,))
    path = searching._Path(SimpleNamespace(samples=1000), nothing, nothing, (begun, begun))
    return path, again, less


def test_beside_friction_the_best_is_what_is_best_where_no_friction_jumps(rubbing):
    path, again, less = rubbing
    ended = searching._followed(path, {}, 3, lambda _: None)
    assert ended.current is again[2]
    assert ended.bench is less
    assert ended.stages[-1].before is again[0]
    assert ended.stages[-1].fits == (again[2], again[1])


@pytest.mark.parametrize("explains", [True, False])
def test_beside_friction_a_parameter_that_is_off_goes_before_what_does_not_explain_it(
    monkeypatch, rubbing, explains
):
    path, again, _ = rubbing
    own, asked = explained(-1.7e5, "stiffness"), []
    monkeypatch.setattr(searching, "promoted", lambda *given: asked.append(given) or own)
    monkeypatch.setattr(searching, "straightens", lambda *_: explains)
    ended = searching._followed(path, {}, 3, lambda _: None)
    assert ended.current is (again[2] if explains else own)
    assert ended.stages[-1].fits[0] is ended.current
    ((_, current, needed),) = asked
    assert current is again[0]
    assert needed > 500.0
