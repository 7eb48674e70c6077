"""Faults that are read off the samples: named, hidden from the likelihood; none where none is."""

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis.prepare import prepare
from twin.diagnosis.read_off import faults_in
from twin.mechanisms import vocabulary
from twin.recording import Recording

FAULTS = {
    "sensor_dropout": {"begin": 3.0, "length": 0.4},
    "sensor_spikes": {"height": 1.0, "often": 1.0, "seed": 3.0},
    "sensor_quantisation": {"step": 0.05},
    "sensor_clipping": {"level": 1.0},
}


def with_fault(recording, name, channel="acc_floor1"):
    columns = {n: recording.column(n) for n in recording.names}
    fault = vocabulary()[name](channel).with_values({})
    fault = type(fault)(channel, **FAULTS[name])
    return Recording.build(
        recording.sampling_hz, fault.distort(columns, recording.sampling_hz), recording.source
    )


@pytest.fixture(scope="module")
def sound():
    return [recorded(lumped(), seed, source=f"seed{seed}.csv") for seed in (1, 2)]


def test_sound_recordings_have_no_fault(sound):
    ready = prepare(lumped(), sound[:1], sound[1:])
    assert not ready.faults
    assert not np.isnan(ready.train.recordings[0].y).any()


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_named_with_its_channel(sound, name):
    ready = prepare(lumped(), [with_fault(sound[0], name)], sound[1:])
    assert {(f.fault.name, f.fault.place) for f in ready.faults} == {(name, "acc_floor1")}


@pytest.mark.parametrize("name", ["sensor_dropout", "sensor_spikes", "sensor_clipping"])
def test_what_a_fault_hides_is_left_out_of_its_channel_alone(sound, name):
    faulty = with_fault(sound[0], name)
    ready = prepare(lumped(), [faulty], sound[1:])
    y = ready.train.recordings[0].y
    columns = list(ready.train.model.outputs)
    hidden = np.isnan(y[:, columns.index("acc_floor1")])
    wrong = faulty.column("acc_floor1") != sound[0].column("acc_floor1")
    assert np.mean(hidden[wrong]) > 0.75
    assert not np.isnan(y[:, columns.index("acc_floor2")]).any()
    assert any(name in note for note in ready.notes)


def test_coarse_steps_are_noise_of_their_channel(sound):
    plain = prepare(lumped(), sound[:1], sound[1:]).train.recordings[0]
    coarse = prepare(lumped(), [with_fault(sound[0], "sensor_quantisation")], sound[1:])
    after = coarse.train.recordings[0].output_noise
    assert after[0] > 0.05 / np.sqrt(12)
    assert after[1] == pytest.approx(plain.output_noise[1])


def test_a_blow_is_no_spike():
    rate, samples = 256.0, 3072
    force = np.zeros(samples)
    force[[300, 1500]] = 20.0, 12.0
    twin = lumped()
    moved = twin.simulate({"force_floor2": force}, rate, samples).columns
    draw = np.random.default_rng(5)
    columns = {"force_floor2": force} | {
        f"acc_floor{i}": moved[f"acc_floor{i}"] + 2e-3 * draw.standard_normal(samples)
        for i in (1, 2)
    }
    hit = Recording.build(rate, columns, "hit.csv")
    assert np.max(np.abs(np.diff(columns["acc_floor2"]))) > 3.0
    assert not prepare(twin, [hit], [recorded(twin, 2)]).faults


def test_a_jump_that_the_inputs_explain_is_no_spike(sound):
    reading = np.array(sound[0].column("acc_floor1"))
    reading[700] += 1.0
    given = ("seed1.csv", "acc_floor1", "acc", reading, sound[0].sampling_hz)
    for pushed, found in ((0.1, ["sensor_spikes"]), (1.0, [])):
        jumps = np.zeros(len(reading))
        jumps[700] = pushed
        faults, hidden = faults_in(*given, jumps)
        assert [f.fault.name for f in faults] == found
        assert hidden[700] == bool(found)


def test_steps_so_coarse_that_no_noise_is_seen_are_still_steps(sound):
    coarse = with_fault(sound[0], "sensor_quantisation")
    reading = 0.2 * np.round(coarse.column("acc_floor1") / 0.2)
    reading[300:] = 0.0  # the rest of a blow is below half a step
    found, hidden = faults_in("a.csv", "acc_floor1", "acc", reading, coarse.sampling_hz)
    (steps,) = [f for f in found if f.fault.name == "sensor_quantisation"]
    assert hidden[300:].all(), "its rounding errors are its motion"
    assert steps.share == hidden.mean()
    assert hidden[:300].sum() < 60
