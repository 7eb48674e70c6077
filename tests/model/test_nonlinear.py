"""Elements of a user's model that are not linear: found, named, and sized."""

import numpy as np
import pytest
from test_linear import inertial, mjcf

from twin.model import Twin
from twin.model.amplitudes import effects
from twin.model.contents import nonlinear_elements
from twin.model.free_run import free_run


def one(joint="", tendon="", rest="", gravity=9.81, axis="1 0 0"):
    body = (
        f'<body name="m"><joint name="spring" type="slide" axis="{axis}" stiffness="400" '
        f'damping="2" {joint}/>{inertial(2)}<site name="s"/></body>'
    )
    tendon = f'<tendon><fixed name="rod" {tendon}><joint joint="spring" coef="1"/></fixed></tendon>'
    rest += (
        '<actuator><motor name="push" joint="spring"/></actuator>'
        '<sensor><accelerometer name="acc" site="s"/></sensor>'
    )
    return Twin(mjcf(body, tendon + rest, gravity))


def of(twin):
    return nonlinear_elements(twin.compile())


def test_a_linear_model_has_none():
    assert of(one()) == ()
    for name in ("two_storey_lumped", "two_storey", "portal_3d"):
        assert of(Twin.load(name)) == ()


@pytest.mark.parametrize(
    ("joint", "tendon", "mechanism", "values"),
    [
        ('stiffness="400 0 1.5e6"', "", "cubic_stiffness", {"stiffness": 1.5e6}),
        ('stiffness="400 70 0"', "", "quadratic_stiffness", {"stiffness": 70}),
        ('damping="2 0.5 0"', "", "quadratic_drag", {"coefficient": 0.5}),
        ('frictionloss="0.3"', "", "coulomb_friction", {"force": 0.3}),
        (
            'springyield="0.01"',
            "",
            "hysteresis",
            {"stiffness": 400, "yield_force": 4, "sharpness": 20, "replaced": 400},
        ),
        (
            "",
            'stiffness="90" springlength="-0.002 0.002"',
            "clearance",
            {"stiffness": 90, "gap": 0.002, "replaced": 0},
        ),
        ("", 'stiffness="0 0 8"', "cubic_stiffness", {"stiffness": 8}),
        ("", 'frictionloss="0.1"', "coulomb_friction", {"force": 0.1}),
    ],
)
def test_what_the_vocabulary_knows_is_named_with_its_values(joint, tendon, mechanism, values):
    text = one("", tendon).mjcf
    for attribute in joint.split('" ') if joint else ():
        key = attribute.split("=")[0]
        old = {"stiffness": 'stiffness="400"', "damping": 'damping="2"'}.get(key)
        text = (
            text.replace(old, attribute)
            if old
            else text.replace("/><inertial", f" {attribute}/><inertial")
        )
    (found,) = of(Twin(text))
    assert found.mechanism == mechanism
    assert dict(found.values) == pytest.approx(values)
    assert found.port == ("spring" if joint else "rod")
    assert found.port in found.element


def test_the_linear_equations_take_only_the_linear_part():
    plain = one().linear(["push"], ["acc"])
    other = one(
        'frictionloss="1" springyield="0.01"', 'stiffness="90 0 7" springlength="-0.01 0.02"'
    )
    other = Twin(other.mjcf.replace('damping="2"', 'damping="2 9 1"')).linear(["push"], ["acc"])
    np.testing.assert_allclose(other.K, plain.K, rtol=1e-12)
    np.testing.assert_allclose(other.R, plain.R, rtol=1e-12)


def test_a_one_sided_spring_is_two_bumpers_and_one_never_reached_does_nothing():
    near, far = of(one("", 'stiffness="90" springlength="-1000 0.001"'))[::-1]
    assert (near.mechanism, near.values["gap"]) == ("bumper", 0.001)
    twin = one("", 'stiffness="90" springlength="-1000 0.001"')
    model = twin.linear(["push"], ["acc"])
    force = np.sin(np.arange(400) / 10)[:, None]
    first, second = effects(model, of(twin), force, 100)
    assert first.element.values["gap"] == 0.001
    assert first.share > 0.01
    assert (second.element.values["gap"], second.share) == (far.values["gap"], 0)


def test_a_cubic_spring_that_sags_is_cubic_and_quadratic_about_its_rest():
    twin = Twin(one(axis="0 0 1").mjcf.replace('stiffness="400"', 'stiffness="400 0 1e6"'))
    square, cube = of(twin)
    roots = np.roots([1e6, 0, 400, 2 * 9.81])
    sag = float(roots[np.isreal(roots)].real[0])
    assert (square.mechanism, cube.mechanism) == ("quadratic_stiffness", "cubic_stiffness")
    assert square.values["stiffness"] == pytest.approx(3e6 * sag, rel=1e-9)


@pytest.mark.parametrize(
    ("joint", "tendon", "words"),
    [
        ('limited="true" range="-0.1 0.2"', "", "stops -0.1 and 0.2 from rest"),
        ("", 'stiffness="90" springlength="0.001 0.002"', "a spring of 90 with a dead band from"),
        ("", 'damping="0 0 3"', "damping c v^3 with c = 3"),
    ],
)
def test_what_the_vocabulary_does_not_know_is_named_by_its_element(joint, tendon, words):
    (found,) = of(one(joint, tendon))
    assert found.mechanism == ""
    assert words in str(found)


