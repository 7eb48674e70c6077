"""Ten kinds of unusable data, made from a good record of the two-storey frame."""

from __future__ import annotations

import numpy as np

Columns = dict[str, np.ndarray]


def saturated(d: Columns) -> None:
    limit = 0.8 * np.abs(d["acc_floor2"]).max()
    d["acc_floor2"] = np.clip(d["acc_floor2"], -limit, limit)


def dead(d: Columns) -> None:
    d["acc_floor2"][600:] = 0


def dropped(d: Columns) -> None:
    for k in np.random.default_rng(3).integers(100, 900, 12):
        d["acc_floor2"][k : k + 12] = d["acc_floor2"][k]


def dropped_to_zero(d: Columns) -> None:
    for k in np.random.default_rng(3).integers(100, 900, 12):
        d["acc_floor2"][k : k + 12] = 0


def another_clock(d: Columns) -> None:
    t = np.arange(len(d["acc_floor2"]))
    d["acc_floor2"] = np.interp(1.01 * t, t, d["acc_floor2"])
    for name in d:
        d[name] = d[name][:1000]


def reversed_at_the_force(d: Columns) -> None:
    d["acc_floor1"] = -d["acc_floor1"]


def constant(d: Columns) -> None:
    d["acc_floor2"].fill(0.3)


def identical(d: Columns) -> None:
    d["acc_floor2"] = d["acc_floor1"].copy()


def in_g(d: Columns) -> None:
    d["acc_floor2"] = d["acc_floor2"] / 9.81
