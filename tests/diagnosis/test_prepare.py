"""Recordings that cannot be used are refused in one clear line; what is done to others is said."""

import re

import numpy as np
import pytest
from diagnosis_support import RATE, lumped, recorded, rng, tones

from twin.diagnosis.prepare import prepare
from twin.errors import RecordingError
from twin.mechanisms.scales import range_ends
from twin.model import Twin
from twin.recording import Recording

SAMPLES = 1024


def plain(seed=0, source=None, rate=RATE, samples=SAMPLES, **more):
    """A recording with the right channels; what is in them does not matter here."""
    draw = rng(seed)
    columns = {
        "force_floor2": tones(samples, rate, seed),
        "acc_floor1": draw.standard_normal(samples),
        "acc_floor2": draw.standard_normal(samples),
    }
    columns.update({k: v for k, v in more.items() if v is not None})
    for name in [k for k, v in more.items() if v is None]:
        columns.pop(name)
    return Recording.build(rate, columns, source or f"record{seed}.csv")


def refused(train, test, **options):
    with pytest.raises(RecordingError) as caught:
        prepare(lumped(), train, test, **options)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_a_channel_that_the_model_lacks_is_refused_with_those_it_has():
    odd = plain(1, acc_floor7=np.ones(SAMPLES))
    said = refused([odd], [plain(2)])
    assert "record1.csv: channel 'acc_floor7' is not in" in said
    assert said.endswith("`twin convert` with --map leaves out what is not wanted")
    for there in ("acc_floor1", "acc_floor2", "disp_floor1", "force_floor2", "acc_ground"):
        assert there in said
    assert "record9.csv" in refused([plain(1)], [plain(2), plain(9, disp_floor3=np.ones(SAMPLES))])


@pytest.mark.parametrize("force", [None, np.zeros(SAMPLES)], ids=["no force", "a force of nothing"])
def test_a_record_that_nothing_drives_is_refused(force):
    said = refused([plain(1), plain(3, force_floor2=force)], [plain(2)])
    assert said.startswith("record3.csv: nothing drives the structure")
    assert "acc_floor1, acc_floor2" in said


def test_a_test_that_is_trained_on_is_refused_by_its_data_whatever_its_name():
    same = plain(1, source="renamed.csv")
    said = refused([plain(1)], [same])
    assert "renamed.csv" in said
    assert "record1.csv" in said
    assert "unseen" in said


def test_a_test_of_the_same_name_but_other_samples_is_taken():
    prepare(lumped(), [plain(1)], [plain(2, source="record1.csv")])


def test_recordings_that_nobody_named_are_told_apart_by_their_data():
    prepare(lumped(), [plain(1, source="recording")], [plain(2, source="recording")])


@pytest.mark.parametrize("samples", [100, 400])
def test_too_little_data_is_refused_with_how_much_is_needed(samples):
    said = refused([plain(1, samples=samples)], [plain(2)])
    assert f"record1.csv: {samples} samples" in said
    assert "at least 480 samples" in said


def test_too_few_periods_of_the_slowest_mode_are_refused():
    said = refused([plain(1, rate=1024.0)], [plain(2, rate=1024.0)])
    assert "1 s are too little" in said
    assert "1.95 Hz" in said


def test_accelerometers_alone_do_not_hold_a_model_without_a_spring():
    limp = Twin(re.sub(r' stiffness="[^"]*"', "", lumped().mjcf), "limp.xml")
    with pytest.raises(RecordingError, match="no spring holds it; record a displacement"):
        prepare(limp, [plain(1)], [plain(2)])


def test_the_test_recordings_may_be_short():
    prepare(lumped(), [plain(1)], [plain(2, samples=100)])


def test_a_diagnosis_needs_both_kinds_of_recordings():
    assert "at least one training and one test" in refused([], [plain(2)])
    assert "at least one training and one test" in refused([plain(1)], [])


def test_no_output_in_common_is_refused():
    a, b = plain(1, acc_floor1=None), plain(2, acc_floor2=None)
    said = refused([a], [b])
    assert "no output channel that all recordings have" in said
    assert "record1.csv" in said
    assert "acc_floor2" in said


def test_a_mass_at_a_place_that_is_not_there_is_refused_with_those_that_are():
    said = refused([plain(1)], [plain(2)], added_mass={"record1.csv": {"floor3": 0.5}})
    assert said == ("record1.csv: no place 'floor3' for an added mass; there are floor1, floor2")


def test_an_added_mass_is_in_its_recording_alone():
    masses = {"record3.csv": {"floor2": 0.5}}
    ready = prepare(lumped(), [plain(1), plain(3)], [plain(2)], added_mass=masses)
    assert [dict(r.added_mass) for r in ready.train.recordings] == [{}, {"floor2": 0.5}]


def test_a_channel_of_the_laboratory_is_not_used_and_that_is_noted():
    warm = plain(1)
    warm = Recording.build(
        RATE, dict(zip(warm.names, warm.data.T, strict=True)) | {"oven [V]": np.ones(SAMPLES)},
        "warm.csv",
    )  # fmt: skip
    ready = prepare(lumped(), [warm], [plain(2)])
    assert "warm.csv: not in the model, so not used: oven" in ready.notes


