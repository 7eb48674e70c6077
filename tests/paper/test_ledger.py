"""The ledger of the paper's numbers."""

import json

import numpy as np
import pytest

from twin.paper import contradictions, ledger
from twin.paper.entry import VERDICTS


def lines(equation, quantity, route=None):
    return [
        entry
        for entry in ledger()
        if entry.equation == equation
        and entry.quantity == quantity
        and (route is None or entry.route == route)
    ]


def line(equation, quantity, route=None):
    found = lines(equation, quantity, route)
    assert len(found) == 1
    return found[0]


@pytest.mark.parametrize(
    ("equation", "quantity", "text"),
    [
        ("(9)", "f_n,1", "1.949"),
        ("(9)", "rho_1", "1.812"),
        ("(9)", "Theta_1", "0"),
        ("(10)", "f_n,2", "6.715"),
        ("(10)", "rho_2", "0.231"),
    ],
)
def test_the_lumped_modes_agree_to_every_printed_digit(equation, quantity, text):
    entry = line(equation, quantity)
    assert entry.printed == text
    assert entry.verdict == "agrees"
    decimals = len(text.partition(".")[2])
    assert f"{entry.values[0]:.{decimals}f}" == text


def test_the_lumped_model_is_the_closed_form_of_two_equal_storeys():
    k = 24 * 2.0e11 * 2.917e-12 / 0.3**3
    m1, m2 = 0.65, 1.55
    b = 2 * k / m1 + k / m2
    root = np.sqrt(b**2 - 4 * k**2 / (m1 * m2))
    squares = np.array([b - root, b + root]) / 2
    assert line("(7)", "k").values[0] == pytest.approx(k, rel=1e-12)
    for equation, mode in (("(9)", 0), ("(10)", 1)):
        entry = line(equation, f"f_n,{mode + 1}")
        assert entry.values[0] == pytest.approx(np.sqrt(squares[mode]) / (2 * np.pi), rel=1e-9)
        ratio = 2 - squares[mode] * m1 / k
        assert line(equation, f"rho_{mode + 1}").values[0] == pytest.approx(abs(ratio), rel=1e-9)


def test_pi_is_the_only_number_cut_off():
    assert [entry.printed for entry in ledger() if entry.verdict == "cut off"] == ["3.141"]


@pytest.mark.parametrize(
    ("equation", "quantity", "route", "verdict"),
    [
        ("(47)", "f_n,1", "(50)-(51)", "contradicts"),
        ("(48)", "f_n,2", "(50)-(51)", "contradicts"),
        ("(47)", "xi_1", "(50)-(52)", "contradicts"),
        ("(48)", "xi_2", "(50)-(52)", "contradicts"),
        ("(47)", "xi_1", "(50)-(51), (53)", "contradicts"),
        ("(48)", "Theta_2", "plus 2 pi", "agrees"),
        ("(49)", "alpha", "(42)-(48)", "contradicts"),
        ("(49)", "beta", "(50)-(51), (53)", "contradicts"),
        ("(50)", "M_11", "(41), (47)-(48)", "consistent"),
        ("(51)", "K_12", "(41), (47)-(48)", "consistent"),
        ("(52)", "R_22", "(41), (47)-(48)", "consistent"),
        ("(53)", "R_11", "(46), (49)", "contradicts"),
        ("(53)", "R_11", "(42)-(48)", "consistent"),
        ("(57)", "f_2", "(47)-(48)", "agrees"),
        ("(57)", "f_2", "(50)-(56)", "contradicts"),
        ("Sec. V", "time step", "1/f_s", "agrees"),
        ("(60)", "x_1 reduced by", "whole halves", "open"),
    ],
)
def test_the_verdicts_are_these(equation, quantity, route, verdict):
    assert line(equation, quantity, route).verdict == verdict


def test_the_recursions_and_the_second_order_formula_hold_and_the_realization_does_not():
    for equation in ("(29)", "(30)"):
        entry = line(equation, next(e.quantity for e in ledger() if e.equation == equation))
        assert entry.verdict == "holds"
        assert entry.values[0] < 1e-12
    for equation in ("(38)", "(41)"):
        verdicts = [entry.verdict for entry in ledger() if entry.equation == equation]
        assert sorted(verdicts) == ["contradicts", "holds"]


def test_every_contradicting_line_names_a_contradiction_and_every_contradiction_exists():
    ids = {contradiction.id for contradiction in contradictions()}
    for entry in ledger():
        assert set(entry.contradictions) <= ids
        assert entry.verdict in VERDICTS
        assert entry.contradictions or entry.verdict != "contradicts"
    named = {name for entry in ledger() for name in entry.contradictions}
    # What only words or symbols contradict has no line of its own.
    assert ids - named == {"E7"}


def test_equation_60_stays_open_and_its_ranges_stand_apart_by_window():
    for floor in (1, 2):
        steady, whole, ceiling = (
            line("(60)", f"x_{floor} reduced by", route).values
            for route in ("steady halves", "whole halves", "any controller")
        )
        printed = float(line("(60)", f"x_{floor} reduced by", "whole halves").printed)
        assert steady[0] < printed < steady[1]
        assert max(whole) <= max(ceiling) + 1e-9 < printed


def test_another_seed_changes_only_what_noise_touches():
    changed = [
        first.equation
        for first, second in zip(ledger(0), ledger(1), strict=True)
        if first != second
    ]
    assert changed
    assert set(changed) == {"(60)"}


def test_the_ledger_survives_json():
    rows = [entry.to_dict() for entry in ledger()]
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows
