import numpy as np
import pytest

from twin.errors import RecordingError
from twin.recording import Recording
from twin.signals.sections import resample_recording, trim_seconds


def recording(rate=50.0, samples=1000, start=0.0):
    time = start + np.arange(samples) / rate
    columns = {"force_floor1": np.sin(2 * np.pi * 3 * time), "acc_floor1": np.cos(time)}
    return Recording.build(rate, columns, "r.csv", start, ("a note",))


def test_resampling_keeps_start_notes_and_the_signals_between_the_samples():
    faster = resample_recording(recording(start=2.0), 128.0)
    assert (faster.sampling_hz, faster.start_s, faster.notes) == (128.0, 2.0, ("a note",))
    inside = slice(128, -128)
    expected = np.sin(2 * np.pi * 3 * faster.time)
    assert np.abs(faster.column("force_floor1") - expected)[inside].max() < 1e-4
    assert np.abs(faster.column("acc_floor1") - np.cos(faster.time))[inside].max() < 1e-4


@pytest.mark.parametrize("rate", [0.0, -5.0, np.nan, np.inf])
def test_a_new_rate_that_is_no_positive_number_is_refused(rate):
    with pytest.raises(RecordingError, match=r"r\.csv: cannot resample to"):
        resample_recording(recording(), rate)


@pytest.mark.parametrize("rate", [0.01, 1e12])
def test_absurd_numbers_of_samples_are_refused(rate):
    with pytest.raises(RecordingError, match="would give"):
        resample_recording(recording(), rate)


def test_rates_without_a_ratio_of_whole_numbers_are_one_line():
    with pytest.raises(RecordingError, match=r"r\.csv: .*ratio"):
        resample_recording(recording(), 50 * np.pi / 3.3)


def test_trimming_is_half_open_and_in_the_recordings_own_time():
    part = trim_seconds(recording(start=10.0), 10.1, 10.3)
    assert part.time == pytest.approx(10.1 + np.arange(10) / 50)
    assert np.array_equal(part.data, recording(start=10.0).data[5:15])


def test_rounding_of_the_times_moves_no_boundary():
    tenths = recording(rate=10.0, start=0.1)
    assert tenths.time[7] < 0.8
    assert trim_seconds(tenths, 0.8, None).start_s == pytest.approx(0.8)
    assert trim_seconds(tenths, None, 0.8).samples == 7


def test_an_open_end_keeps_everything_there():
    assert trim_seconds(recording(), None, 1.0).samples == 50
    assert trim_seconds(recording(), 1.0, None).samples == 950
    assert trim_seconds(recording(), -5.0, 500.0).samples == 1000


@pytest.mark.parametrize("bounds", [(5.0, 5.0), (6.0, 5.0), (100.0, None), (None, 0.02)])
def test_nothing_left_is_refused_with_the_times_there_are(bounds):
    with pytest.raises(RecordingError, match=r"it lasts from 0 s to 19\.98 s"):
        trim_seconds(recording(), *bounds)


@pytest.mark.parametrize("bounds", [(np.nan, 5.0), (1.0, np.nan)])
def test_a_bound_that_is_no_number_is_refused(bounds):
    with pytest.raises(RecordingError, match="fewer than two samples"):
        trim_seconds(recording(), *bounds)
