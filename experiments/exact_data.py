"""OKID/ERA as the paper writes it, on data it is exact for: held input, no noise, p m = n.

python experiments/exact_data.py
"""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table

from twin.identification.era import era
from twin.identification.identify import identify
from twin.identification.okid import okid
from twin.identification.order import order_from_singular_values
from twin.identification.second_order import second_order_from_poles
from twin.identification.stabilisation import continuous_poles
from twin.modal import poles_to_modal
from twin.model import Twin
from twin.recording import Recording
from twin.state_space import StateSpace

SAMPLING_HZ = 32.0
SAMPLES = 1024
SMALLEST_P = 2


def held_hit() -> Recording:
    """The lumped frame's exact response to a force that is held between samples."""
    frame = Twin.load("two_storey_lumped").second_order()
    u = np.zeros((SAMPLES, 1))
    u[16:18, 0] = 0.6, 0.3
    y = frame.acceleration_response(("floor1",)).held(1 / SAMPLING_HZ).simulate(u)
    columns = {"force_floor1": u[:, 0], "acc_floor1": y[:, 0], "acc_floor2": y[:, 1]}
    return Recording.build(SAMPLING_HZ, columns, source="held hit")


def residues(model: StateSpace, poles: np.ndarray) -> np.ndarray:
    """Continuous-time participation of the input in each mode, for a held input."""
    values, vectors = np.linalg.eig(model.A)
    drive = np.linalg.solve(vectors, model.B.astype(complex))
    own = [int(np.argmin(np.abs(values - np.exp(p / SAMPLING_HZ)))) for p in poles]
    gain = poles / (np.exp(poles / SAMPLING_HZ) - 1)
    return drive[own] * gain[:, None]


def main() -> None:
    recording = held_hit()
    true = Twin.load("two_storey_lumped")
    modes, frame = true.modes(), true.second_order()
    pair = recording.matrix(("force_floor1",)), recording.matrix(("acc_floor1", "acc_floor2"))
    hankel = era(okid([pair], SMALLEST_P).markov(400))
    order = order_from_singular_values(hankel.singular_values)
    realization = hankel.realize(4, 1 / SAMPLING_HZ, 1)
    poles, shapes = continuous_poles(realization)
    plain = poles_to_modal(poles)
    equation_41 = second_order_from_poles(
        poles, shapes, residues(realization, poles), ("acc_floor1", "acc_floor2"), ("force_floor1",)
    )
    refined = identify([recording])
    table = Table("error [%]", "f1", "f2", "zeta1", "zeta2", "M", "K", title="held input, no noise")
    for name, (freq, zeta), model in (
        (f"OKID/ERA, p = {SMALLEST_P}", plain, equation_41),
        (
            "twin identify",
            (refined.modal.natural_freq, refined.modal.damping_ratio),
            refined.second_order,
        ),
    ):
        cells = [
            *(100 * (freq / modes.natural_freq - 1)),
            *(100 * (zeta / modes.damping_ratio - 1)),
        ]
        for letter in ("M", "K"):
            mine, theirs = getattr(model, letter), getattr(frame, letter)
            cells.append(100 * np.abs(mine - theirs).max() / np.abs(theirs).max())
        table.add_row(name, *[f"{abs(c):.1e}" for c in cells])
    console = Console()
    console.print(table)
    console.print(
        f"order chosen from the singular values: {order}; by twin identify: {refined.order}"
    )


if __name__ == "__main__":
    main()
