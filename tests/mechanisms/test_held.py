"""What a user's model already holds becomes mechanisms of the base, or is named."""

from dataclasses import replace

import numpy as np
import pytest

from twin.errors import ModelError
from twin.estimation.laws import memory_along
from twin.mechanisms.held import gathered, held, mechanisms_of
from twin.mechanisms.microslip import SLIDERS, Microslip
from twin.model import Twin
from twin.model.amplitudes import effects
from twin.model.contents import nonlinear_elements

SPRING = 'name="storey2" type="slide" axis="1 0 0" stiffness="518.577777777778'


def chain(text):
    plain = Twin.load("two_storey_lumped").mjcf
    assert SPRING in plain
    return Twin(plain.replace(SPRING, text), "mine.xml")


def judged(twin, newton, allowed=0.01):
    force = newton * np.random.default_rng(1).standard_normal((800, 1))
    model = twin.linear(["force_floor2"], ["acc_floor1", "acc_floor2"])
    found = effects(model, nonlinear_elements(twin.compile()), force, 100)
    return held(found, allowed, twin.source)


def test_a_cubic_spring_of_the_users_own_is_a_mechanism_of_the_base():
    twin = chain(SPRING + " 0 1.5e6")
    result = judged(twin, 1.0)
    (cubic,) = result.mechanisms
    assert (cubic.name, cubic.place, cubic.values) == (
        *("cubic_stiffness", "storey2"),
        {"stiffness": 1.5e6},
    )
    assert "taken as cubic_stiffness at storey2" in result.notes[0]
    assert result.mechanisms == mechanisms_of(nonlinear_elements(twin.compile()))


def test_one_that_does_not_matter_is_a_note_with_its_number():
    result = judged(chain(SPRING + " 0 1.5e6"), 0.01)
    assert result.mechanisms == ()
    assert "joint storey2: a spring with 1.5e+06 d^3" in result.notes[0]
    assert "% of its RMS: left aside" in result.notes[0]


def test_one_that_the_vocabulary_does_not_have_is_named_where_it_matters():
    stops = SPRING.replace("stiffness", 'range="-0.001 0.001" limited="true" stiffness')
    assert judged(chain(stops), 1e-3).mechanisms == ()
    with pytest.raises(ModelError, match=r"mine\.xml: joint storey2: stops -0\.001 and 0\.001"):
        judged(chain(stops), 1.0)


def test_every_mechanism_that_is_named_can_be_made():
    text = SPRING.replace("stiffness", 'frictionloss="0.1" springyield="0.01" stiffness')
    names = {m.name for m in mechanisms_of(nonlinear_elements(chain(text).compile()))}
    assert names == {"coulomb_friction", "hysteresis"}


def slipping(softening=0.6, stiffness=150.0):
    law = Microslip("storey2", stiffness, softening, 0.3 * stiffness, 0.002, 500.0)
    return law, Twin.load("two_storey_lumped").including(law)


def test_the_sliders_of_an_exported_slip_are_one_law_that_does_as_they_do():
    law, twin = slipping()
    model, elements = (
        twin.linear(["force_floor2"], ["acc_floor2"]),
        nonlinear_elements(twin.compile()),
    )
    assert len(elements) == SLIDERS
    (one,) = mechanisms_of(gathered(elements, model))
    for name in ("stiffness", "softening", "reach"):
        assert one.as_json()["values"][name] == pytest.approx(law.as_json()["values"][name])
    drift = 0.004 * np.sin(np.linspace(0, 20, 3000)) * np.linspace(0, 1, 3000)

    def force(slip):
        memory = memory_along(slip.compiled, np.array(slip.numbers), drift)
        return slip.force(drift, 0.0, memory, 0.0)

    # the springs at rest are in the linear equations, and the law takes their place
    plain = Twin.load("two_storey_lumped").linear(["force_floor2"], ["acc_floor2"])
    with_slip, without = (
        1 / float(m.port("storey2") @ np.linalg.solve(m.K, m.port("storey2")))
        for m in (model, plain)
    )
    linear = (with_slip - without) * drift
    np.testing.assert_allclose(force(one) + linear, force(law), atol=1e-6)


def test_springs_that_yield_as_no_slip_does_stay_what_they_are():
    _, twin = slipping()
    elements = nonlinear_elements(twin.compile())
    model = twin.linear(["force_floor2"], ["acc_floor2"])
    assert len(gathered(elements[:-1], model)) == SLIDERS - 1
    other = replace(elements[3], values=dict(elements[3].values) | {"stiffness": 1.0})
    assert len(gathered([*elements[:3], other, *elements[4:]], model)) == SLIDERS
    cubic = nonlinear_elements(chain(SPRING + " 0 1.5e6").compile())
    assert gathered(cubic, model) == cubic
