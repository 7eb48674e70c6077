"""Choosing poles in a stabilisation diagram with the mouse."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from matplotlib.backend_bases import MouseEvent
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from twin.errors import TwinError
from twin.identification.pole_diagram import PoleDiagram
from twin.identification.stabilisation import StablePole
from twin.view.poles import KINDS, REFUSED, PoleChoice, kinds, pick_by_hand

ALL = frozenset(("frequency", "damping", "shape"))


def pole(order, hz, steady=ALL):
    value = 2 * np.pi * hz * (-0.01 + 1j)
    return StablePole(order, value, np.ones(2, complex), steady == ALL, steady)


@pytest.fixture
def choice():
    poles = [pole(n, f) for n in (10, 20, 30) for f in (10.0, 40.0)]
    freq = np.linspace(0, 50, 100)
    diagram = PoleDiagram(tuple(poles), freq, np.ones((100, 2)), "frequency responses")
    figure = Figure(figsize=(8, 5))
    FigureCanvasAgg(figure)
    made = PoleChoice(figure, diagram)
    figure.canvas.draw()
    return made


def click(choice, hz, order, off=0.0):
    x, y = choice.axes.transData.transform((hz, order))
    canvas = choice.figure.canvas
    canvas.callbacks.process(
        "button_press_event", MouseEvent("button_press_event", canvas, x + off, y, 1)
    )


def test_a_click_takes_the_nearest_pole_and_a_second_gives_it_back(choice):
    click(choice, 40, 20)
    click(choice, 10, 30, off=5)
    np.testing.assert_allclose(np.abs(choice.poles) / (2 * np.pi), [10, 40], rtol=1e-4)
    click(choice, 40, 20)
    assert choice.chosen == [4]


def test_a_click_beside_every_pole_takes_none(choice):
    click(choice, 25, 15)
    assert not len(choice.poles)


def test_poles_are_coloured_by_what_is_stable():
    poles = [pole(10 + i, 5.0, steady) for i, (_, steady, _, _) in enumerate(KINDS)]
    found = kinds(poles)
    assert len({colour for _, colour, _, _, _ in found}) == len(KINDS)
    assert [list(order) for *_, order in found] == [[10 + i] for i in range(len(KINDS))]


def test_columns_of_noise_are_told_from_those_of_modes():
    kept = [pole(order, 2.0) for order in range(4, 40, 2)]
    stray = [pole(order, 7.4) for order in range(20, 40, 2)]
    found = {name: list(freq) for name, *_, freq, _ in kinds([*kept, *stray], [2.001])}
    assert len(found["all stable"]) == len(kept)
    assert found[REFUSED[0]] == pytest.approx([7.4] * len(stray), rel=1e-3)


def test_a_column_without_a_mode_is_none_where_shapes_are_not_known():
    part = frozenset(("frequency", "damping"))
    known = [replace(pole(order, 2.0, part), stable=True) for order in (6, 8)]
    other = [replace(pole(order, 7.4, part), stable=True) for order in (6, 8)]
    found = {name: list(freq) for name, *_, freq, _ in kinds([*known, *other], [2.0])}
    assert len(found["frequency and damping stable"]) == 2
    assert found[REFUSED[0]] == pytest.approx([7.4, 7.4], rel=1e-3)


def test_without_a_screen_it_is_said_what_to_do(choice):
    assert matplotlib.get_backend().lower() == "agg"
    with pytest.raises(TwinError, match="--poles"):
        pick_by_hand(choice.diagram)
