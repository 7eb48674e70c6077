"""A diagnosis begins where mujoco.sysid ends: with its model and its time series."""

from dataclasses import dataclass
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

import twin
from twin.errors import ModelError, RecordingError
from twin.model.from_sysid import from_sysid

RATE = 64.0
SENSORS = ("acc_floor1", "acc_floor2")


@dataclass
class Kind:
    name: str


@dataclass
class Series:
    times: np.ndarray
    data: np.ndarray
    signal_mapping: dict | None = None


@dataclass
class Sequences:
    name: str
    spec: mujoco.MjSpec
    sequence_name: list
    control: list
    sensordata: list


@dataclass
class Softer:
    """A parameter as sysid has it: a name, a value, and an edit of the spec."""

    factor: float
    frozen: bool = False

    def apply_modifier(self, spec):
        stiffness = spec.joint("storey1").stiffness
        spec.joint("storey1").stiffness = self.factor * np.asarray(stiffness)


@pytest.fixture(scope="module")
def frame():
    return twin.Twin.load("two_storey_lumped")


@pytest.fixture(scope="module")
def shaken(frame):
    return twin.shaker_test(frame, "floor2", level_n=1.0, rate_hz=RATE, duration_s=8)


def mapped(names, kind, ending=""):
    return {f"{name}{ending}": (Kind(kind), np.array([i])) for i, name in enumerate(names)}


def series(recording, names, kind, ending=""):
    data = np.column_stack([recording.column(name) for name in names])
    return Series(recording.time, data, mapped(names, kind, ending))


@pytest.fixture
def sequences(frame, shaken):
    return Sequences(
        "frame", mujoco.MjSpec.from_string(frame.mjcf), ["run 1", "run 2"],
        [series(shaken, shaken.inputs, "MjCtrl", "_ctrl")] * 2,
        [series(shaken, SENSORS, "MjSensor")] * 2,
    )  # fmt: skip


def test_model_and_series_arrive_as_they_were(sequences, frame, shaken):
    model, recordings = from_sysid(sequences)
    assert [r.source for r in recordings] == ["frame, run 1", "frame, run 2"]
    np.testing.assert_allclose(model.modes().natural_freq, frame.modes().natural_freq, rtol=1e-6)
    first = recordings[0]
    assert (first.inputs, first.outputs) == (shaken.inputs, SENSORS)
    assert first.sampling_hz == RATE
    for name in (*shaken.inputs, *SENSORS):
        assert np.array_equal(first.column(name), shaken.column(name))
    assert [c.unit for c in first.channels] == ["N", "m/s^2", "m/s^2"]


def test_the_parameters_that_were_found_edit_the_model(sequences, frame):
    plain = frame.second_order().K[0, 0] - frame.second_order().K[1, 1]
    for softer, share in ((Softer(0.9), 0.9), (Softer(0.9, frozen=True), 1.0)):
        model, _ = from_sysid(sequences, {"k1": softer})
        K = model.second_order().K
        assert K[0, 0] - K[1, 1] == pytest.approx(share * plain, rel=1e-6)
    untouched, _ = from_sysid(sequences)
    assert untouched.second_order().K[0, 0] == pytest.approx(frame.second_order().K[0, 0])


def test_the_recordings_go_into_an_identification(sequences, frame):
    _, recordings = from_sysid(sequences)
    found = twin.identify(recordings[:1]).modal.natural_freq
    np.testing.assert_allclose(found, frame.modes().natural_freq, rtol=1e-3)


CART = """
<mujoco>
  <worldbody><body name="cart">
    <joint name="slide" type="slide" axis="1 0 0" stiffness="40" damping=".4"/>
    <geom type="box" size=".1 .1 .1" mass="1"/><site name="tip"/>
  </body></worldbody>
  <actuator><motor name="push" joint="slide"/></actuator>
  <sensor><accelerometer name="A1" site="tip"/><touch name="skin" site="tip"/></sensor>
</mujoco>
"""


def cart(sensed, control=None, times=None):
    time = np.arange(4) / 8 if times is None else times
    return Sequences(
        "cart", mujoco.MjSpec.from_string(CART), ["a"],
        [control or Series(np.arange(4) / 8, np.ones(4))], [sensed(time)],
    )  # fmt: skip


