"""What a user's own model holds is part of every hypothesis; another model is refused."""

from dataclasses import replace

import numpy as np
import pytest

from twin.diagnosis.exported import twin_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.known import shifts, unknowns_of, valued
from twin.diagnosis.prepare import prepare
from twin.errors import ModelError
from twin.estimation.fit import fit
from twin.estimation.likelihood import evaluate
from twin.mechanisms import vocabulary
from twin.model import Twin
from twin.model.contents import nonlinear_elements
from twin.recording import Recording

SPRING = 'name="storey2" type="slide" axis="1 0 0" stiffness="518.577777777778'
RATE, SAMPLES = 128.0, 1500


def chain(extra=" 0 1.5e6"):
    return Twin(Twin.load("two_storey_lumped").mjcf.replace(SPRING, SPRING + extra), "mine.xml")


def recording(twin, seed, newton=1.0):
    rng = np.random.default_rng(seed)
    force = newton * np.convolve(rng.standard_normal(SAMPLES), np.ones(4) / 4, "same")
    motion = twin.simulate({"force_floor2": force}, RATE, SAMPLES)
    columns = {name: motion.column(name) for name in ("acc_floor1", "acc_floor2")}
    columns = {n: x + 0.01 * np.std(x) * rng.standard_normal(SAMPLES) for n, x in columns.items()}
    return Recording.build(RATE, {"force_floor2": force} | columns, f"r{seed}")


def test_a_spring_of_the_users_own_is_in_every_hypothesis_and_never_exported_twice():
    twin = chain()
    ready = prepare(twin, [recording(twin, 1)], [recording(twin, 2)])
    (known,) = ready.train.known
    assert (known.name, known.place, known.stiffness) == ("cubic_stiffness", "storey2", 1.5e6)
    assert ready.test.known == ready.train.known
    assert any("taken as cubic_stiffness at storey2" in note for note in ready.notes)
    blank = Hypothesis(ready.train)
    z = np.zeros(len(blank.unknowns))
    linear = Hypothesis(replace(ready.train, known=(), known_scales=None))
    with_it = evaluate(blank, z, derivatives=False).log_likelihood
    assert (
        with_it
        > evaluate(linear, np.zeros(len(linear.unknowns)), derivatives=False).log_likelihood + 1000
    )
    (element,) = nonlinear_elements(twin_of(twin, blank, z).compile())
    assert element.values["stiffness"] == 1.5e6


def test_a_value_of_the_users_own_is_estimated_with_the_rest_and_exported():
    true, model = chain(" 0 1.6e6"), chain(" 0 1.5e6")
    ready = prepare(model, [recording(true, 1), recording(true, 3)], [recording(true, 2)])
    blank = Hypothesis(ready.train)
    found = fit(blank)
    (name,) = (n for n in found.values if n.startswith("known"))
    assert found.values[name] == pytest.approx(1.6e6, abs=3 * found.deviations[name])
    assert found.deviations[name] < 0.02e6
    (value,) = (m.stiffness for m in ready.train.known_at(found.z))
    assert value == pytest.approx(found.values[name])
    (note,) = shifts(ready.train.known, ready.train.of_known, *own(ready.train, found))
    assert "cubic_stiffness at storey2" in note
    assert "1.5e+06 in the model" in note
    again = prepare(twin_of(model, blank, found.z), [recording(true, 1)], [recording(true, 2)])
    assert sum(m.stiffness for m in again.train.known) == pytest.approx(value, rel=1e-6)


def own(problem, found):
    last = len(problem.base_unknowns)
    part = slice(last - len(problem.of_known), last)
    return found.z[part], np.sqrt(np.diag(found.covariance))[part]


def test_a_law_of_the_users_own_is_no_more_exact_than_one_that_is_found():
    ready = prepare(chain(), [recording(chain(), 1)], [recording(chain(), 2)])
    assert Hypothesis(ready.train).ports == ("storey2",)


def test_a_share_goes_with_its_whole():
    gap = vocabulary()["clearance"]("storey2").with_values(
        {"stiffness": 300.0, "gap": 1e-3, "replaced": 150.0}
    )
    z = np.array([1.0, 0.0])
    (moved,) = valued((gap,), unknowns_of((gap,), 0.1), z)
    assert moved.stiffness == pytest.approx(300 * np.exp(0.1))
    assert moved.replaced == pytest.approx(150 * np.exp(0.1))
    assert moved.gap == pytest.approx(1e-3)


