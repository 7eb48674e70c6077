"""Ledger entries of the control design, (54)-(60)."""

from __future__ import annotations

from collections.abc import Iterable

from twin.paper import printed
from twin.paper.entry import CONTRADICTS, OPEN, Entry, compared, given, judged
from twin.paper.printed import values
from twin.paper.recompute import absorber_model
from twin.paper.reduction import reductions


def _pendulum() -> list[Entry]:
    m, half = printed.PENDULUM_MASS.value, printed.HALF_LENGTH.value
    number = printed.PENDULUM_INERTIA
    return [
        given(printed.GRAVITY),
        given(printed.HALF_LENGTH, "W4"),
        given(printed.PENDULUM_MASS),
        judged(number, m * half**2, "c.m., at most", CONTRADICTS, "N13"),
        judged(number, m * half**2 / 3, "c.m., rod", CONTRADICTS, "N13"),
        judged(number, m * (2 * half) ** 2 / 3, "hinge, rod", CONTRADICTS, "N13", "W4"),
        Entry("(56)", "shape of K_3", "1 x 1", "2 x 2", (), "", "shapes", CONTRADICTS, ("E6",)),
    ]


def _excitation() -> list[Entry]:
    found = [given(printed.FORCE_AMPLITUDE[0], "W3"), given(printed.FORCE_AMPLITUDE[1], "W3")]
    frame_modes = absorber_model().modes().natural_freq[1:]
    for number, identified, simulated in zip(
        printed.FORCE_FREQUENCY, values(printed.FREQUENCY), frame_modes, strict=True
    ):
        found.append(compared(number, float(identified), "(47)-(48)"))
        found.append(compared(number, float(simulated), "(50)-(56)", "N14"))
    return found


def _range(pairs: Iterable[float]) -> tuple[float, float]:
    percent = [100 * value for value in pairs]
    return min(percent), max(percent)


def _reductions(seed: int) -> list[Entry]:
    found = reductions(seed)
    swing = max(case.peak_swing for case in found)
    weights = sorted({case.torque_weight for case in found})
    noise = max(case.noise_std for case in found)
    choices = (
        f"regulator weights {weights[0]:g} to {weights[-1]:g}, noise up to {noise:g} N, three "
        f"readings of T_e; swings up to {swing:.1f} rad"
    )
    limits = (
        "the floors start the controlled half where the other left them, so that no controller "
        f"does better from 32 s on; noise up to {noise:g} N"
    )
    rows = (
        ("steady halves", [case.steady for case in found], f"last 16 s of each half; {choices}"),
        ("whole halves", [case.whole for case in found], choices),
        ("any controller", [case.ceiling for case in found], limits),
    )
    entries = []
    for floor, number in enumerate(printed.REDUCTION):
        for route, shares, note in rows:
            low, high = _range(share[floor] for share in shares)
            entries.append(_open(number, route, low, high, note))
    return entries


def _open(number: printed.Printed, route: str, low: float, high: float, note: str) -> Entry:
    text = f"{low:.0f} to {high:.0f}"
    return Entry(
        number.equation,
        number.symbol,
        number.text,
        text,
        (low, high),
        number.unit,
        route,
        OPEN,
        ("W3",),
        note,
    )


def entries(seed: int = 0) -> tuple[Entry, ...]:
    """Return the entries of section VI; ``seed`` is that of w(t) in (57)."""
    return (
        *_pendulum(),
        *_excitation(),
        given(printed.CONTROL_DURATION),
        given(printed.CONTROL_START),
        compared(printed.CONTROL_STEP, 1 / printed.SAMPLING.value, "1/f_s"),
        *_reductions(seed),
    )
