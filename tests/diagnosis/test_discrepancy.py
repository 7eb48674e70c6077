"""Where the discrepancy of laws stands."""

import numpy as np
import pytest
from diagnosis_support import RATE, lumped, recorded, rng, tones
from scipy.linalg import expm, solve_continuous_lyapunov

from twin.diagnosis.beginning import moved_to, start_of
from twin.diagnosis.by_simulation import with_noise
from twin.diagnosis.candidates import priors_of
from twin.diagnosis.discrepancy import Discrepancy
from twin.diagnosis.explanation import Explanation
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.left import law_whose_form, left_share
from twin.diagnosis.prepare import prepare
from twin.diagnosis.scales import Scales
from twin.diagnosis.sizes import negligible
from twin.estimation.fit import Fit, fit
from twin.estimation.start import root_of
from twin.mechanisms.bumper import Bumper
from twin.mechanisms.clearance import Clearance
from twin.mechanisms.cubic_stiffness import CubicStiffness
from twin.mechanisms.unmeasured_force import UnmeasuredForce
from twin.recording import Recording

SCALES = Scales({"storey1": (0.1, 1e-3, 0.02), "storey2": (0.1, 1e-3, 0.02)})


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


def beside(problem, *laws):
    """A hypothesis with laws, and values of its unknowns at their priors' means."""
    h = Hypothesis(problem, laws, tuple(priors_of((law,)) for law in laws), SCALES)
    return h, np.zeros(len(h.unknowns))


def with_share(h, z, share):
    place = [u.role for u in h.unknowns].index("error")
    out = z.copy()
    out[place] = (np.log(share) - h.unknowns[place].mean) / h.unknowns[place].deviation
    return out


def as_fitted(h, z):
    return Fit(h, z, np.eye(len(z)), 0.0, 0.0, 0.0, "converged")


def test_a_law_that_acts_at_times_is_off_by_a_share_and_by_no_latent_force():
    problem = hypothesis(lumped()).problem
    h, z = beside(problem, Bumper("storey2", 500.0, 5e-4))
    assert [u.name for u in h.unknowns if "discrepancy" in u.name] == ["discrepancy storey2 share"]
    assert h.assemble(z).errors == pytest.approx((0.01,))
    both, z = beside(problem, CubicStiffness("storey2", 1e5), Clearance("storey2", 100.0, 1e-4))
    assert (both.ports, both.erring) == (("storey2",), ())  # one discrepancy at a port
    here = both.assemble(z)
    assert here.errors == (0.0, 0.0)
    assert len(here.systems[0].A) == len(h.assemble(np.zeros(len(h.unknowns))).systems[0].A) + 2


@pytest.mark.parametrize("share", [0.02, 0.3])
def test_what_is_left_of_a_stop_is_its_share(share):
    problem = hypothesis(lumped()).problem
    h, z = beside(problem, Bumper("storey2", 500.0, 5e-4))
    z = with_share(h, z, share)
    left = left_share(h, as_fitted(h, z), 0, [2.0])
    assert left == pytest.approx(share / np.hypot(1.0, share))


@pytest.mark.parametrize(("size", "trifle"), [(0.1, True), (0.5, False)])
def test_beside_a_stop_that_is_off_what_is_smaller_is_negligible(size, trifle):
    problem = hypothesis(lumped()).problem
    h, z = beside(problem, Bumper("storey2", 500.0, 5e-4), CubicStiffness("storey1", 1e3))
    z = with_share(h, z, 0.3)
    assert negligible(h, as_fitted(h, z), [], [1.0, size]) == [False, trifle]


def test_after_a_search_by_simulation_a_stop_is_off_by_what_is_left():
    problem = hypothesis(lumped()).problem
    h, _ = beside(problem, Bumper("storey2", 500.0, 5e-4))
    found = with_noise(Explanation(h, as_fitted(h, start_of(h)), 0.0))
    assert 0.0 < found.fit.values["discrepancy storey2 share"] < 2.0


