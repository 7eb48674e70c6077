"""Every named number of the engine is found where it is written, and changed alone."""

import ast

import pytest

from experiments.named_numbers import AS_IT_STANDS, ROOT, numbers, table, with_changed
from twin.diagnosis.screening import SPACED
from twin.diagnosis.valleys import LAPS, WIDTH

ALL = {(n.file, n.name): n for n in numbers()}


@pytest.mark.parametrize(
    ("file", "name", "value"),
    [("valleys.py", "LAPS[1]", LAPS[1]), ("valleys.py", "WIDTH", WIDTH),
     ("screening.py", "SPACED", SPACED)],
)  # fmt: skip
def test_a_number_is_found_by_its_name(file, name, value):
    assert ALL["twin/diagnosis/" + file, name].value == value


def literals(text):
    return sorted(n.value for n in ast.walk(ast.parse(text))
                  if isinstance(n, ast.Constant) and type(n.value) in (int, float))  # fmt: skip


def test_one_number_is_changed_by_a_half_and_nothing_else():
    for number in ALL.values():
        text = (ROOT / number.file).read_text()
        changed = with_changed(text, number)
        pairs = zip(text.splitlines(), changed.splitlines(), strict=True)
        assert [i for i, (was, now) in enumerate(pairs, 1) if was != now] == [number.line]
        before, after = literals(text), literals(changed)
        before.remove(number.value)
        after.remove(number.changed)
        assert before == after
        assert 1.25 < number.changed / number.value <= 2.0


def test_numbers_that_change_what_is_named_come_first():
    results = {
        AS_IT_STANDS: {"named": {"none_0001": []}},
        "a.py ONE": {"named": {"none_0001": []}},
        "b.py TWO": {"named": {"none_0001": ["mass floor1"]}},
    }
    printed = table(results)
    assert "| b.py TWO | none_0001: mass floor1 instead of nothing |" in printed
    assert "a.py ONE" not in printed
    assert "1 of 2 numbers change nothing" in printed