def test_a_linear_model_holds_nothing_and_gets_no_note():
    twin = Twin.load("two_storey_lumped")
    ready = prepare(twin, [recording(twin, 1)], [recording(twin, 2)])
    assert ready.train.known == ()
    assert ready.notes == ()


def test_what_the_vocabulary_does_not_have_is_named():
    twin = chain('" range="-0.001 0.001" limited="true')
    good = Twin.load("two_storey_lumped")
    with pytest.raises(ModelError, match=r"mine\.xml: joint storey2: stops -0\.001 and 0\.001"):
        prepare(twin, [recording(good, 1)], [recording(good, 2)])


def test_a_two_link_arm_that_swings_freely_is_refused_by_its_joint():
    link = '<inertial pos="0 0 -0.3" mass="1" diaginertia="0.001 0.001 0.001"/>'
    arm = Twin(
        f"""<mujoco><option timestep="0.002"/><worldbody>
        <body><joint name="shoulder" axis="0 1 0" damping="0.02"/>{link}
        <body pos="0 0 -0.6"><joint name="elbow" axis="0 1 0" damping="0.02"/>{link}
        <site name="hand" pos="0 0 -0.6"/></body></body></worldbody>
        <actuator><motor name="motor" joint="shoulder"/></actuator>
        <sensor><jointpos name="angle_1" joint="shoulder"/>
        <jointpos name="angle_2" joint="elbow"/></sensor></mujoco>""",
        "arm.xml",
    )
    rng = np.random.default_rng(3)
    made = []
    for name in ("a", "b"):
        torque = 20 * rng.standard_normal(SAMPLES)
        motion = arm.simulate({"motor": torque}, RATE, SAMPLES)
        columns = {"motor": torque} | {n: motion.column(n) for n in ("angle_1", "angle_2")}
        kinds = {"motor": "torque", "angle_1": "angle", "angle_2": "angle"}
        made.append(Recording.build(RATE, columns, name, kinds=kinds))
    with pytest.raises(ModelError, match=r"arm\.xml: .* joint (elbow|shoulder) turns by up to"):
        prepare(arm, made[:1], made[1:])


def test_a_stiffness_that_drifts_in_the_model_is_read_back():
    drifting = vocabulary()["stiffness_drift"]("storey2", 4e-3, 518.0)
    twin = Twin.load("two_storey_lumped").including(drifting)
    ready = prepare(twin, [recording(twin, 1)], [recording(twin, 2)])
    (known,) = ready.train.known
    assert (known.name, known.place) == ("stiffness_drift", "storey2_stiffness_drift")
    assert known.rate == pytest.approx(4e-3 * 518.0)
    linear = Hypothesis(replace(ready.train, known=(), known_scales=None))
    with_it, without = (
        evaluate(h, np.zeros(len(h.unknowns)), derivatives=False).log_likelihood
        for h in (Hypothesis(ready.train), linear)
    )
    assert with_it > without + 100


def test_friction_that_creeps_in_mujoco_is_refused_with_what_makes_it_dry():
    dry = '" solreffriction="-1 -15000" solimpfriction="0.999 0.999" frictionloss="0.1'
    rubs = Twin(chain(dry).mjcf.replace('timestep="0.001"', 'timestep="0.0001"'), "dry.xml")
    made = [recording(rubs, 1), recording(rubs, 2)]
    (known,) = prepare(rubs, made[:1], made[1:]).train.known
    assert known.name == "coulomb_friction"
    with pytest.raises(ModelError, match="creep: beside frictionloss, write") as refused:
        prepare(chain('" frictionloss="0.1'), made[:1], made[1:])
    for words in (*dry.split()[1:-1], 'timestep="0.0001"'):
        assert words in str(refused.value)


def test_friction_of_the_model_is_as_sharp_beside_a_gentle_motion():
    dry = '" solreffriction="-1 -15000" solimpfriction="0.999 0.999" frictionloss="1e-4'
    rubs = Twin(chain(dry).mjcf.replace('timestep="0.001"', 'timestep="0.0001"'), "dry.xml")
    ready = prepare(rubs, [recording(rubs, 1, 1e-3)], [recording(rubs, 2, 1e-3)])
    (known,), scales = ready.train.known, ready.train.known_scales
    assert known.regular_rate == pytest.approx(1e-3 * scales.at("storey2")[2])
