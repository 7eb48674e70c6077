"""Recordings are used in the band that an analyser shows; what moves nothing is refused."""

import numpy as np
import pytest

from twin.diagnosis.prepare import prepare
from twin.diagnosis.shown import in_shown_band
from twin.errors import RecordingError
from twin.laboratory import Analyser, Experiment, Hammer, run
from twin.model import Twin
from twin.recording import Recording

RATE, SAMPLES = 256.0, 2048
WALL = """<mujoco><worldbody><body name="wall"><geom size=".1"/><site name="wall_site"/></body>
<body name="cart" pos="0 0 1"><joint name="spring" type="slide" axis="1 0 0" stiffness="400"
damping="1"/><geom size=".1" mass="1"/><site name="cart_site"/></body></worldbody>
<actuator><motor name="push" site="cart_site" gear="1 0 0 0 0 0"/>
<motor name="up" site="cart_site" gear="0 0 1 0 0 0"/>
<motor name="on_wall" site="wall_site" gear="1 0 0 0 0 0"/></actuator>
<sensor><accelerometer name="acc_cart" site="cart_site"/>
<accelerometer name="acc_wall" site="wall_site"/></sensor></mujoco>"""


def recorded(force, output, seed):
    draw = np.random.default_rng(seed)
    columns = {force: draw.standard_normal(SAMPLES), output: draw.standard_normal(SAMPLES)}
    kinds = {force: "force", output: "acc"}
    return Recording.build(RATE, columns, f"record{seed}.csv", kinds=kinds)


@pytest.mark.parametrize(
    ("force", "output", "words"),
    [
        ("on_wall", "acc_cart.x", "record1.csv: nothing in the model is moved by on_wall;"),
        ("up", "acc_cart.x", "record1.csv: nothing in the model is moved by up;"),
        ("push", "acc_wall.x", "record1.csv: nothing in the model moves acc_wall.x;"),
    ],
)
def test_a_channel_where_nothing_moves_is_refused_with_what_does(force, output, words):
    train, test = (recorded(force, output, seed) for seed in (1, 2))
    with pytest.raises(RecordingError) as caught:
        prepare(Twin(WALL, "wall"), [train], [test])
    said = str(caught.value)
    assert said.startswith(words)
    assert "what moves there is spring" in said
    assert "\n" not in said


def hit(width_s):
    experiment = Experiment(Hammer(width_s, 0.5), ("force_tip",), Analyser(RATE, 4.0))
    recording = run(experiment, Twin.load("cantilever"))
    model = Twin.load("cantilever").linear(recording.inputs, recording.outputs)
    draw = np.random.default_rng(3).standard_normal(recording.data.shape)
    level = 0.005 * np.sqrt(np.mean(recording.data**2, axis=0))
    noisy = Recording(RATE, recording.channels, recording.data + level * draw, "hit.csv")
    return noisy, model


def test_a_mode_where_an_analysers_filter_falls_off_is_left_out_and_that_is_said():
    recording, model = hit(0.008)
    notes = []
    (shown,) = in_shown_band([recording], model, notes)
    assert shown.sampling_hz == pytest.approx(200.0)
    assert len(notes) == 2
    assert notes[0].startswith("the mode at 118.6 Hz is stirred where an analyser's filter falls")
    assert notes[0].endswith("record at 303.7 Hz or more to have it")


def test_a_mode_that_nothing_stirs_there_changes_nothing():
    recording, model = hit(0.2)
    notes = []
    (shown,) = in_shown_band([recording], model, notes)
    assert shown is recording
    assert notes == []