def test_different_rates_are_brought_to_the_lowest_and_noted():
    ready = prepare(lumped(), [plain(1, rate=256.0, samples=2048), plain(3)], [plain(2)])
    assert ready.train.sampling_hz == RATE
    assert [len(r.y) for r in ready.train.recordings] == [1024, 1024]
    assert "record1.csv: resampled from 256 to 128 Hz" in ready.notes
    assert not [n for n in ready.notes if "record3" in n]


def test_a_resampled_motion_is_the_same_motion():
    fine = recorded(lumped(), 1, seconds=6.0, rate=256.0, noise=0.0)
    coarse = recorded(lumped(), 1, seconds=6.0, rate=128.0, noise=0.0, source="coarse.csv")
    ready = prepare(lumped(), [fine, coarse], [recorded(lumped(), 2, seconds=6.0)])
    one, other = (t.y[64:-64] for t in ready.train.recordings)
    assert np.abs(one - other).max() < 0.01 * np.abs(other).max()


def test_channels_that_not_all_recordings_have_are_left_out_and_noted():
    ready = prepare(lumped(), [plain(1), plain(3, disp_floor1=np.ones(SAMPLES))], [plain(2)])
    assert ready.train.model.outputs == ("acc_floor1", "acc_floor2")
    assert "not in every recording, so not used: disp_floor1" in ready.notes


def test_an_input_that_a_recording_lacks_is_zero_there():
    pushed = plain(3, force_floor1=tones(SAMPLES, seed=9))
    ready = prepare(lumped(), [plain(1), pushed], [plain(2)])
    assert ready.train.model.inputs == ("force_floor1", "force_floor2")
    assert not ready.train.recordings[0].u[:, 0].any()
    assert ready.train.recordings[1].u[:, 0].any()


def test_an_offset_of_an_accelerometer_is_taken_off_and_noted():
    values = rng(5).standard_normal(SAMPLES)
    values -= values.mean()
    ready = prepare(lumped(), [plain(1, acc_floor1=values + 3.0)], [plain(2)])
    column = ready.train.model.outputs.index("acc_floor1")
    np.testing.assert_allclose(ready.train.recordings[0].y[:, column], values, atol=1e-12)
    assert "record1.csv: acc_floor1 has an offset of 3 m/s^2" in ready.notes
    assert not [n for n in ready.notes if "record2" in n]


def test_blows_from_one_side_that_are_cut_off_are_no_offset():
    blows = np.where(rng(6).random(SAMPLES) < 0.2, 9.0, 0.0)
    values = rng(5).standard_normal(SAMPLES) + blows
    cut_off = np.clip(values - values.mean(), -1.5, 1.5)
    assert abs(cut_off.mean()) > 0.3
    ready = prepare(lumped(), [plain(1, acc_floor1=cut_off)], [plain(2)])
    column = ready.train.model.outputs.index("acc_floor1")
    np.testing.assert_array_equal(ready.train.recordings[0].y[:, column], cut_off)
    shifted = prepare(lumped(), [plain(1, acc_floor1=cut_off + 3.0)], [plain(2)])
    np.testing.assert_allclose(shifted.train.recordings[0].y[:, column], cut_off, atol=1e-9)


def test_a_tone_whose_ends_a_stop_bends_has_no_offset():
    angle = 2 * np.pi * np.arange(60 * SAMPLES) / 64
    bent = np.sin(angle) + 0.15 * np.cos(2 * angle)
    low, high = range_ends(bent)
    assert (low + high) / 2 < -0.1, "its ends are not even"
    ready = prepare(lumped(), [plain(1, samples=len(bent), acc_floor1=bent)], [plain(2)])
    assert not [note for note in ready.notes if "record1.csv: acc_floor1" in note]
    column = ready.train.model.outputs.index("acc_floor1")
    np.testing.assert_array_equal(ready.train.recordings[0].y[:, column], bent)


def test_a_driven_ground_is_released_and_that_is_said():
    driven = [
        plain(seed, samples=1200, force_floor2=None, force_ground=tones(1200, seed=seed))
        for seed in (1, 2)
    ]
    ready = prepare(lumped(), driven[:1], driven[1:])
    assert not ready.twin.clamped
    assert len(ready.train.model.coordinates) == 3
    assert "clamp is taken as undone" in " ".join(ready.notes)


def test_the_noise_of_a_channel_is_read_off_its_own_samples():
    quiet = recorded(lumped(), 1, noise=1e-3, seconds=8.0)
    ready = prepare(lumped(), [quiet], [recorded(lumped(), 2, noise=2e-2, seconds=8.0)])
    np.testing.assert_allclose(ready.train.recordings[0].output_noise, 1e-3, rtol=0.2)
    np.testing.assert_allclose(ready.test.recordings[0].output_noise, 2e-2, rtol=0.2)
