"""What a user's model already holds becomes mechanisms of the base, or is named."""

import numpy as np
import pytest

from twin.errors import ModelError
from twin.mechanisms.held import held, mechanisms_of
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
