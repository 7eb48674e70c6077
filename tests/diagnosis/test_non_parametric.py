"""A force without a name stands in for names that mimic it, and for nothing else."""

import numpy as np
import pytest
from diagnosis_support import concealed, lumped, recorded

from twin.diagnosis.candidates import Candidate, priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.motion import Motion
from twin.diagnosis.non_parametric import _like, named_for
from twin.diagnosis.offer import offer
from twin.diagnosis.predict import predictors
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.diagnosis.search import search
from twin.diagnosis.verdict import judge
from twin.estimation.fit import Fit
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.clearance import Clearance
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.restoring_force import KNOTS, RestoringForce

NAMES = ("cubic_stiffness", "quadratic_stiffness", "coulomb_friction", "stiffness",
         "restoring_force")  # fmt: skip
ACROSS = np.array([-1.0, 1.0])


def magnet(drift, rate):
    """A magnet's pull at a distance of 12 mm, less what it is at rest, as no polynomial is."""
    return 0.6 * (1 - (0.012 / (0.012 - np.clip(drift, -0.05, 0.008))) ** 2)


def nearly_cubic(drift, rate):
    """A spring that hardens with a power that no mechanism has, 2.7."""
    return 4e4 * np.abs(drift) ** 1.7 * drift


def found(train, test, names=NAMES):
    ready = prepare(lumped(), train, test)
    whole = offer(ready.train, ready.kinds)

    def few(moved, runs):
        return [c for c in whole(moved, runs) if c.label[0] in names]

    result = search(ready.train, few)
    return result, judge(result, predictors(result.best.hypothesis, result.best.fit.z))


@pytest.fixture(scope="module")
def pulled():
    return found(
        [concealed(magnet, ACROSS, 1, scale=0.12)], [concealed(magnet, ACROSS, 2, scale=0.12)]
    )


def test_names_that_mimic_a_law_give_way_to_it(pulled):
    result, judged = pulled
    assert result.best.labels == (("restoring_force", "storey2"),)
    assert judged.verdict == "unexplained"
    mimics = [e for e in result.others if e.labels and e.log_odds > result.nothing.log_odds]
    assert max(e.log_odds for e in mimics) < result.best.log_odds


def test_it_is_the_law_that_was_concealed(pulled):
    result, _ = pulled
    (law,) = result.best.hypothesis.at(result.best.fit.z)
    drift = np.concatenate([m.q @ ACROSS for m in result.motion])
    seen = np.linspace(*np.quantile(drift, [0.05, 0.95]), 50)
    true, still = magnet(seen, 0.0), np.zeros(50)
    stated = law.force(seen, still, still, 0.0)
    # masses and stiffnesses are known to a share only, and so is a straight line in the law
    line = np.polyfit(seen, true - stated, 1)
    assert np.std(true - stated - np.polyval(line, seen)) < 0.05 * np.std(true)


def test_a_law_that_is_nearly_right_keeps_its_name_and_no_companion():
    names = ("cubic_stiffness", "clearance", "restoring_force")
    train, test = ([concealed(nearly_cubic, ACROSS, s, scale=0.5, seconds=24.0)] for s in (1, 2))
    result, judged = found(train, test, names)
    assert result.best.labels == (("cubic_stiffness", "storey2"), ("restoring_force", "storey2"))
    (law,) = judged.findings
    assert (law.mechanism.name, law.location) == ("cubic_stiffness", "storey2")
    assert judged.verdict == "missing_physics"
    assert [f.mechanism.name for f in judged.negligible] == ["restoring_force"]
    assert any("stands for what cubic_stiffness at storey2 leaves" in n for n in judged.notes)
    # a stop that is not there would be told instead
    likely = {e.labels: e.log_odds for e in result.others}
    spring, stop = ("cubic_stiffness", "storey2"), ("clearance", "storey2")
    assert likely[spring, stop] > likely[(spring,)]
    assert 0.02 < law.unexplained < 0.5


