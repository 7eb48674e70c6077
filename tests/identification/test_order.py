import numpy as np

from twin.identification.order import order_from_singular_values


def test_the_last_clear_drop_counts_not_the_largest():
    assert order_from_singular_values(np.array([100, 99, 5, 4.8, 1.0, 0.95, 0.9, 0.85])) == 4


def test_rounding_after_an_even_rank_is_an_order():
    assert order_from_singular_values(np.array([130.0, 127, 86, 85, 1e-13, 1e-14])) == 4


def test_a_slow_fall_has_no_order():
    assert order_from_singular_values(0.8 ** np.arange(30.0)) is None


def test_nothing_has_no_order():
    assert order_from_singular_values(np.zeros(5)) is None
