"""Printed digits and what rounding can explain."""

import numpy as np
import pytest

from twin.paper.printed import Printed
from twin.paper.rounding import misfit


@pytest.mark.parametrize(
    ("text", "value", "half_unit"),
    [
        ("1.949", 1.949, 0.0005),
        ("2.180", 2.18, 0.0005),
        ("32", 32.0, 0.5),
        ("3.4355e-5", 3.4355e-5, 5e-10),
        ("300e-3", 0.3, 5e-4),
        ("-0.0846", -0.0846, 5e-5),
    ],
)
def test_a_printed_number_knows_its_value_and_its_last_digit(text, value, half_unit):
    number = Printed("(0)", "x", text)
    assert number.value == pytest.approx(value, rel=1e-15)
    assert number.half_unit == pytest.approx(half_unit, rel=1e-12)


def test_pi_is_cut_off_in_3_141_and_rounded_in_3_142():
    cut, rounded = Printed("(0)", "pi", "3.141"), Printed("(0)", "pi", "3.142")
    assert not cut.met_by(np.pi)
    assert cut.cut_from(np.pi)
    assert rounded.met_by(np.pi)
    assert not rounded.cut_from(np.pi)
    assert Printed("(0)", "-pi", "-3.141").cut_from(-np.pi)
    assert not Printed("(0)", "pi", "3.141").cut_from(-np.pi)


def test_rounding_explains_a_sum_that_looks_wrong():
    parts = (Printed("(0)", "a", "1.4"), Printed("(0)", "b", "1.4"))
    for text, explained in (("2.8", True), ("2.9", True), ("2.7", True), ("3.0", False)):
        miss = misfit(lambda x, _: np.array([x.sum()]), parts, (Printed("(0)", "a+b", text),))
        assert (miss <= 1) == explained, text


def test_rounding_does_not_help_where_one_input_would_have_to_move_both_ways():
    one = (Printed("(0)", "a", "1.0"),)
    both = (Printed("(0)", "a", "1.1"), Printed("(0)", "a", "0.9"))
    assert misfit(lambda x, _: np.repeat(x, 2), one, both) == pytest.approx(2, abs=1e-6)


def test_a_free_number_is_found_wherever_it_is():
    target = (Printed("(0)", "a", "7.5"), Printed("(0)", "b", "15.0"))
    assert misfit(lambda _, free: free[0] * np.array([1.0, 2.0]), (), target, (0.1,)) < 1e-6