@pytest.mark.parametrize(
    ("frequency", "bandwidth", "steps"),
    [(0.05, None, 1024), (0.3, None, 1024), (0.1, 0.2, 1024), (0.3, 0.05, 1024), (2.0, 0.5, 4096)],
)
def test_how_much_a_discrepancy_varies_is_that_of_histories_that_are_drawn(
    frequency, bandwidth, steps
):
    """About their own mean over four seconds; with a corner, at one, and as a resonance."""
    one = Discrepancy("storey2", 0.7, frequency, bandwidth)
    block, drive, shape = one.shaping()
    A, draw = expm(block * 4.0 / steps), np.random.default_rng(0)
    start = solve_continuous_lyapunov(block, -np.outer(drive, drive))
    state = np.linalg.cholesky(start) @ draw.standard_normal((len(block), 2000))
    noise = root_of(start - A @ start @ A.T)
    history = np.empty((steps, 2000))
    for k in range(steps):
        history[k] = shape @ state
        state = A @ state + noise @ draw.standard_normal((len(block), 2000))
    assert one.varying(4.0) == pytest.approx(np.sqrt(np.mean(np.var(history, axis=0))), rel=0.03)


def test_a_discrepancy_that_does_not_change_within_a_recording_does_not_vary():
    for bandwidth in (None, 2e-7):
        assert Discrepancy("storey2", 0.7, 1e-7, bandwidth).varying(4.0) < 1e-2 * 0.7


@pytest.mark.parametrize(
    ("place", "size", "bandwidth", "stands"),
    [
        ("floor1", 0.5, 2.0, True),  # the port of storey1 by another name
        ("floor2", 0.5, 2.0, False),  # another port
        ("floor1", 2.0, 2.0, False),  # more than the law
        ("floor1", 0.5, 1e-3, False),  # a line, narrower than any resonance
    ],
)
def test_a_latent_force_at_a_laws_port_is_what_the_law_leaves(place, size, bandwidth, stands):
    problem = hypothesis(lumped()).problem
    law, force = CubicStiffness("storey1", 1e5), UnmeasuredForce(place, 0.1, 3.0, bandwidth)
    h, z = beside(problem, law, force)
    found, sizes = as_fitted(h, z), [1.0, size]
    assert law_whose_form(h, z, sizes, 1) == (0 if stands else None)
    assert law_whose_form(h, z, sizes, 0) is None
    assert negligible(h, found, [], sizes)[1] is stands
    alone = left_share(h, found, 0, [1.0, 0.0])
    both = np.hypot(alone / np.sqrt(1 - alone**2), size) if stands else 0.0
    assert left_share(h, found, 0, sizes) == pytest.approx(
        both / np.hypot(1.0, both) if stands else alone
    )


def test_a_force_at_the_port_of_a_stop_is_another_force():
    """The stop errs only while it acts."""
    problem = hypothesis(lumped()).problem
    force = UnmeasuredForce("floor1", 0.1, 3.0, 2.0)
    h, z = beside(problem, Bumper("storey1", 500.0, 5e-4), force)
    assert law_whose_form(h, z, [1.0, 0.5], 1) is None


def pushed_beside(twin, force, seed, seconds=16.0, noise=2e-3):
    """A recording of a twin beside a force that nobody measured."""
    fine, samples = 8, round(seconds * RATE)
    known = tones(samples * fine, RATE * fine, seed, 0.3)
    draw = rng(seed)
    unknown = force.realisation(samples * fine, RATE * fine, draw)
    columns = {"force_floor2": known, f"force_{force.place}": unknown}
    moved = twin.simulate(columns, RATE * fine, samples * fine).columns
    read = {name: moved[name][::fine] + noise * draw.standard_normal(samples)
            for name in ("acc_floor1", "acc_floor2")}  # fmt: skip
    return Recording.build(RATE, {"force_floor2": known[::fine], **read}, f"seed{seed}.csv")


def test_beside_a_law_a_smooth_force_at_its_port_is_no_further_mechanism():
    """The discrepancy is that very process."""
    law, force = CubicStiffness("storey1", 4e6), UnmeasuredForce("floor1", 0.05, 4.0, 8.0)
    there = lumped(law)
    train = [pushed_beside(there, force, seed) for seed in (1, 2)]
    problem = prepare(lumped(), train, [pushed_beside(there, force, 3)]).train
    alone, z = beside(problem, law)
    left = fit(alone, z)
    told = [left.values[f"discrepancy storey1{name}"] for name in ("", " frequency", " bandwidth")]
    assert told == pytest.approx([0.05, 4.0, 8.0], rel=0.1)
    both, z = beside(problem, law, force)
    further = fit(both, moved_to(both, alone, left.z, force))
    assert further.log_evidence < left.log_evidence + 3.0
