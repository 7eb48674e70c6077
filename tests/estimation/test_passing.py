"""Where a recording begins a force that jumps is unknown by as much as it is."""

import numpy as np
import pytest
from estimation_support import CUBIC, FRICTION, TwoMasses, shaken

from twin.estimation.averages import averages_at, unknown_forces
from twin.estimation.kalman import gains, start_covariances
from twin.estimation.passing import run
from twin.estimation.sensitivities import plants_of

PORTS = ((1.0, 0.0),)


def passed(law):
    trial = shaken(300, 31, (law,), PORTS)
    model = TwoMasses((trial,), (law,), PORTS)
    here = model.assemble(np.zeros(len(model.unknowns)))
    plants = plants_of(here, model)
    equivalent = averages_at(model, here, plants, 0).equivalent
    gain = gains(plants[0], here.noises[0], equivalent=equivalent)
    return here, run(here, trial, plants[0], gain), equivalent, gain


def test_covariances_lead_from_the_first_to_the_stationary_one():
    here, result, equivalent, gain = passed(CUBIC)
    found = start_covariances(result.sampled, here.noises[0], gain, equivalent)
    assert found[0] == pytest.approx(here.noises[0].start)
    last = np.sqrt(np.diag(found[-1]))
    assert last == pytest.approx(np.sqrt(np.diag(gain.predicted)), rel=0.05)
    C = result.sampled.system.C + equivalent.C
    for k in (0, 3, len(found) - 1):  # what is left of an innovation's covariance is its noise
        rest = gain.innovation[k] - C @ found[k] @ C.T
        noise = gain.innovation[-1] - C @ gain.predicted @ C.T
        assert rest == pytest.approx(noise, rel=1e-6, abs=1e-9 * np.max(np.abs(noise)))


def test_a_force_is_unknown_at_first_and_known_once_the_state_is():
    here, result, equivalent, gain = passed(FRICTION)
    still = np.zeros((1, result.x.shape[1]))
    unknown = unknown_forces(here, result, here.noises[0], equivalent, still)[:, 0]
    force, width = here.numbers[0, :2]
    row = result.sampled.system.rate[0]
    spread = np.sqrt(row @ (here.noises[0].start - gain.predicted) @ row)
    assert unknown[0] == pytest.approx(force * np.tanh(spread / width), rel=1e-9)
    assert np.all(unknown[260:] == 0.0)
    assert np.mean(unknown[100:200]) < 0.1 * unknown[0]
