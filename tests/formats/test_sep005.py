"""SEP 005 time series in and out, checked by the proposal's own validator where it is there."""

import doctest

import numpy as np
import pytest

import twin.formats.sep005
from twin import read
from twin.errors import RecordingError
from twin.formats.sep005 import from_sep005, to_sep005
from twin.recording import Recording

X = np.array([0.0, 1.0, -0.5])
RECORDING = Recording.build(
    8.0, {"tip_force": X, "A3 [m/s^2]": 2 * X, "wheel [rad/s]": X}, "tap",
    kinds={"tip_force": "force"},
)  # fmt: skip
SERIES = {"data": X, "name": "A3", "unit_str": "g", "fs": 8.0}


def test_the_example_holds():
    result = doctest.testmod(twin.formats.sep005)
    assert result.attempted
    assert not result.failed


@pytest.mark.parametrize("start", [0.0, 2.5])
def test_what_goes_out_comes_back(start):
    there = Recording(8.0, RECORDING.channels, RECORDING.data, "tap", start)
    back = from_sep005(to_sep005(there))
    assert [c.title for c in back.channels] == [c.title for c in there.channels]
    assert np.array_equal(back.data, there.data)
    assert (back.sampling_hz, back.start_s) == (8.0, start)


def test_the_proposals_validator_accepts_what_goes_out():
    sep005 = pytest.importorskip("sdypy_sep005.sep005")
    sep005.assert_sep005(to_sep005(RECORDING))


def test_units_are_converted_and_the_interface_reads_series():
    recording = read([SERIES])
    assert recording.column("A3") == pytest.approx(9.80665 * X)
    assert read([SERIES], {"A3": "acc_floor1 [m/s^2]"}).column("acc_floor1") == pytest.approx(X)


@pytest.mark.parametrize(
    ("series", "message"),
    [
        ([], "there is no time series"),
        ([{"data": X, "name": "a", "unit_str": "g"}], "series 'a' has no 'fs'; SEP 005 asks for"),
        ([{"data": X, "fs": 8, "unit_str": "g"}], "series 1 has no 'name'"),
        ([SERIES | {"unit_str": "bananas"}], r"unknown unit \[bananas\]"),
        ([SERIES | {"fs": -1}], "the sampling rate -1 Hz is no positive number"),
        ([SERIES | {"data": ["a", "b"]}], "'A3' does not hold real numbers"),
        ([SERIES | {"time": [0, 1]}], "has 2 times for 3 samples"),
        ([SERIES | {"time": [0, 1, 5], "fs": None}], "sample 3: time is not uniform"),
        ([SERIES, SERIES | {"name": "b", "fs": 9.0}], "'A3 .g.' and 'b .g.' are not sampled tog"),
        ([SERIES, SERIES], "'A3' appears twice"),
    ],
)
def test_a_series_that_lacks_something_is_named(series, message):
    with pytest.raises(RecordingError, match=message) as caught:
        from_sep005(series)
    assert str(caught.value).startswith("SEP 005 time series: ")
