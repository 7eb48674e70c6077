"""Where fits begin, and what one knows from another nearby."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.beginning import (
    SHARP,
    as_sharp,
    attempted,
    beginnings,
    likelier,
    likeliest,
    start_of,
)
from twin.diagnosis.candidates import priors_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.known import RESOLVED
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.diagnosis.valleys import ALIKE, first_of_each
from twin.errors import NoLikelihoodError
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.coulomb_friction import CoulombFriction
from twin.mechanisms.cubic_stiffness import CubicStiffness

RATE = 0.05


@pytest.fixture(scope="module")
def rubbing():
    law = CoulombFriction("storey2", 0.1, 1e-3)
    twin = lumped().including(CoulombFriction("storey2", 0.1))
    problem = prepare(lumped(), [recorded(twin, 1)], [recorded(twin, 2)]).train
    return Hypothesis(problem, (law,), (priors_of([law]),), Scales({"storey2": (1.0, 1e-3, RATE)}))


def width(h, z):
    return h.at(z)[0].values["regular_rate"]


def test_a_jump_begins_as_sharp_as_it_is_seen(rubbing):
    z = start_of(rubbing)
    assert rubbing.simulated
    assert width(rubbing, as_sharp(rubbing, z)) == pytest.approx(SHARP * RATE)
    followed = replace(rubbing, problem=replace(rubbing.problem, low_pass=None))
    assert width(followed, as_sharp(followed, z)) == pytest.approx(RESOLVED * RATE)
    assert [width(rubbing, b) for b in beginnings(rubbing, z)][-1] == pytest.approx(SHARP * RATE)
    assert len(beginnings(followed, z)) == 3


def test_a_law_without_jumps_begins_as_it_is(rubbing):
    spring = CubicStiffness("storey2", 1e5)
    smooth = replace(rubbing, mechanisms=(spring,), priors=(priors_of([spring]),))
    z = start_of(smooth)
    np.testing.assert_array_equal(as_sharp(smooth, z), z)
    assert len(beginnings(smooth, z)) == 3


def test_what_is_known_nearby_is_no_worse_than_what_is_found_anew(rubbing):
    z = start_of(rubbing)
    there = evaluate(rubbing, z, derivatives=False).averages
    near = z + 1e-6
    anew, _ = likeliest(rubbing, [near])
    known, _ = likeliest(rubbing, [near], there)
    assert known > anew - 0.5


def test_what_a_fit_found_of_its_laws_is_not_lost_by_looking_again(rubbing):
    found = fit(rubbing, as_sharp(rubbing, start_of(rubbing)), most=6)
    known, _ = likeliest(rubbing, [found.z], found.averages)
    assert known > found.log_posterior - 1e-6


def test_values_far_apart_are_judged_each_by_its_own_motion():
    """With what laws did at the first, the second would be given up: it was at the truth."""
    law = Bumper("storey1", 8e3, 2e-4)
    twin = lumped().including(law)
    problem = prepare(lumped(), [recorded(twin, 1)], [recorded(twin, 2)]).train
    scales = Scales({"storey1": (1.0, 1e-3, RATE)})
    h = Hypothesis(
        problem, (law,), ({"stiffness": (np.log(8e3), 2.0), "gap": (2e-4, 1e-4)},), scales
    )
    right = fit(h).z
    wrong = start_of(h)
    at = [u.name for u in h.unknowns].index("bumper storey1 stiffness")
    wrong[at] = -2.5
    each = [likeliest(h, [z])[0] for z in (wrong, right)]
    assert each[1] > each[0] + 100
    for options in ([wrong, right], [right, wrong]):
        best, z = likelier(h, options)
        assert best == max(each)
        np.testing.assert_array_equal(z, right)
    assert likeliest(h, [wrong, right])[0] < max(each)


def test_averages_of_other_states_or_laws_are_not_taken_over(rubbing):
    run = evaluate(rubbing, start_of(rubbing), derivatives=False).runs[0]
    system = run.sampled.system
    assert run.averages.may_begin(system)
    assert not run.averages.may_begin(replace(system, A=np.eye(len(system.A) + 1)))
    assert not replace(run.averages, start=None).may_begin(system)
    two = replace(run.averages, slopes=np.zeros((2, 2)))
    assert not two.may_begin(system)


def test_no_more_than_so_many_places_of_one_mechanism_go_first():
    names = ["force"] * (ALIKE + 2) + ["mass", "force", "gain"]
    assert first_of_each(names) == [*range(ALIKE), ALIKE + 2, ALIKE + 4]


def test_values_without_a_likelihood_are_gone_by_and_a_fault_of_the_program_is_not(rubbing):
    class Broken:
        def __init__(self, error):
            self.unknowns, self.error = rubbing.unknowns, error

        def assemble(self, z):
            raise self.error

    z = np.zeros(len(rubbing.unknowns))
    for error in (NoLikelihoodError("runs away"), np.linalg.LinAlgError("Singular matrix")):
        assert attempted(Broken(error), z) is None
        assert likeliest(Broken(error), [z])[0] == -np.inf
    for wrong in (attempted, lambda model, z: likeliest(model, [z])):
        with pytest.raises(ValueError, match="shapes"):
            wrong(Broken(ValueError("shapes (3,) and (2,) not aligned")), z)
