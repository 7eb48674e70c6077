"""What a user's own model holds is part of every hypothesis; another model is refused."""

from dataclasses import replace

import numpy as np
import pytest

from twin.diagnosis.exported import twin_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.prepare import prepare
from twin.errors import ModelError
from twin.estimation.likelihood import evaluate
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
    assert with_it > evaluate(linear, z, derivatives=False).log_likelihood + 1000
    (element,) = nonlinear_elements(twin_of(twin, blank, z).compile())
    assert element.values["stiffness"] == 1.5e6


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
