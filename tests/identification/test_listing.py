"""Which poles are listed as modes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from twin.identification.listing import listed_modes
from twin.identification.wide_band import WideFit


def found(zeta, std, families):
    return WideFit(
        fit=SimpleNamespace(w_min=5.0, w_max=35.0), diagram=(), families=families,
        leader=np.array([f[0] for f in families]),
        omega=np.array([30.0, 10.0, 20.0]), zeta=np.array(zeta),
        std=np.array([[0.1] * 3, std]),
    )  # fmt: skip


def test_a_damping_that_may_be_none_is_no_mode_and_modes_stand_by_frequency():
    alone = found([0.01] * 3, [0.001, 0.001, 0.006], [np.array([i]) for i in range(3)])
    assert list(listed_modes(alone)) == [1, 0]


def test_several_poles_of_one_shape_are_listed_however_far_apart_they_are():
    kin = [np.array([0]), np.array([1]), np.array([2, 3])]
    assert list(listed_modes(found([0.01] * 3, [0.001, 0.001, 0.006], kin))) == [1, 2, 0]


def test_more_poles_ask_for_more_certainty():
    """At 2.5 deviations one pole of one is a mode, one of three is too, of thirty is not."""
    few = found([0.01] * 3, [0.004] * 3, [np.array([i]) for i in range(3)])
    assert len(listed_modes(few)) == 3
    many = replace(
        few, families=[np.array([i]) for i in range(30)], omega=np.linspace(6.0, 34.0, 30),
        zeta=np.full(30, 0.01), std=np.full((2, 30), 0.004),
    )  # fmt: skip
    assert len(listed_modes(many)) == 0
