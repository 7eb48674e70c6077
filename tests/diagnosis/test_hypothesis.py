"""A hypothesis beside recordings that were made under other loads."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded, rng

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.errors import NoLikelihoodError
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.mechanisms.appendage import Appendage
from twin.mechanisms.base_compliance import BaseCompliance
from twin.mechanisms.damping import Damping
from twin.mechanisms.mass import Mass
from twin.mechanisms.p_delta import PDelta
from twin.mechanisms.sensor_drift import FLICKER, SensorDrift
from twin.mechanisms.sensor_resonance import SensorResonance
from twin.mechanisms.unmeasured_force import UnmeasuredForce
from twin.recording import Recording


def frequencies(A):
    return np.sort(np.abs(np.linalg.eigvals(A).imag))[::2] / (2 * np.pi)


def test_no_more_of_a_force_is_noise_than_was_read_of_it():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    h = Hypothesis(problem)
    read = np.sqrt(np.mean(problem.recordings[0].u ** 2))
    (at,) = (i for i, u in enumerate(h.unknowns) if u.name.startswith("noise of force"))
    levels = {}
    for level in (1e-3 * read, read, 1e4 * read):
        z = np.zeros(len(h.unknowns))
        z[at] = (np.log(level) - h.unknowns[at].mean) / h.unknowns[at].deviation
        levels[level / read] = h.assemble(z).noises[0].held[0] / read
    expected = [1e-3, np.sqrt(0.5), 1.0]
    np.testing.assert_allclose(list(levels.values()), expected, rtol=1e-6)


def test_nothing_that_a_predictor_steps_rings_above_half_the_sampling_rate():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    high = 0.9 * problem.sampling_hz
    both = SensorResonance("acc_floor1", high, 0.01), UnmeasuredForce("floor1", 1.0, high, 0.5)
    priors = tuple({n: (np.log(m.values[n]), 0.1) for n in m.parameters} for m in both)
    h = replace(Hypothesis(problem), mechanisms=both, priors=priors)
    poles = np.linalg.eigvals(h.assemble(np.zeros(len(h.unknowns))).systems[0].A)
    above = poles[np.abs(poles) > np.pi * problem.sampling_hz]
    assert len(above) == 4
    assert np.all(-above.real / np.abs(above) > 0.69)


def test_the_weight_of_a_bolted_mass_leans_on_what_is_below_it():
    plain, heavy = recorded(lumped(), 1), recorded(lumped(Mass("floor2", 0.5)), 2)
    added = {heavy.source: {"floor2": 0.5}}
    problem = prepare(lumped(), [plain, heavy], [recorded(lumped(), 3)], added_mass=added).train
    leaning = PDelta("storey1", 1.2, 0.15)
    h = replace(Hypothesis(problem), mechanisms=(leaning,), priors=({"factor": (1.2, 0.1)},))
    systems = h.assemble(np.zeros(len(h.unknowns))).systems
    for system, masses in zip(systems, ((), (Mass("floor2", 0.5),)), strict=True):
        twin = lumped(*masses, leaning).linear(["force_floor2"], ["acc_floor2"])
        expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(twin.M, twin.K)).real) / (2 * np.pi)
        assert frequencies(system.A[:4, :4]) == pytest.approx(np.sort(expected), rel=1e-3)
    first = problem.recordings[0]
    assert not first.added_mass


def test_no_more_damping_can_be_missing_than_there_is():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    row = problem.model.port("storey2")
    most = 1 / float(row @ np.linalg.solve(problem.model.R, row))
    for share, there in ((0.99, True), (1.01, False)):
        less = Damping("storey2", -share * most)
        priors = ({"change": (less.change, 1.0)},)
        h = replace(Hypothesis(problem), mechanisms=(less,), priors=priors)
        if there:
            assert h.assemble(np.zeros(len(h.unknowns)))
        else:
            with pytest.raises(NoLikelihoodError, match="less damping than none"):
                h.assemble(np.zeros(len(h.unknowns)))


def test_a_structure_without_bounds_has_no_likelihood():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    rigid = Mass("floor2", np.inf)
    h = replace(Hypothesis(problem), mechanisms=(rigid,), priors=({"change": (np.inf, 1.0)},))
    with np.errstate(all="ignore"), pytest.raises(NoLikelihoodError, match="without bounds"):
        h.assemble(np.zeros(len(h.unknowns)))


def test_a_mass_that_hangs_on_the_structure_is_stirred_as_its_inertia_is():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    empty = Hypothesis(problem)
    bare = evaluate(empty, np.zeros(len(empty.unknowns))).log_likelihood
    rises = []
    for mass in (1e-2, 1e-4, 1e-6):
        hung = Appendage("floor2", mass, 2.6, 0.01)
        priors = {name: (float(np.log(value)), 1.0) for name, value in hung.values.items()}
        h = replace(empty, mechanisms=(hung,), priors=(priors,))
        rises.append(evaluate(h, np.zeros(len(h.unknowns))).log_likelihood - bare)
        (system,) = h.assemble(np.zeros(len(h.unknowns))).systems
        rows = slice(len(problem.model.coordinates) + 1, None)
        accelerations = np.linalg.norm(system.W[rows, len(problem.model.inputs) :], axis=1)
        assert accelerations[-1] == pytest.approx(np.linalg.norm(problem.model.port("floor2")))
    assert abs(rises[2]) < 0.1, "what weighs nothing changes nothing"
    assert abs(rises[2]) < abs(rises[1]) < abs(rises[0])


def test_a_base_is_stirred_by_what_the_structure_does_to_it():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    soft = BaseCompliance("ground", 1e4, 10.0)
    priors = {name: (float(np.log(value)), 1.0) for name, value in soft.values.items()}
    h = replace(Hypothesis(problem), mechanisms=(soft,), priors=(priors,))
    (system,) = h.assemble(np.zeros(len(h.unknowns))).systems
    assert np.all(np.isfinite(system.W))
    assert np.linalg.norm(system.W[-1, len(problem.model.inputs) :]) > 0


def test_a_drift_of_another_strength_in_each_recording_is_found_as_such():
    strengths = (0.01, 0.08)
    drifting = []
    for seed, strength in enumerate(strengths):
        clean = recorded(lumped(), seed)
        columns = {name: np.array(clean.column(name)) for name in clean.names}
        walk = np.cumsum(rng(seed).standard_normal(clean.samples)) / np.sqrt(clean.sampling_hz)
        columns["acc_floor1"] = columns["acc_floor1"] + strength * walk
        drifting.append(Recording.build(clean.sampling_hz, columns, clean.source))
    problem = prepare(lumped(), drifting, [recorded(lumped(), 5)]).train
    drift = SensorDrift("acc_floor1", 0.03)
    h = replace(
        Hypothesis(problem), mechanisms=(drift,), priors=({"rate": (float(np.log(0.03)), 1.5)},)
    )
    found = fit(h)
    rate = found.values["sensor_drift acc_floor1 rate"]
    for recording, strength in zip(problem.recordings, strengths, strict=True):
        own = found.values[f"sensor_drift acc_floor1 in {recording.name}"]
        assert rate * own == pytest.approx(strength, rel=0.25)


def test_one_recording_has_no_strength_beside_the_drift_s_own():
    problem = prepare(lumped(), [recorded(lumped(), 1)], [recorded(lumped(), 2)]).train
    flicker = SensorDrift("acc_floor1", 0.03, form=FLICKER)
    h = replace(Hypothesis(problem), mechanisms=(flicker,), priors=({"rate": (-3.5, 1.5)},))
    assert len(h.unknowns) == len(Hypothesis(problem).unknowns) + 1