def test_a_stop_beside_a_spring_is_no_force_without_a_name():
    both = lumped(CubicStiffness("storey2", 2e6), Bumper("storey2", 300.0, 1e-3))
    names = ("cubic_stiffness", "bumper", "restoring_force")
    result, judged = found([recorded(both, 1, seconds=24.0)], [recorded(both, 2)], names)
    assert {(f.mechanism.name, f.location) for f in judged.findings} == {
        ("cubic_stiffness", "storey2"), ("bumper", "storey2"),
    }  # fmt: skip
    assert not any(m.generic for m in result.best.hypothesis.mechanisms)


def test_two_laws_that_are_both_there_keep_their_names():
    both = lumped(CubicStiffness("storey2", 4e6), CoulombFriction("storey2", 0.05))
    names = ("cubic_stiffness", "coulomb_friction", "restoring_force")
    train, test = ([recorded(both, seed, noise=2e-2)] for seed in (1, 2))
    result, judged = found(train, test, names)
    assert set(result.best.labels) == {
        ("cubic_stiffness", "storey2"), ("coulomb_friction", "storey2")
    }  # fmt: skip
    assert judged.verdict == "missing_physics"
    named = [e.labels for e in (result.best, *result.others)]
    assert (("restoring_force", "storey2"),) in named


@pytest.mark.parametrize(
    ("begun", "law"),
    [
        (Bumper("storey2", 300.0, -5e-3), Bumper("storey2", 1641.0, -2.3e-3)),
        (Clearance("storey2", 100.0, 1e-3, 100.0), Clearance("storey2", 400.0, 2.5e-3, 400.0)),
        (CubicStiffness("storey2", 1e4), CubicStiffness("storey2", 3e5)),
    ],
)
def test_a_law_is_found_in_a_force_that_has_its_form(begun, law):
    """The force has bends at a few drifts alone, and what is linear in it is the structure's."""
    drift = np.linspace(-8e-3, 8e-3, 200)
    still = np.zeros_like(drift)
    force = RestoringForce("storey2", reach=8e-3)
    columns = np.column_stack([
        force.with_values({n: 1.0}).force(drift, still, still, 0.0) for n in force.parameters
    ])  # fmt: skip
    target = law.force(drift, still, still, 0.0) + 30.0 * drift
    values = np.linalg.lstsq(columns, target, rcond=None)[0]
    force = force.with_values(dict(zip(force.parameters, values.tolist(), strict=True)))
    _, found = _like(begun, force, drift)
    off, size = (np.std(f - drift * (drift @ f) / (drift @ drift)) for f in (
        found.force(drift, still, still, 0.0) - law.force(drift, still, still, 0.0),
        law.force(drift, still, still, 0.0),
    ))  # fmt: skip
    assert off < 0.05 * size


def test_names_for_a_force_are_laws_of_the_displacement_at_its_port():
    train, test = ([recorded(lumped(), seed, seconds=4.0)] for seed in (1, 2))
    problem = prepare(lumped(), train, test).train
    force = RestoringForce("storey2", left_3=4.0, reach=8e-3)
    h = Hypothesis(problem, (force,), (priors_of([force]),), Scales({"storey2": (1.0, 4e-3, 0.1)}))
    z = np.zeros(len(h.unknowns))
    for i, u in enumerate(h.unknowns):
        if u.name == "restoring_force storey2 left_3":
            z[i] = (4.0 - u.mean) / u.deviation
    starts = (Bumper("storey2", 300.0, -5e-3), Bumper("storey1", 300.0, -5e-3),
              CoulombFriction("storey2", 0.1, 1e-3))  # fmt: skip
    candidates = [Candidate((start,), priors_of([start])) for start in starts]
    drift = np.linspace(-8e-3, 8e-3, 400)
    q = np.column_stack([0 * drift, drift])
    moved = [Motion(q, 0 * q, 0 * q)]
    fitted = Fit(h, z, np.eye(len(z)), 0.0, 0.0, 0.0, "converged")
    ((other, (begun, _)),) = named_for(h, fitted, moved, candidates)
    assert [(m.name, m.place) for m in other.mechanisms] == [("bumper", "storey2")]
    (law,) = other.at(begun)
    assert law.gap == pytest.approx(-KNOTS[2] * 8e-3, rel=0.05)
    assert law.stiffness == pytest.approx(4.0 / (1 - KNOTS[2]) / 8e-3, rel=0.1)
