"""Ledger entries of the frame and of the identification's equations, (1)-(41)."""

from __future__ import annotations

import numpy as np

from twin.paper import printed
from twin.paper.checks import (
    markov_recovery_error,
    realization_error,
    second_order_recovery_error,
)
from twin.paper.entry import CONTRADICTS, HOLDS, NOT_PRINTED, Entry, compared, given
from twin.paper.recompute import INPUTS, OUTPUTS, lumped_model, real_shapes, storey_stiffness

TOLERANCE = 1e-9
"""An equation holds when what it recovers is right to this share of the largest value."""


def _lumped() -> list[Entry]:
    route = "(2)-(7)"
    model = lumped_model()
    ratio = real_shapes(model)[1]
    k = storey_stiffness()
    found = [Entry("(7)", "k", "", f"{k:.2f}", (k,), "N/m", "2 x 12EJ/L^3", NOT_PRINTED, ("W1",))]
    for mode, freq in enumerate(model.undamped_modes().natural_freq):
        turned = np.pi if ratio[mode] < 0 else 0.0
        ids = ("N8",) if turned else ()
        found += [
            compared(printed.LUMPED_FREQUENCY[mode], float(freq), route),
            compared(printed.LUMPED_AMPLITUDE[mode], float(abs(ratio[mode])), route),
            compared(printed.LUMPED_PHASE[mode], turned, route, *ids),
        ]
    return found


def _shape(equation: str, quantity: str, text: str, ours: str, contradiction: str) -> Entry:
    return Entry(equation, quantity, text, ours, (), "", "shapes", CONTRADICTS, (contradiction,))


def _recovered(equation: str, quantity: str, error: float, *ids: str, note: str = "") -> Entry:
    verdict = HOLDS if error < TOLERANCE else CONTRADICTS
    text = f"{error:.0e}".replace("e-0", "e-").replace("e+0", "e+")
    return Entry(equation, quantity, "", text, (error,), "", "known model", verdict, ids, note)


def _equations() -> list[Entry]:
    m, r = OUTPUTS, INPUTS
    system, gain = markov_recovery_error()
    note = "with +G as in (13)-(14); the K of (59) is -G"
    samples = round(printed.SAMPLING.value * printed.DURATION.value)
    return [
        _shape("(19)", "shape of Y-bar_0", f"{m} x {r + m}", f"{m} x {r}", "E1"),
        _shape("(20)", "shape of Y^0_0", f"{m} x {m}", f"{m} x {r}", "E2"),
        _shape("(28)", "rows of V_p^+", str(m), str(samples), "E3"),
        _recovered("(29)", "error of Y_k", system),
        _recovered("(30)", "error of Y^0_k", gain, note=note),
        _recovered("(38)", "error of Y_k", realization_error(-0.5), "E4"),
        _recovered(
            "(38)",
            "error of Y_k",
            realization_error(0.5),
            "E4",
            note="with Sigma^(+1/2) in B and C",
        ),
        _shape("(39)", "rows of E_m^T", f"{m} alpha", f"{m}", "E5"),
        _recovered(
            "(41)",
            "error of M, K, R",
            second_order_recovery_error(True),
            note="with W scaled as it needs",
        ),
        _recovered(
            "(41)",
            "error of M, K, R",
            second_order_recovery_error(False),
            "N5",
            note="with W scaled as (8); the scale that it needs is not stated",
        ),
    ]


def entries() -> tuple[Entry, ...]:
    """Return the entries of sections II to IV."""
    data = (
        printed.FREQUENCY_RANGE,
        *printed.MASS,
        printed.YOUNG_MODULUS,
        printed.SECOND_MOMENT,
        printed.BEAM_LENGTH,
    )
    return (*(given(number) for number in data), *_lumped(), *_equations())