def test_the_effect_of_a_small_cubic_spring_is_that_of_a_simulation():
    twin = Twin(one().mjcf.replace('stiffness="400"', 'stiffness="400 0 1e5"'))
    rng = np.random.default_rng(4)
    force = 0.2 * rng.standard_normal(1000)
    model = twin.linear(["push"], ["acc"])
    (effect,) = effects(model, of(twin), force[:, None], 100)
    true = twin.simulate({"push": force}, 100, 1000).column("acc")
    without = one().simulate({"push": force}, 100, 1000).column("acc")
    change = np.sqrt(np.mean((true - without) ** 2) / np.mean(without**2))
    assert 1e-4 < change < 0.1
    assert effect.share == pytest.approx(change, rel=0.05)
    assert "joint spring: a spring with 1e+05 d^3" in str(effect)


def test_a_motor_beyond_its_range_is_a_saturation():
    twin = Twin(
        one().mjcf.replace('joint="spring"/></act', 'joint="spring" ctrlrange="-2 2"/></act')
    )
    model = twin.linear(["push"], ["acc"])
    assert effects(model, of(twin), np.full((50, 1), 1.9), 100)[0].share == 0
    assert effects(model, of(twin), np.full((50, 1), 2.1), 100)[0].share == np.inf


def test_curved_couplings_fluids_and_contacts_are_named():
    fluid = one().mjcf.replace("<option ", '<option density="1.2" ')
    assert [str(e) for e in of(Twin(fluid))] == ["option: drag in a fluid of density 1.2 kg/m^3"]
    pair = (
        f'<body><joint name="a" type="slide" axis="1 0 0" stiffness="9"/>{inertial(1)}</body>'
        f'<body><joint name="b" type="slide" axis="1 0 0" stiffness="9"/>{inertial(1)}</body>'
    )
    tie = '<equality><joint name="cam" joint1="a" joint2="b" polycoef="0 1 3 0 0"/></equality>'
    (found,) = of(Twin(mjcf(pair, tie)))
    assert found.element == "equality cam"


def test_limits_and_delays_of_instruments_are_faults_of_their_channels():
    text = one().mjcf.replace('name="acc"', 'name="acc" cutoff="0.4" delay="0.02" nsample="50"')
    text = text.replace('<motor name="push"', '<motor name="push" delay="0.01" nsample="50"')
    twin = Twin(text)
    found = {e.mechanism: (e.port, dict(e.values)) for e in of(twin)}
    assert found == {
        "sensor_clipping": ("acc", {"level": 0.4}),
        "sensor_delay": ("acc", {"delay": 0.02}),
        "motor_delay": ("push", {"delay": 0.01}),
    }
    model = twin.linear(["push"], ["acc"])
    gentle = {e.element.mechanism: e.share for e in effects(model, of(twin), np.ones((9, 1)), 100)}
    assert gentle["sensor_clipping"] == np.inf
    soft = effects(model, of(twin), np.full((9, 1), 0.1), 100)
    assert {e.element.mechanism: e.share for e in soft}["sensor_clipping"] == 0


def pendulum(tilt=0.0, more=""):
    body = (
        f'<body name="bob" euler="0 {tilt} 0"><joint name="pivot" type="hinge" '
        f'axis="0 1 0" damping="0.01"/>{inertial(0.5, -0.3)}{more}</body>'
    )
    rest = (
        '<actuator><motor name="push" joint="pivot"/></actuator>'
        '<sensor><jointpos name="angle" joint="pivot"/></sensor>'
    )
    return Twin(mjcf(body, rest))


def test_a_pendulums_weight_is_a_sine():
    (found,) = of(pendulum())
    assert (found.port, found.mechanism) == ("pivot", "cubic_stiffness")
    weight = 0.5 * 9.81 * 0.3
    assert found.values["stiffness"] == pytest.approx(-weight / 6, rel=1e-6)
    angle = np.linspace(-1, 1, 9)
    np.testing.assert_allclose(found.law(angle, 0), weight * (np.sin(angle) - angle), atol=1e-9)


def test_the_weight_of_a_pendulum_that_a_spring_holds_aside_is_even_too():
    aside = Twin(pendulum(0.5).mjcf.replace('damping="0.01"', 'damping="0.01" stiffness="4"'))
    found = {e.mechanism: e.values["stiffness"] for e in of(aside)}
    assert set(found) == {"cubic_stiffness", "quadratic_stiffness"}
    # rest: 4 d + m g l sin(tilt + d) = 0 with the springs at ease where the body was drawn
    weight, rest = 0.5 * 9.81 * 0.3, 0.0
    for _ in range(50):
        rest -= (4 * rest + weight * np.sin(0.5 + rest)) / (4 + weight * np.cos(0.5 + rest))
    assert found["cubic_stiffness"] == pytest.approx(-weight * np.cos(0.5 + rest) / 6, rel=1e-6)
    assert found["quadratic_stiffness"] == pytest.approx(-weight * np.sin(0.5 + rest) / 2, rel=1e-6)


def test_the_effect_of_a_pendulums_weight_is_that_of_a_simulation():
    twin = pendulum()
    torque = 0.25 * np.sin(np.arange(600) / 9)
    model = twin.linear(["push"], ["angle"])
    (effect,) = effects(model, of(twin), torque[:, None], 100)
    true = twin.simulate({"push": torque}, 100, 600).column("angle")
    linear = free_run(model, torque[:, None], 100)[:, 0]
    change = np.sqrt(np.mean((true - linear) ** 2) / np.mean(linear**2))
    assert 1e-3 < change < 0.1
    assert effect.share == pytest.approx(change, rel=0.1)


def test_hinges_that_carry_hinges_have_no_sine_of_their_own():
    arm = f'<body pos="0 0 -0.6"><joint name="elbow" type="hinge" axis="0 1 0"/>{inertial(0.2)}'
    assert of(pendulum(more=arm + "</body>")) == ()
