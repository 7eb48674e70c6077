"""One contract for every mechanism: what it says as an edit and what it says as mathematics."""

import dataclasses
import json
import xml.etree.ElementTree as ElementTree
from functools import cache

import mujoco
import numpy as np
import pytest
from mechanism_support import RATE, SAMPLES, error, integrate, push

from twin import mechanisms
from twin.errors import ModelError
from twin.mechanisms.mechanism import ChannelFault, Law, StructuralChange, Surroundings
from twin.mechanisms.stiffness_drift import CLOCK
from twin.model import Twin

ALL = mechanisms.vocabulary()
INSTRUMENTS = [
    "sensor_hum",
    "sensor_drift",
    "sensor_offset",
    "sensor_crosstalk",
    "sensor_resonance",
    "sensor_dropout",
    "sensor_spikes",
    "sensor_quantisation",
    "clock",
]
VOCABULARY = [
    "stiffness",
    "damping",
    "coulomb_friction",
    "cubic_stiffness",
    "quadratic_stiffness",
    "bumper",
    "clearance",
    "hysteresis",
    "microslip",
    "stiffness_drift",
    "mass",
    "quadratic_drag",
    "appendage",
    "p_delta",
    "base_compliance",
    "unmeasured_force",
    "sensor_gain",
    "sensor_delay",
    "sensor_polarity",
    "sensor_clipping",
    "sensor_highpass",
    "sensor_swap",
    "pendulum_friction",
    "motor_deadband",
    "motor_delay",
    *INSTRUMENTS,
]
CHANNELS = ["acc_floor1", "acc_floor2", "disp_floor1", "disp_floor2", "force_floor2"]
CHANNELS += ["torque_pendulum"]
FLOORS = ["floor1", "floor2"]
DRIFT = 0.004 * np.sin(np.linspace(0, 60, 3000)) + 0.001 * np.sin(np.linspace(0, 210, 3000))
AROUND = Surroundings(
    518.6, 1.6, 0.65, 2.2, 0.3, DRIFT, np.gradient(DRIFT, 0.01), 50 * DRIFT, (1.9, 6.7), 30.0, 100.0
)


def make(name, place, *values):
    return ALL[name](place, *values)


UNNAMED = ALL["restoring_force"]("storey2").with_values(
    {"square": 0.2, "cube": -0.3, "right_1": 0.2, "right_4": 0.1, "right_6": -0.1, "left_2": 0.3}
    | {"left_5": 0.4, "viscous": 0.02, "drag": 0.01, "linear": 0.1}
)
CHANGES = [
    make("stiffness", "storey2", -50.0),
    make("damping", "storey1", 0.5),
    make("mass", "floor1", -0.2),
    make("appendage", "floor2", 0.1, 2.0, 0.02),
    make("base_compliance", "ground", 5e4, 10.0, 2.5),
    make("p_delta", "storey1", 1.0, 0.3),
]
LAWS = [
    # mechanism, error of the displacement, of the acceleration: RMS over RMS, at 1 ms
    (make("cubic_stiffness", "storey1", 5e6), 2e-7, 2e-6),
    (make("quadratic_stiffness", "storey2", 1e4), 2e-7, 2e-6),
    (make("stiffness_drift", "storey1", -0.1, 518.0), 2e-7, 2e-6),
    (make("quadratic_drag", "floor2", 20.0), 2e-7, 2e-6),
    (make("bumper", "storey1", 2000.0, 0.003), 5e-5, 5e-4),
    (make("bumper", "storey2", 2000.0, -0.002), 5e-5, 5e-4),
    (make("clearance", "storey2", 300.0, 0.001, 300.0), 1e-5, 1e-4),
    (make("clearance", "storey1", 300.0, 0.001, 0.0), 1e-5, 1e-4),
    (UNNAMED, 1e-5, 1e-3),
    (make("coulomb_friction", "storey2", 0.1, 1e-5), 2e-4, 2e-3),
    (make("hysteresis", "storey1", 300.0, 0.5, 20.0, 300.0), 0.005, 0.01),
    (make("hysteresis", "storey1", 300.0, 0.5, 2.0, 300.0), 0.1, 0.12),
    (make("microslip", "storey1", 200.0, 1.0, 200.0, 0.004), 1e-3, 3e-3),
]


@cache
def frame():
    return Twin.load("two_storey_lumped")


@cache
def absorber():
    return Twin.load("two_storey_absorber")


def rig(mechanism):
    return absorber() if mechanism.on == "actuator" else frame()


