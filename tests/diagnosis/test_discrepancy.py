"""Where the discrepancy of laws stands."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.beginning import start_of
from twin.diagnosis.by_simulation import with_noise
from twin.diagnosis.candidates import priors_of
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.estimation.fit import Fit
from twin.mechanisms.cubic_stiffness import CubicStiffness

SCALES = Scales({"storey2": (0.1, 1e-3, 0.02)})


def hypothesis(twin, model=None):
    train, test = recorded(twin, 1, seconds=4.0), recorded(twin, 2, seconds=4.0)
    return Hypothesis(prepare(model or twin, [train], [test]).train)


def discrepancies(h):
    return [u.name for u in h.unknowns if u.name.startswith("discrepancy") and u.level]


@pytest.mark.parametrize(
    ("places", "count"),
    [(("storey1", "floor1"), 1), (("storey1", "storey2"), 2), (("storey2", "floor2-floor1"), 1)],
)
def test_laws_that_move_in_proportion_have_one_discrepancy(places, count):
    problem = hypothesis(lumped()).problem
    laws = tuple(CubicStiffness(place, 1e5) for place in places)
    assert np.linalg.matrix_rank(np.array([problem.model.port(place) for place in places])) == count
    h = Hypothesis(problem, laws)
    assert h.ports == places[:count]
    assert h.port_of(places[1]) == places[count - 1]


def test_after_a_search_by_simulation_it_is_the_share_of_the_greatest_law_there():
    """What is smaller is a matter of that law's form, whichever of them was found first."""
    problem = hypothesis(lumped()).problem
    levels = []
    for sizes in ((1e5, 1e2), (1e2, 1e5)):
        laws = tuple(CubicStiffness("storey2", size) for size in sizes)
        h = Hypothesis(problem, laws, (priors_of(laws[:1]), priors_of(laws[1:])), SCALES)
        z = start_of(h)
        found = Explanation(h, Fit(h, z, np.eye(len(z)), 0.0, 0.0, 0.0, "converged"), 0.0)
        levels.append(with_noise(found).fit.values["discrepancy storey2"])
    assert levels[0] == pytest.approx(levels[1], rel=1e-6)
    assert levels[0] > 0
