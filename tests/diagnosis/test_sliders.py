"""Springs of a model that yield are one law along each line, and do as MuJoCo lets them."""

import re
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.nominal import checked
from twin.diagnosis.prepare import prepare
from twin.diagnosis.sliders import MOST, Sliders, together
from twin.estimation.laws import memory_along
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.hysteresis import Hysteresis
from twin.mechanisms.sliders import as_sliders
from twin.model import Twin
from twin.model.nonlinear import IDEAL

LAW = Hysteresis("storey2", 150.0, 0.2, 1.0, 150.0)
DRIFT = 0.004 * np.sin(np.linspace(0, 20, 3000)) * np.linspace(0, 1, 3000)


def prepared(twin, model=None):
    train, test = recorded(twin, 1, seconds=4.0), recorded(twin, 2, seconds=4.0)
    return prepare(model or twin, [train], [test]).train


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    twin = lumped(LAW)
    own = Twin.load(twin.export(tmp_path_factory.mktemp("own") / "own.xml"))
    return own, prepared(twin, own)


def sliding(stiffness, yield_force, drift):
    """The force of one slider, step by step."""
    force = np.zeros(len(drift))
    for k in range(1, len(drift)):
        free = force[k - 1] + stiffness * (drift[k] - drift[k - 1])
        force[k] = min(max(free, -yield_force), yield_force)
    return force


def force_of(law, drift):
    memory = memory_along(law.compiled, np.array(law.numbers), drift)
    return law.force(drift, 0.0, memory, 0.0)


def test_an_exported_hysteresis_is_one_law_with_two_unknowns(written):
    """Six laws of four numbers each drove the predictor thirty-six times as often."""
    _, problem = written
    (law,) = problem.known
    each = sorted(as_sliders(150.0, 0.2, 1.0), key=lambda one: one[1] / one[0])
    there = each[: len(law.softer)]  # the others did not yield, and are linear springs
    assert len(there) > 1
    assert law.stiffness == law.replaced == pytest.approx(sum(k for k, _ in there))
    assert law.yield_force == pytest.approx(sum(y for _, y in there))
    assert [own.parameter for own in problem.of_known] == ["stiffness", "yield_force"]
    unknowns = Hypothesis(problem).unknowns
    assert sum(u.name.startswith("discrepancy") and u.level for u in unknowns) == 1


def test_its_force_is_that_of_all_sliders(written):
    each = as_sliders(150.0, 0.2, 1.0)
    known = [Hysteresis("storey2", k, y, IDEAL, k) for k, y in each]
    (law,) = together(known, written[1].model)
    expected = sum(sliding(k, y, DRIFT) - k * DRIFT for k, y in each)
    np.testing.assert_allclose(force_of(law, DRIFT), expected, atol=1e-9)


def missed(twin, problem, *known):
    """By how much [%] the equations with these laws miss MuJoCo's motion."""
    (note,) = checked(twin, replace(problem, known=known))
    return float(re.search(r"by ([0-9.e-]+) % of its RMS", note)[1])


def test_the_equations_move_as_mujoco_does(written):
    """A loop of Bouc and Wen rounds the corner of each by 3.5 % of its force."""
    twin, problem = written
    (law,) = problem.known
    rounded = [
        Hysteresis(law.place, k * law.stiffness, y * law.yield_force, IDEAL, k * law.stiffness)
        for k, y in zip(law.softer, law.sooner, strict=True)
    ]
    assert missed(twin, problem, law) < 0.2
    assert missed(twin, problem, *rounded) > 0.35


def test_what_is_along_a_line_that_counts_double_is_four_times_as_stiff(written):
    model = written[1].model
    double = replace(model.ports["storey2"], name="double", row=-2 * model.port("storey2"))
    both = replace(model, ports=MappingProxyType({**model.ports, "double": double}))
    known = [Hysteresis(place, 100.0, 0.3, IDEAL, 100.0) for place in ("storey2", "double")]
    (law,) = together(known, both)
    assert (law.stiffness, law.yield_force, law.replaced) == (500.0, pytest.approx(0.9), 500.0)
    one = force_of(law, DRIFT) + 500.0 * DRIFT
    apart = sliding(100.0, 0.3, DRIFT) + 2 * sliding(100.0, 0.3, 2 * DRIFT)
    np.testing.assert_allclose(one, apart, atol=1e-12)


def test_other_laws_and_other_lines_stay_apart(written):
    model = written[1].model
    rubs, round_ = CoulombFriction("storey2", 0.1), LAW
    many = [Hysteresis("storey1", 10.0, 0.1 * (i + 1), IDEAL, 10.0) for i in range(MOST + 2)]
    here = Hysteresis("storey2", 10.0, 0.1, IDEAL, 10.0)
    *kept, first, second, other = together([rubs, round_, *many, here], model)
    assert kept == [rubs, round_]
    assert all(isinstance(law, Sliders) for law in (first, second, other))
    assert [np.count_nonzero(law.softer) for law in (first, second, other)] == [MOST, 2, 1]
    assert [law.place for law in (first, second, other)] == ["storey1", "storey1", "storey2"]
