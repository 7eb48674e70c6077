"""Ledger entries of the experimental modal analysis, (47)-(53)."""

from __future__ import annotations

import numpy as np

from twin.paper import printed
from twin.paper.entry import (
    AGREES,
    CONTRADICTS,
    Entry,
    compared,
    compared_set,
    given,
    judged,
)
from twin.paper.normalisation import MATRICES, SIGNS, largest_passive_phase, nearest_scale
from twin.paper.printed import values
from twin.paper.recompute import (
    fitted_coefficients,
    identified_model,
    implied_coefficients,
    lumped_model,
    matrices_of_modal,
    proportional_matrix,
    real_shapes,
    undamped_frequencies,
)
from twin.paper.rounding import misfit

MASS_AND_STIFFNESS = printed.MASS_MATRIX + printed.STIFFNESS_MATRIX


def _in_order(entry: Entry) -> str:
    return entry.equation


def _sampling() -> list[Entry]:
    rate = printed.SAMPLING.value
    return [
        given(printed.SAMPLING),
        given(printed.DURATION),
        compared(printed.TIME_STEP, 1 / rate, "1/f_s"),
        compared(printed.NYQUIST, rate / 2, "f_s/2"),
        given(printed.CUT_OFF, "W2"),
        compared(printed.ORDER, 2 * len(lumped_model().M), "n = 2 n_2"),
    ]


def _modes() -> list[Entry]:
    model = identified_model()
    route, matrices = "(50)-(51)", values(MASS_AND_STIFFNESS)
    miss = misfit(lambda x, _: undamped_frequencies(x), MASS_AND_STIFFNESS, printed.FREQUENCY)
    found = compared_set(printed.FREQUENCY, undamped_frequencies(matrices), route, miss, "N3")
    found += _damping_ratios()
    for mode, number in enumerate(printed.AMPLITUDE):
        ours, lumped = (abs(float(real_shapes(m)[1, mode])) for m in (model, lumped_model()))
        found.append(judged(number, ours, route, CONTRADICTS, "N3"))
        ids = ("N9", "N10") if mode == 0 else ("N10",)
        found.append(judged(number, lumped, "(9)-(10)", CONTRADICTS, *ids))
    return sorted(found + _phases(), key=_in_order)


def _damping_ratios() -> list[Entry]:
    """Xi by (52), where the second mode does not vibrate, and by (53)."""
    poles = np.linalg.eigvals(identified_model(printed.DAMPING_MATRIX).state_matrix())
    pair = poles[poles.imag > 0][0]
    first, second = printed.DAMPING
    found = [judged(first, float(-pair.real / abs(pair)), "(50)-(52)", CONTRADICTS, "N4")]
    real = tuple(float(pole) for pole in np.sort(poles[poles.imag == 0].real))
    note = f"the mode does not vibrate: two real poles, {real[0]:.1f} and {real[1]:.1f} 1/s"
    found.append(
        Entry(
            second.equation,
            second.symbol,
            second.text,
            "none",
            (),
            "",
            "(50)-(52)",
            CONTRADICTS,
            ("N4",),
            note,
        )
    )
    ratios = identified_model().modes().damping_ratio
    for number, ratio in zip(printed.DAMPING, ratios, strict=True):
        found.append(judged(number, float(ratio), "(50)-(51), (53)", CONTRADICTS, "N3"))
    return found


def _phases() -> list[Entry]:
    first, second = printed.PHASE
    model = lumped_model()
    turned, off_pi = largest_passive_phase(model.M, model.K, values(printed.DAMPING))
    principal = second.value + 2 * np.pi
    allowed = f"at most {off_pi:.4f} from pi is possible, this is {abs(principal - np.pi):.4f}"
    return [
        judged(
            first,
            float(turned),
            "passive limit",
            CONTRADICTS,
            "N6",
            "N7",
            note="largest phase with the xi of (47)-(48), lumped model",
        ),
        Entry(
            second.equation,
            second.symbol,
            second.text,
            f"{principal:.4f}",
            (principal,),
            "rad",
            "plus 2 pi",
            AGREES,
            (),
            f"printed outside (-pi, pi]; {allowed}",
        ),
    ]


def _coefficients() -> list[Entry]:
    miss = misfit(
        lambda x, _: fitted_coefficients(x),
        printed.FREQUENCY + printed.DAMPING,
        printed.PROPORTIONAL,
    )
    fitted = fitted_coefficients(values(printed.MODAL))
    note = "two modes, two unknowns: the least squares of (42) has nothing to average"
    found = compared_set(printed.PROPORTIONAL, fitted, "(42)-(48)", miss, "N1", note=note)
    implied, _ = implied_coefficients(
        values(printed.IMPROVED_DAMPING_MATRIX), values(MASS_AND_STIFFNESS)
    )
    return found + [
        judged(number, float(value), "(50)-(51), (53)", CONTRADICTS, "N2")
        for number, value in zip(printed.PROPORTIONAL, implied, strict=True)
    ]


def _matrices() -> list[Entry]:
    """(50)-(52) as (41) makes them from (47)-(48), with the scale that fits best."""
    best = min((nearest_scale(sign) for sign in SIGNS), key=lambda found: found.misfit)
    ours = matrices_of_modal(values(printed.MODAL), np.array(best.scale), best.sign)
    note = "two complex scales fitted, Theta_1 turned; not a scale for which (41) is true"
    found = compared_set(MATRICES, ours, "(41), (47)-(48)", best.misfit, "N5", "N6", note=note)
    lumped = lumped_model()
    found.append(judged(MATRICES[1], float(lumped.M[0, 1]), "(3)", CONTRADICTS, "N11"))
    for number, entry in zip(
        printed.STIFFNESS_MATRIX, (lumped.K[0, 0], lumped.K[0, 1], lumped.K[1, 1]), strict=True
    ):
        found.append(judged(number, float(entry), "(6)-(7)", CONTRADICTS, "N12"))
    return sorted(found, key=_in_order)


def _improved_damping() -> list[Entry]:
    target = printed.IMPROVED_DAMPING_MATRIX
    matrices = values(MASS_AND_STIFFNESS)
    by_49 = misfit(
        lambda x, _: proportional_matrix(x[:2], x[2:]),
        printed.PROPORTIONAL + MASS_AND_STIFFNESS,
        target,
    )
    by_modes = misfit(
        lambda x, _: proportional_matrix(fitted_coefficients(x), x[4:]),
        printed.FREQUENCY + printed.DAMPING + MASS_AND_STIFFNESS,
        target,
    )
    printed_pair = proportional_matrix(values(printed.PROPORTIONAL), matrices)
    fitted = proportional_matrix(fitted_coefficients(values(printed.MODAL)), matrices)
    return [
        *compared_set(target, printed_pair, "(46), (49)", by_49, "N2"),
        *compared_set(
            target, fitted, "(42)-(48)", by_modes, note="within the rounding of (47)-(48)"
        ),
    ]


def entries() -> tuple[Entry, ...]:
    """Return the entries of section V."""
    return (
        *_sampling(),
        *_modes(),
        *_coefficients(),
        *_matrices(),
        *_improved_damping(),
    )
