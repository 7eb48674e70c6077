"""Which package's modes foresee a hit that was not fitted.

To the modes that are found here on the other hits, or to the same with every package's frequency
and damping of the fourteen in their place, numerators are fitted on the other hits alone. The
packages' values are from all hits, the unseen one included: that favours them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from hammer_known import forces, like

from twin.identification.identify import identify
from twin.identification.records import prepare
from twin.recording import Recording

NEAR = 3e-3
"""Relative distance from a resonance within which the error is counted: ten bandwidths or more."""


def unseen(
    hits: Sequence[Recording], rows: Sequence[Mapping[str, Any]], own: str,
    band: tuple[float, float],
) -> dict[str, Any]:  # fmt: skip
    """Return the error on the last hit near every mode and in the band, as shares of its response.

    Args:
        hits: of which the last is not fitted.
        rows: what ``hammer_peers.measured`` returns.
        own: the name of ours there.
        band: frequencies of the whole error [Hz].
    """
    train, rate = hits[:-1], hits[-1].sampling_hz
    found = identify(train)
    ((_, y),) = prepare(hits[-1:]).pairs
    (force,) = forces(hits[-1:])
    Y = np.fft.rfft(y[:, 0])
    freq = np.fft.rfftfreq(len(y), 1 / rate)
    errors: dict[str, Any] = {}
    for name in rows[0]["values"]:
        f, zeta = found.modal.natural_freq.copy(), found.modal.damping_ratio.copy()
        for row in rows:
            value = row["values"][name]["all"]
            if name != own and value is not None:
                i = int(np.argmin(np.abs(found.modal.natural_freq - row["mode"])))
                f[i], zeta[i] = value["frequency_hz"], value["damping"]
        modal = replace(found.modal, natural_freq=f, damping_ratio=zeta)
        part = like(train, replace(found, modal=modal))
        off = np.fft.rfft(part.response(force, rate)) - Y
        places = [np.abs(freq / row["mode"] - 1) < NEAR for row in rows]
        places.append((freq > band[0]) & (freq < band[1]))
        shares = [float(np.linalg.norm(off[k]) / np.linalg.norm(Y[k])) for k in places]
        errors[name] = {"modes": shares[:-1], "band": shares[-1]}
    return errors