def at(cls):
    model = absorber().second_order()
    kinds = {name: name.split("_")[0] for name in CHANNELS}
    return mechanisms.places(cls, model, kinds)


def read_off(cls):
    """Whether a fault is read off the samples and not fitted: it is there or not."""
    return issubclass(cls, ChannelFault) and cls.found.__func__ is not ChannelFault.found.__func__


def example(cls):
    """A mechanism of a class as it would be found."""
    return next(iter(cls.starts(at(cls)[0], AROUND)), cls(at(cls)[0]))


def simulated(twin, samples=SAMPLES):
    columns = twin.simulate({"force_floor2": push(samples)}, RATE, samples).columns
    return tuple(
        np.column_stack([columns[f"{kind}_floor{i}"] for i in (1, 2)]) for kind in ("disp", "acc")
    )


def ident(thing):
    return thing.name if hasattr(thing, "name") else None


def test_the_vocabulary_is_complete():
    assert sorted(n for n, cls in ALL.items() if not cls.generic) == sorted(VOCABULARY)


def test_only_what_has_no_name_is_called_unexplained():
    assert [n for n, cls in ALL.items() if cls.verdict == "unexplained"] == ["restoring_force"]
    generic = [name for name, cls in ALL.items() if cls.generic]
    assert generic == ["restoring_force", "sensor_unexplained"]


@pytest.mark.parametrize("cls", ALL.values(), ids=ident)
def test_units_and_source_are_documented(cls):
    assert "Source:" in cls.__doc__
    assert cls.reference
    assert cls.verdict in ("parameter", "missing_physics", "measurement", "unexplained")
    for parameter in cls.parameters.values():
        assert parameter.unit
        assert parameter.meaning
    taken = {cls.fields_of.get(name, name) for name in cls.parameters}
    others = {f.name for f in dataclasses.fields(cls)} - taken - {"place"}
    for field in others:
        assert f"{field}:" in cls.__doc__, "a field that is not fitted stands under Attributes"


@pytest.mark.parametrize("cls", ALL.values(), ids=ident)
def test_first_guesses_are_few_finite_and_survive_json(cls):
    for place in at(cls):
        starts = cls.starts(place, AROUND)
        assert (0 if read_off(cls) else 1) <= len(starts) <= 16
        assert len(set(starts)) == len(starts)
        for start in starts:
            assert start.place == place
            assert all(np.isfinite(value) for value in start.values.values())
            logs = [n for n, p in cls.parameters.items() if p.scale == "log"]
            assert all(start.values[n] > 0 for n in logs)
            assert mechanisms.from_json(json.loads(json.dumps(start.as_json()))) == start


@pytest.mark.parametrize("cls", [c for c in ALL.values() if c.parameters], ids=ident)
def test_no_strength_changes_no_bit_of_the_motion(cls):
    place = at(cls)[0]
    none = cls(place)
    before = simulated(rig(none), 300)
    after = simulated(rig(none).including(none), 300)
    for one, other in zip(before, after, strict=True):
        assert one.tobytes() == other.tobytes()
    if issubclass(cls, ChannelFault):
        columns = {name: DRIFT for name in CHANNELS}
        assert none.distort(columns, 100.0)[none.channels[0]].tobytes() == DRIFT.tobytes()


@pytest.mark.parametrize("cls", [c for c in ALL.values() if issubclass(c, Law)], ids=ident)
def test_a_law_broadcasts_many_variants_and_grows_with_its_strength(cls):
    start = cls.starts(at(cls)[0], AROUND)[0]
    many = start.with_values({name: np.full((3, 1), v) for name, v in start.values.items()})
    drift, rate = AROUND.drift[:40], AROUND.rate[:40]
    state, time = 0.3 * np.sin(np.arange(40.0)), np.arange(40.0)
    if cls.memory:
        states = start.remember(np.zeros((cls.memory, 40)), np.zeros(40), drift)
        together = many.remember(np.zeros((cls.memory, 3, 40)), np.zeros(40), drift)
        np.testing.assert_allclose(together, np.repeat(states[:, None], 3, axis=1), rtol=1e-12)
        state = states.sum(axis=0)
    one = start.force(drift, rate, state, time)
    np.testing.assert_allclose(many.force(drift, rate, state, time), np.tile(one, (3, 1)))
    twice = start.scaled(2.0)
    if cls.memory:
        state = twice.remember(np.zeros((cls.memory, 40)), np.zeros(40), drift).sum(axis=0)
    np.testing.assert_allclose(twice.force(drift, rate, state, time), 2 * one, rtol=1e-9)


