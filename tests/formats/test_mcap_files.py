"""MCAP: messages in JSON, a sample each; what is no such thing is said in one line."""

import json

import numpy as np
import pytest

from twin.errors import RecordingError, TwinError
from twin.formats import read_recording

writer = pytest.importorskip("mcap.writer")

X = np.array([0.0, 1.5, -2.25, 3.0, 0.125])
STEP_NS = 125_000_000
START_NS = 1_790_000_000_000_000_000


def written(path, topics, encoding="json"):
    """Write {topic: (messages, metadata, schema, times [ns])} and return the path."""
    with path.open("wb") as file:
        out = writer.Writer(file)
        out.start()
        for topic, (messages, metadata, properties, times) in topics.items():
            schema = json.dumps({"type": "object", "properties": properties}).encode()
            number = out.register_schema(topic, "jsonschema", schema)
            channel = out.register_channel(topic, encoding, number, metadata)
            for time, message in zip(times, messages, strict=True):
                data = message if isinstance(message, bytes) else json.dumps(message).encode()
                out.add_message(channel, int(time), data, int(time))
        out.finish()
    return path


def times(step=STEP_NS, start=START_NS, count=5):
    return start + step * np.arange(count)


def values(x=X, name="value", **more):
    return [{name: float(v), **more} for v in x]


def plain(times_ns=None, **changes):
    at = times() if times_ns is None else times_ns
    return {
        "/force_floor1": (values(), {"unit": "N"}, {}, at),
        "/acc_floor1": (values(2 * X), {}, {"value": {"unit": "g"}}, at),
    } | changes


def test_topics_become_channels_in_si_units(tmp_path):
    recording = read_recording(written(tmp_path / "r.mcap", plain()))
    assert [c.title for c in recording.channels] == ["force_floor1 [N]", "acc_floor1 [m/s^2]"]
    assert (recording.sampling_hz, recording.start_s) == (8.0, 0.0)
    assert np.array_equal(recording.column("force_floor1"), X)
    np.testing.assert_allclose(recording.column("acc_floor1"), 2 * 9.80665 * X)


def test_several_numbers_of_a_message_are_named_by_topic_and_field(tmp_path):
    messages = [{"a [g]": v, "force": {"x": 2 * v}} for v in X.tolist()]
    path = written(tmp_path / "r.mcap", {"/tip": (messages, {"force.x.unit": "N"}, {}, times())})
    recording = read_recording(path)
    assert [c.title for c in recording.channels] == ["tip.a [m/s^2]", "tip.force.x [N]"]


@pytest.mark.parametrize("names", [("timestamp", "sec", "nsec"), ("stamp", "sec", "nanosec")])
def test_a_message_own_stamp_is_its_time(tmp_path, names):
    stamp, sec, nano = names
    stamped = [
        {"value": v, stamp: {sec: int(t // 10**9), nano: int(t % 10**9)}}
        for v, t in zip(X.tolist(), times(), strict=True)
    ]
    rng = np.random.default_rng(0)
    logged = np.sort(times() + rng.integers(0, STEP_NS // 3, len(X)))
    topics = {"/acc_floor1": (stamped, {"unit": "m/s^2"}, {}, logged)}
    assert read_recording(written(tmp_path / "r.mcap", topics)).sampling_hz == 8.0


def test_times_that_wander_need_a_rate(tmp_path):
    wandering = times() + np.array([0, 9, -8, 7, -9]) * 1_000_000
    path = written(tmp_path / "r.mcap", plain(wandering))
    with pytest.raises(RecordingError, match=r"give the sampling rate \(--rate HZ\)"):
        read_recording(path)
    assert read_recording(path, None, 8.0).samples == len(X)


LOST = np.delete(times(count=len(X) + 1), 2)
REFUSED = {
    "a lost message": (plain(LOST), "has no uniform times: message 3: time is not uniform"),
    "another rate": (
        plain(**{"/disp_floor1": (values(), {"unit": "m"}, {}, times(2 * STEP_NS))}),
        "'force_floor1 [N]' and 'disp_floor1 [m]' are not sampled together: 8 Hz from 0 s and 4"),
    "a topic that begins later": (
        plain(**{"/disp_floor1": (values(), {"unit": "m"}, {}, times(start=START_NS + 10**9))}),
        "8 Hz from 0 s and 8 Hz from 1 s"),
    "no unit": ({"/A3": (values(), {}, {}, times())}, "column 'A3' has no unit"),
    "text": ({"/A3": (values(value="x"), {"unit": "g"}, {}, times())},
             "'A3 [g]' holds text in message 1, no number"),
    "a list": ({"/A3": ([{"v": [1, 2]}] * 5, {"unit": "g"}, {}, times())},
               "'A3 [g]' holds a list in message 1, no number"),
    "a field that comes and goes": (
        {"/A3": ([*values(X[:3]), {"other": 1.0}, *values(X[4:])], {"value.unit": "g"}, {},
                 times())}, "'A3.value [g]' is not in message 4"),
    "not a number": (
        {"/A3": ([*values(X[:4]), {"value": float("nan")}], {"unit": "g"}, {}, times())},
        "message 5, column 'A3 [g]': nan is not finite"),
    "no JSON": ({"/A3": ([b"{"] * 5, {"unit": "g"}, {}, times())}, "damaged, or no MCAP file"),
    "no messages": ({"/A3": ([], {"unit": "g"}, {}, [])}, "holds no messages"),
    "one message": ({"/A3": (values(X[:1]), {"unit": "g"}, {}, times(count=1))}, "1 sample in"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_one_line(tmp_path, name):
    topics, message = REFUSED[name]
    with pytest.raises(TwinError) as caught:
        read_recording(written(tmp_path / "r.mcap", topics))
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


def test_other_encodings_are_named(tmp_path):
    path = written(tmp_path / "r.mcap", plain(), encoding="cdr")
    with pytest.raises(RecordingError, match=r"'force_floor1' in cdr, .*write them in JSON"):
        read_recording(path)


@pytest.mark.parametrize("cut", [9, 100, -20, -1])
def test_a_cut_file_is_said_to_be_damaged(tmp_path, cut):
    path = written(tmp_path / "r.mcap", plain())
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(RecordingError, match=r"damaged, or no MCAP file|holds no messages"):
        read_recording(path)


def test_another_suffix_is_told(tmp_path):
    path = written(tmp_path / "r.csv", plain())
    with pytest.raises(RecordingError, match=r"this is an MCAP file; rename it to r\.mcap"):
        read_recording(path)
