"""Tables for the terminal."""

import io

import numpy as np
from rich.console import Console

from twin.modal import ModalModel
from twin.view.comparison import Row, mode_rows
from twin.view.tables import mode_table


def printed(rows):
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(mode_table(rows, "Modes"))
    return console.export_text().splitlines()


def test_every_mode_has_one_line_with_its_frequency_and_damping():
    modal = ModalModel(
        np.array([2.0, 6.5]), np.array([0.01, 0.002]), np.ones((1, 2)), ("a",),
        np.array([0.01, 0.02]), np.array([0.001, 0.0001]),
    )  # fmt: skip
    text = printed(mode_rows(modal))
    assert text[1].split() == ["mode", "frequency", "[Hz]", "std", "damping", "[%]", "std"]
    assert text[3].split() == ["1", "2.000", "0.010", "1.00", "0.10"]
    assert text[4].split() == ["2", "6.500", "0.020", "0.200", "0.010"]


def test_rows_whose_truth_is_known_are_compared_by_parameter():
    rows = [Row("frequency 1", "Hz", 2.0, 0.01, None, 2.02), Row("damping 1", "%", 1.0, 0.1)]
    text = printed(rows)
    assert any("parameter" in line and "true" in line for line in text)
    assert any("frequency 1 [Hz]" in line for line in text)
