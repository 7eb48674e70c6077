"""Laws that are simulated and filtered, beside an integration in fine steps and scipy's filter."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from estimation_support import FRICTION, RATE_HZ, TwoMasses, rubbing
from scipy.signal import resample_poly

from twin.estimation import averages
from twin.estimation.density import density
from twin.estimation.fit import fit
from twin.estimation.kalman import gains
from twin.estimation.law_averages import LawAverages
from twin.estimation.laws import no_memory
from twin.estimation.likelihood import evaluate, passes
from twin.estimation.low_pass import LowPass
from twin.estimation.model import Trial
from twin.estimation.passing import run, simulated
from twin.estimation.sensitivities import no_slopes, numbers_of, plants_of
from twin.estimation.simulated import filtered
from twin.estimation.start import estimated_start, root_of
from twin.estimation.system import transition
from twin.estimation.trust import trust_in

FINE, SAMPLES, NOISE = 64, 1024, 2e-3
FORCE, WIDTH = 0.6, 1e-5
PORTS = ((-1.0, 1.0),)


@cache
def recorded(level=4.0, input_noise=0.0):
    """Two masses with dry friction between them, shaken; force and response through one filter."""
    rng = np.random.default_rng(11)
    spectrum = np.fft.rfft(rng.standard_normal(SAMPLES * FINE))
    spectrum[np.fft.rfftfreq(SAMPLES * FINE, 1 / (RATE_HZ * FINE)) > 8.0] = 0.0
    u = np.fft.irfft(spectrum)
    u *= level / u.std()
    both = np.column_stack([u, rubbing(u, FINE, FORCE)])
    seen = resample_poly(both, 1, FINE, axis=0, window=("kaiser", 6.0))
    seen[:, 1:] += NOISE * rng.standard_normal((SAMPLES, 2))
    seen[:, 0] += input_noise * rng.standard_normal(SAMPLES)
    # straight lines between the samples lose sinc^2 of what is put back here
    lines = np.fft.rfft(seen[:, 0]) / np.sinc(np.fft.rfftfreq(SAMPLES)) ** 2
    return Trial(seen[:, :1], np.fft.irfft(lines)[:, None], seen[:, 1:], 1 / RATE_HZ)


def model(low_pass, steps=4):
    return TwoMasses((recorded(),), (FRICTION,), PORTS, steps=steps, low_pass=low_pass)


def truth(of, width=WIDTH):
    """The values of the unknowns that the recording was made with."""
    true = {"stiffness": 400.0, "law 0 number 0": FORCE, "law 0 number 1": width,
            "output noise 0": 2 * NOISE, "input noise 0": 2e-3}  # fmt: skip
    return np.array([(np.log(true[u.name]) - u.mean) / u.deviation for u in of.unknowns])


def left(low_pass, steps=4):
    """RMS of the innovations, one for each output, behind the start."""
    of = model(low_pass, steps)
    (run,) = passes(of, truth(of))
    return np.sqrt(np.mean(run.e[50:-20] ** 2, axis=0))


def test_through_the_filter_friction_leaves_a_fraction_of_what_it_leaves_as_it_is():
    assert np.all(left(LowPass(1.0)) < 0.2 * left(None))


def test_four_parts_of_a_sample_leave_what_sixteen_leave():
    np.testing.assert_allclose(left(LowPass(1.0), 4), left(LowPass(1.0), 16), rtol=0.15)


@pytest.mark.parametrize("first", [0.3, 1.2])
def test_the_force_of_friction_is_found_from_half_of_it_and_from_twice_as_much(first):
    of = model(LowPass(1.0))
    start = truth(of, 1e-3)
    start[1] = (np.log(first) - of.unknowns[1].mean) / of.unknowns[1].deviation
    start[3:] = 0.0
    found = fit(of, start, 40)
    assert found.values["law 0 number 0"] == pytest.approx(FORCE, rel=0.01)
    assert found.values["stiffness"] == pytest.approx(400.0, rel=0.002)


def test_a_simulation_begins_with_the_motion_that_a_recording_begins_with():
    whole, first = recorded(), 213
    cut = Trial(*(part[first:] for part in (whole.u, whole.between, whole.y)), whole.step_s)
    of = TwoMasses((cut,), (FRICTION,), PORTS, steps=4, low_pass=LowPass(1.0))
    here = evaluate(of, truth(of), derivatives=False)
    rest = [replace(run.averages, start=None) for run in here.runs]
    from_rest = evaluate(of, truth(of), derivatives=False, averages=rest)
    assert here.log_likelihood > from_rest.log_likelihood + 100
    e = here.runs[0].e[20:-20]
    assert np.all(np.sqrt(np.mean(e**2, axis=0)) < 1.5 * left(LowPass(1.0)))


def in_motion(level, first):
    """Friction that is recorded from a sample on, the first readings missing."""
    whole = recorded(level)
    u, between, y = (part[first:] for part in (whole.u, whole.between, whole.y))
    y = np.where(np.arange(len(y))[:, None] < 27, np.nan, y)
    trial = Trial(u, between, y, whole.step_s)
    of = TwoMasses((trial,), (FRICTION,), PORTS, steps=4, low_pass=LowPass(1.0))
    here = of.assemble(truth(of))
    (plant,), noise = plants_of(here, of), here.noises[0]
    return here, trial, plant, noise


@pytest.mark.parametrize(("level", "first"), [(0.8, 230), (3.0, 280)])
def test_friction_begins_where_few_samples_and_then_more_lead(level, first):
    here, trial, plant, noise = in_motion(level, first)
    # over all samples at once friction holds and lets go at other instants than it did
    from_rest = estimated_start(here, trial, plant, noise, LawAverages(), near=np.zeros(4)).state
    from_few = estimated_start(here, trial, plant, noise, LawAverages()).state
    gain, none = gains(plant, replace(noise, start=0 * noise.start)), LawAverages()
    there, better = (
        density(
            run(here, trial, plant, gain, x0=x, averages=none).e, trial.y, gain.innovation, None
        )
        for x in (from_rest, from_few)
    )
    assert better.value > there.value + 1000


@pytest.mark.parametrize(("level", "first"), [(0.8, 190), (0.8, 215), (1.5, 280), (3.0, 230)])
def test_friction_begins_where_some_side_of_the_prior_leads(level, first):
    here, trial, plant, noise = in_motion(level, first)
    found = estimated_start(here, trial, plant, noise, LawAverages()).state
    gain, root = gains(plant, replace(noise, start=0 * noise.start)), root_of(noise.start)
    rng = np.random.default_rng(4)

    def cost(state):
        e = run(here, trial, plant, gain, x0=state, averages=LawAverages()).e
        return -density(e, trial.y, gain.innovation, None).value

    elsewhere = [
        estimated_start(here, trial, plant, noise, LawAverages(), near=root @ drawn).state
        for drawn in rng.standard_normal((20, 4))
    ]
    assert cost(found) < min(cost(state) for state in elsewhere) + 20


def test_filtered_forces_are_weighed_around_each_sample_and_begin_with_those_of_the_first():
    rng = np.random.default_rng(2)
    steps, samples, laws, p = 3, 7, 2, 4
    taps = 5 * steps  # two samples before a sample, and two after the next
    f = rng.normal(size=(samples * steps + taps, laws))
    df, weights = rng.normal(size=(*f.shape, p)), rng.normal(size=(2, taps))
    out, dout = filtered(f, df, weights, steps, samples)
    for k in range(samples):
        at = k * steps - 2 * steps + np.arange(taps)
        at = np.where(at < 0, steps - 1, at)
        np.testing.assert_allclose(out[k], (weights @ f[at]).ravel(), rtol=1e-12)
        slopes = np.einsum("wt,tlp->wlp", weights, df[at]).reshape(-1, p)
        np.testing.assert_allclose(dout[k], slopes, rtol=1e-11)


class Ringing(TwoMasses):
    """The two masses behind an analyser that loses a tenth of what the forces are."""

    blurred = True

    def blur(self, forces, system):
        return (0.1 * forces) ** 2 @ (system.F**2).T


def test_where_an_input_rings_outputs_are_uncertain_by_no_more_than_friction_can_hold():
    u = np.zeros((200, 1))
    u[60:140, 0] = 400.0 * np.sinc(np.arange(80) - 39.3)
    trial = Trial(u, u, np.zeros((200, 2)), 1 / RATE_HZ)
    of = Ringing((trial,), (FRICTION,), PORTS, low_pass=LowPass(1.0))
    here = of.assemble(truth(of))
    system = here.systems[0]
    uncertain = np.sqrt(averages._ringing(of, here, system, trial))
    most = np.abs(system.F[:, 0]) * FORCE
    np.testing.assert_allclose(uncertain[99], most)
    # what would hold the joint still while the first mass is pushed
    share = (1 / 1.0) / (1 / 1.0 + 1 / 0.8)
    np.testing.assert_allclose(
        uncertain[90], 0.1 * share * abs(u[90, 0]) * np.abs(system.F[:, 0]), rtol=1e-6
    )
    assert np.all(uncertain[:50] == 0.0)


def test_noise_of_the_input_moves_friction_that_holds_as_little_as_the_force_does():
    noise = 0.02
    of = replace(model(LowPass(1.0)), trials=(recorded(0.5, noise),))
    z = truth(of)
    z[[u.name for u in of.unknowns].index("input noise 0")] += np.log(noise / 2e-3)
    here = evaluate(of, z, derivatives=False)
    free = [replace(run.averages, slopes=None) for run in here.runs]
    apart = evaluate(of, z, derivatives=False, averages=free)
    assert here.runs[0].averages.slopes[0, 1] > 0
    assert here.log_likelihood > apart.log_likelihood + 100


def test_deviations_from_the_simulation_are_estimated_with_the_dashpot_in_their_equations():
    of = replace(model(LowPass(1.0)), trials=(recorded(0.5, 0.02),))
    z = truth(of)
    z[[u.name for u in of.unknowns].index("input noise 0")] += np.log(0.02 / 2e-3)
    (found,) = passes(of, z)
    here, start, c = of.assemble(z), found.averages.start, found.averages.slopes[0, 1]
    plant = plants_of(here, of)[0]
    none = no_slopes(plant, found.gains, numbers_of(here))
    there = simulated(plant, here, here.trials[0], start, np.zeros((4, 0)), no_memory(here.laws),
                      0.0, none)  # fmt: skip
    own = plant.system
    A = own.A + c * np.outer(own.E[:, 0], own.rate[0])
    C = own.C + c * np.outer(own.F[:, 0], own.rate[0])
    whole, entry, _ = transition(A, own.W, 1 / RATE_HZ, 0)
    x, last = np.zeros(4), len(found.gains.state) - 1
    trust = trust_in(found.gains, found.averages.blur)
    for k, beyond in enumerate(there.e):
        e = beyond - C @ x
        np.testing.assert_allclose(found.e[k], e, atol=1e-9)
        trusted = trust[k] @ e
        x = whole @ (x + found.gains.state[min(k, last)] @ trusted)
        x += entry @ found.gains.held[min(k, last)] @ trusted
    assert c > 0
    assert np.any(found.averages.blur)


def test_where_a_simulation_begins_and_what_its_deviations_meet_follow_one_another(monkeypatch):
    whole, first = recorded(0.8, 0.02), 260
    cut = Trial(*(part[first:] for part in (whole.u, whole.between, whole.y)), whole.step_s)
    of = TwoMasses((cut,), (FRICTION,), PORTS, steps=4, low_pass=LowPass(1.0))
    z = truth(of)
    z[[u.name for u in of.unknowns].index("input noise 0")] += np.log(0.02 / 2e-3)
    found = evaluate(of, z, derivatives=False)
    near = [run.averages for run in found.runs]
    again = evaluate(of, z, derivatives=False, near=near)
    assert again.log_likelihood >= found.log_likelihood
    assert again.log_likelihood < found.log_likelihood + 1.0
    monkeypatch.setattr(averages, "ROUNDS", 1)
    once = evaluate(of, z, derivatives=False)
    assert found.log_likelihood > once.log_likelihood + 5.0


def test_from_one_dashpot_values_nearby_go_on_to_its_neighbour_until_the_likeliest():
    of = replace(model(LowPass(1.0)), trials=(recorded(0.5, 0.02),))
    z = truth(of)
    z[[u.name for u in of.unknowns].index("input noise 0")] += np.log(0.02 / 2e-3)
    best = evaluate(of, z, derivatives=False)
    (wanted,) = best.averages
    every = (0.0, *averages.SHARES)
    at = every.index(wanted.share)
    assert at > 0
    near = [replace(wanted, share=0.0, slopes=0 * wanted.slopes)]
    shares, last = [], -np.inf
    for _ in range(at + 1):
        found = evaluate(of, z, derivatives=False, near=near)
        near, (one,) = found.averages, found.averages
        assert found.log_likelihood >= last
        shares, last = [*shares, every.index(one.share)], found.log_likelihood
    assert shares[0] == 1  # one further at a time
    assert np.all(np.diff(shares) <= 1)
    assert found.log_likelihood == pytest.approx(best.log_likelihood, abs=1.0)
