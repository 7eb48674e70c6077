"""Unusable data are said first, in one line each."""

import numpy as np
import pytest
from wide_support import OUTPUTS, RATE, record

from twin.identification import wide_result
from twin.identification.doubts import doubts_of_data, doubts_of_fit
from twin.identification.identify import identify
from twin.recording import Recording


def recording(change=None, seed=1, samples=4096, u=None):
    force, y = record(0, samples, 0.01, seed)
    columns = {"force_floor1": force[:, 0] if u is None else u}
    columns |= {f"acc_floor{i + 1}": y[:, i] for i in range(OUTPUTS)}
    if change:
        change(columns)
    return Recording.build(RATE, columns, source="hit.csv")


def doubts(r):
    outputs = tuple(f"acc_floor{i + 1}" for i in range(OUTPUTS))
    return doubts_of_data([r], ("force_floor1",), outputs)


def test_a_good_hit_raises_no_doubt():
    assert doubts(recording()) == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: c.update(acc_floor2=np.clip(c["acc_floor2"], -1, 1) * 1.0), "acc_floor2"),
        (lambda c: c["acc_floor3"].__setitem__(slice(3000, None), 0.0), "acc_floor3"),
        (lambda c: c.update(acc_floor2=c["acc_floor1"].copy()), "same signal"),
    ],
    ids=["saturated", "dead tail", "identical"],
)
def test_a_spoilt_channel_is_named(change, said):
    def scaled(columns):
        columns["acc_floor2"] = columns["acc_floor2"] / np.abs(columns["acc_floor2"]).max() * 3
        change(columns)

    lines = doubts(recording(scaled))
    assert lines
    assert any(said in line and line.startswith("warning") for line in lines)


def test_a_single_sine_cannot_tell_modes():
    t = np.arange(4096) / RATE
    lines = doubts(recording(u=np.sin(2 * np.pi * 60.3 * t)))
    assert any("near 60.2" in line or "near 60.5" in line for line in lines)


def test_random_shaking_is_no_single_sine():
    assert doubts(recording(u=np.random.default_rng(0).standard_normal(4096))) == []


def test_a_large_error_is_the_first_note(monkeypatch):
    monkeypatch.setattr(wide_result, "DATA", 1000)
    rng = np.random.default_rng(0)

    def noisy(columns):
        for name in [n for n in columns if n.startswith("acc")]:
            x = columns[name]
            columns[name] = x + 0.5 * x.std() * rng.standard_normal(len(x))

    found = identify([recording(noisy)], band_hz=(40, 700))
    assert found.notes[0].startswith("warning: the re-simulated outputs miss")
    assert doubts_of_fit(0.02, (1, 2)) == []
