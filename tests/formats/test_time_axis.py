import numpy as np
import pytest

from twin.errors import RecordingError
from twin.formats.time_axis import roundest, uniform


def at(sample):
    return f"f.csv: row {sample + 2}"


@pytest.mark.parametrize("rate", [32.0, 50.0, 3.0, 400.0, 610.3515625, 44100.0, 1e6, 0.1, 1 / 3.7])
@pytest.mark.parametrize("start", [0.0, -2.5, 17.3, 12345.678])
def test_times_in_double_precision_give_the_exact_rate(rate, start):
    axis = uniform(start + np.arange(3000) / rate, at)
    assert axis.sampling_hz == pytest.approx(rate, rel=1e-15 if start == 0 else 1e-9)
    assert axis.start_s == start


@pytest.mark.parametrize(
    ("rate", "decimals"), [(32.0, 2), (2048.0, 4), (3.0, 1), (610.3515625, 4), (100.0, 2)]
)
def test_times_rounded_in_print_give_the_rate_within_their_rounding(rate, decimals):
    axis = uniform(np.round(np.arange(4000) / rate, decimals), at)
    assert axis.sampling_hz == pytest.approx(rate, rel=2 * axis.uncertainty)
    assert axis.uncertainty < 1.1 * 10**-decimals / (3999 / rate)
    if rate != 610.3515625:
        assert axis.sampling_hz == rate


@pytest.mark.parametrize("rate", [32.0, 100.0, 128.0, 610.3515625, 1000.0, 2048.0])
@pytest.mark.parametrize("digits", [6, 7, 9])
@pytest.mark.parametrize("start", [0.0, -1.0, 12.345])
def test_times_of_so_many_significant_digits_give_the_rate(rate, digits, start):
    time = np.array([float(f"{t:.{digits}g}") for t in start + np.arange(8000) / rate])
    axis = uniform(time, at)
    assert axis.sampling_hz == pytest.approx(rate, rel=2 * axis.uncertainty + 1e-12)
    assert axis.uncertainty < 1e-3


@pytest.mark.parametrize("digits", [5, 6, 7])
def test_a_missing_row_is_found_in_times_of_significant_digits(digits):
    whole = np.arange(4000) / 128
    time = np.array([float(f"{t:.{digits}g}") for t in np.delete(whole, 3000)])
    with pytest.raises(RecordingError, match=r"row 3002: .*1 sample is missing"):
        uniform(time, at)


@pytest.mark.parametrize(("rate", "decimals"), [(200.0, 2), (2048.0, 3), (25600.0, 3)])
def test_times_that_stand_because_of_their_rounding_give_the_rate_if_it_is_known(rate, decimals):
    samples = int(rate * 10**-decimals * 2e4)
    time = np.round(np.arange(samples) / rate, decimals)
    assert np.any(np.diff(time) == 0)
    assert uniform(time, at).sampling_hz == rate
    with pytest.raises(RecordingError, match=r"does not increase.*give the rate \(--rate HZ\)"):
        uniform(time[: samples // 10], at)
    with pytest.raises(RecordingError, match="does not increase"):
        uniform(np.sort(np.append(time, np.full(9, time[samples // 2]))), at)


def test_times_in_single_precision_are_uniform():
    time = (np.arange(20_000, dtype=np.float32) * np.float32(0.01)).astype(float)
    assert uniform(time, at).sampling_hz == 100.0


def test_a_clock_that_jitters_by_a_thousandth_of_a_step_is_uniform():
    jitter = np.random.default_rng(0).uniform(-5e-4, 5e-4, 1000)
    assert uniform((np.arange(1000) + jitter) / 128, at).sampling_hz == pytest.approx(128, 1e-5)


@pytest.mark.parametrize("off", [0.01, 0.3, -0.3, 0.9])
@pytest.mark.parametrize("sample", [1, 500, 998])
def test_one_time_that_is_off_is_named_by_its_row(off, sample):
    time = np.arange(1000.0)
    time[sample] += off
    with pytest.raises(RecordingError, match=rf"row {sample + 2}: time is not uniform.*off by"):
        uniform(time / 128, at)


def test_a_missing_row_is_named_with_the_step_and_how_far_it_is_off():
    time = np.delete(np.arange(100) / 50, 40)
    message = (
        r"row 42: time is not uniform: a step of 0.04 s where steps are 0.02 s \(off by 100 %\): "
        r"1 sample is missing; cut the file there"
    )
    with pytest.raises(RecordingError, match=message):
        uniform(time, at)


@pytest.mark.parametrize("rate", [50, 48.7, 32, 2.3])
def test_a_shifted_time_and_a_missing_row_are_found_in_times_rounded_in_print(rate):
    time = np.round(np.arange(2000) / rate, 2)
    time[700] += 0.01 if rate == 50 else 0.02
    with pytest.raises(RecordingError, match="row 702: time is not uniform"):
        uniform(time, at)
    time = np.round(np.delete(np.arange(2000), 700) / rate, 2)
    with pytest.raises(RecordingError, match="row 702: time is not uniform"):
        uniform(time, at)


@pytest.mark.parametrize("samples", range(2, 40))
def test_few_times_rounded_in_print_are_uniform(samples):
    for rate in (32.0, 33.3, 47.1):
        uniform(np.round(0.123 + np.arange(samples) / rate, 2), at)


@pytest.mark.parametrize("value", [3.0, 2.9, -1.0])
def test_time_that_stands_or_goes_back_is_named_by_its_row(value):
    time = np.arange(10.0)
    time[4] = value
    with pytest.raises(RecordingError, match="row 6: time does not increase"):
        uniform(time, at)


def test_times_printed_with_too_few_digits_for_their_rate_are_refused():
    with pytest.raises(RecordingError, match=r"time does not increase|not uniform"):
        uniform(np.round(np.arange(100) / 150, 2), at)


def test_a_slowly_changing_rate_is_not_uniform():
    time = np.cumsum(1 + 1e-4 * np.arange(1000) / 1000)
    with pytest.raises(RecordingError, match="not uniform"):
        uniform(time, at)


@pytest.mark.parametrize("time", [[-1e308, 1e308], [0, 1e300], [1e16, 3e16]])
def test_absurd_times_are_refused(time):
    with pytest.raises(RecordingError, match="no times in seconds"):
        uniform(np.array(time), at)


@pytest.mark.parametrize(
    ("rate", "uncertainty", "expected"),
    [
        (1 / 1.6384e-3, 5e-6, 1 / 1.6384e-3),
        (1 / 0.333333, 5e-6, 3.0),
        (99.99998, 1e-6, 100.0),
        (99.99998, 1e-8, 99.99998),
    ],
)
def test_the_roundest_rate_or_period_within_the_uncertainty_is_taken(rate, uncertainty, expected):
    assert roundest(rate, uncertainty) == expected