@pytest.mark.parametrize("change", CHANGES, ids=ident)
def test_a_change_of_the_structure_is_the_same_as_matrices_and_in_mujoco(change):
    assert isinstance(change, StructuralChange)
    found = frame().including(change).second_order()
    wanted = change.edit(frame().second_order())
    assert found.coordinates == wanted.coordinates
    for name in "MRK":
        true = getattr(wanted, name)
        np.testing.assert_allclose(getattr(found, name), true, atol=1e-9 * np.abs(true).max())


def test_changes_build_on_each_other_whatever_their_order():
    p_delta, mass = CHANGES[5], make("mass", "floor2", 1.0)
    found = frame().including(p_delta, mass).second_order()
    wanted = p_delta.edit(mass.edit(frame().second_order()))
    np.testing.assert_allclose(found.K, wanted.K, rtol=1e-10)
    lighter = p_delta.edit(frame().second_order())
    assert lighter.K[0, 0] - found.K[0, 0] == pytest.approx(9.81 * 1.0 / 0.3)


@pytest.mark.parametrize(("law", "moved", "accelerated"), LAWS, ids=ident)
def test_a_law_moves_the_frame_as_an_independent_integration_says(law, moved, accelerated):
    forces = np.zeros((SAMPLES, 2))
    forces[:, 1] = push()
    fine = 5 if law.memory else 10 if law.abrupt else 2
    true = integrate(frame().second_order(), forces, law, fine)
    found = simulated(frame().including(law))
    assert error(found[0], true[0]) < moved
    assert error(found[1], true[1]) < accelerated
    assert error(simulated(frame())[0], true[0]) > 0.05, "the test shows something"


@pytest.mark.parametrize("mechanism", [*CHANGES, *(m for m, _, _ in LAWS)], ids=ident)
def test_the_exported_file_moves_the_same_in_plain_mujoco(mechanism, tmp_path):
    twin = frame().including(mechanism)
    path = twin.export(tmp_path / "explained.xml")
    comment = ElementTree.tostring(ElementTree.parse(path).getroot(), encoding="unicode")
    assert "<!--" not in comment
    assert f"{mechanism.name} at {mechanism.place}" in path.read_text()
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for index in range(model.nu):
        if model.actuator(index).name.endswith(CLOCK):
            data.ctrl[index] = 1.0
    force, found = push(600), np.empty((600, 2))
    motor, sensors = data.actuator("force_floor2"), [data.sensor(f"disp_{f}") for f in FLOORS]
    steps = round(1 / (RATE * model.opt.timestep))
    middles = (np.arange(600 * steps) + 0.5) / steps
    for k, value in enumerate(np.interp(middles, np.arange(600), force)):
        motor.ctrl[:] = value
        mujoco.mj_step(model, data)
        if k % steps == 0:
            found[k // steps] = [sensor.data[0] for sensor in sensors]
    true = simulated(twin, 600)[0]
    # the file's clamp is soft, its force a staircase
    assert error(found, true) < (5e-4 if getattr(mechanism, "abrupt", False) else 1e-4)


@pytest.mark.parametrize("cls", ALL.values(), ids=ident)
def test_a_wrong_place_is_an_error_that_lists_the_places(cls):
    wrong = {"drift": "storey9", "motion": "floor9", "body": "floor9", "base": "floor1"}
    wrong |= {"channel": "acc_floor9", "channels": "acc_floor1+acc_floor9", "actuator": "pendulum"}
    there = {"drift": "storey1, storey2", "motion": "floor1, floor2", "body": "floor1, floor2"}
    there |= {"base": "ground", "channel": "acc_floor1", "channels": "acc_floor1"}
    there |= {"actuator": "pendulum"}
    start = example(cls)
    elsewhere = dataclasses.replace(start, place=wrong[cls.on])
    with pytest.raises(ModelError, match=there[cls.on]):
        frame().including(elsewhere)
    if issubclass(cls, StructuralChange):
        with pytest.raises(ModelError, match=there[cls.on]):
            elsewhere.edit(frame().second_order())


@pytest.mark.parametrize("name", ["sensor_resonance", "appendage", "unmeasured_force"])
def test_what_resonates_is_looked_for_where_something_is_unexplained(name):
    place = {"sensor_resonance": "acc_floor2"}.get(name, "floor2")
    peaks = (53.7, 11.3)
    for_each = {
        f.frequency for f in ALL[name].starts(place, dataclasses.replace(AROUND, peaks=peaks))
    }
    assert set(peaks) <= for_each
    assert not set(peaks) & {f.frequency for f in ALL[name].starts(place, AROUND)}