def test_a_vector_a_state_and_what_is_no_channel():
    data = np.arange(20.0).reshape(4, 5)

    def sensed(time):
        mapping = {
            "A1": (Kind("MjSensor"), [0, 1, 2]),
            "slide_qpos": (Kind("MjStateQPos"), [3]),
            "skin": (Kind("MjSensor"), [4]),
        }
        return Series(time, data, mapping)

    model, (run,) = from_sysid(cart(sensed))
    assert run.names == ("push", "A1.x", "A1.y", "A1.z", "slide_qpos")
    assert np.array_equal(run.column("slide_qpos"), data[:, 3])
    assert run.notes[0] == "left out, as it is no force or motion: skin"
    assert model.linear(("push",), ("slide_qpos",)).places("drift") == ("slide",)


def test_without_a_mapping_the_columns_are_the_models():
    _, (run,) = from_sysid(cart(lambda time: Series(time, np.ones((4, 4)))))
    assert run.names == ("push", "A1.x", "A1.y", "A1.z")


WRONG = {
    "another length": (lambda t: Series(t[:3], np.ones((3, 4))), "4 controls and 3 sensor samples"),
    "other times": (lambda t: Series(t + 0.05, np.ones((4, 4))), "0.4 steps apart; resample them"),
    "not uniform": (lambda t: Series(t**2, np.ones((4, 4))), "cart, a: sample 2: time is not unif"),
    "no such sensor": (
        lambda t: Series(t, np.ones((4, 1)), {"A9": (Kind("MjSensor"), [0])}),
        "no sensor or actuator 'A9'; there are A1, skin, push"),
    "too few columns": (
        lambda t: Series(t, np.ones((4, 1)), {"A1": (Kind("MjSensor"), [0, 1, 2])}),
        "'A1' is column 3 of 1"),
    "not finite": (lambda t: Series(t, np.full((4, 4), np.nan)), "sample 1 of channel 'A1.x'"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_belong_together_is_one_line(name):
    sensed, message = WRONG[name]
    with pytest.raises(RecordingError) as caught:
        from_sysid(cart(sensed))
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


def test_what_is_no_sequence_is_named():
    with pytest.raises(
        ModelError, match=r"a SimpleNamespace is no ModelSequences of mujoco\.sysid"
    ):
        from_sysid(SimpleNamespace(spec=None, control=[]))
    with pytest.raises(ModelError, match="2 sysid models: diagnose one model at a time"):
        from_sysid([1, 2])


def test_sysids_own_classes_are_taken(frame, shaken):
    from mujoco import sysid

    if not hasattr(sysid, "ModelSequences"):
        pytest.skip("mujoco.sysid is not complete: pip install 'mujoco[sysid]'")
    spec = mujoco.MjSpec.from_string(frame.mjcf)
    model = spec.compile()
    force = shaken.inputs[0]
    controls = np.zeros((shaken.samples, model.nu))
    controls[:, model.actuator(force).id] = shaken.column(force)
    kinds = [(name, sysid.SignalType.MjSensor) for name in SENSORS]
    felt = np.zeros((shaken.samples, 6))
    felt[:, [0, 3]] = np.column_stack([shaken.column(name) for name in SENSORS])
    sequences = sysid.ModelSequences(
        "frame", spec, "run", sysid.create_initial_state(model, np.zeros(model.nq)),
        sysid.TimeSeries.from_control_names(shaken.time, controls, model),
        sysid.TimeSeries.from_names(shaken.time, felt, model, kinds),
        allow_missing_sensors=True,
    )  # fmt: skip

    def edit(spec, parameter):
        spec.joint("storey1").stiffness = [parameter.value[0], 0.0, 0.0]

    found = sysid.ParameterDict()
    found.add(sysid.Parameter("k1", 400.0, 300.0, 600.0, modifier=edit))
    twin_of, (run,) = from_sysid(sequences, found)
    assert {f"{name}.x" for name in SENSORS} <= set(run.names)
    assert np.array_equal(run.column(force), shaken.column(force))
    K = twin_of.second_order().K
    assert K[0, 0] - K[1, 1] == pytest.approx(400.0, rel=1e-3)
