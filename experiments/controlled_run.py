"""The recording of a controlled run explains why the lab's reduction falls short of the twin's.

    python experiments/controlled_run.py [--to FILE]

A lumped frame with the pendulum absorber runs in closed loop under the LQG controller that was
designed for it, on an integrator of its own (experiments/concealed/absorber_rig.py). Its pendulum
has dry friction that the drawing does not show, or its motor a deadband or a delay, or nothing.
`twin diagnose` gets the recordings of the controlled run: force, commanded torque, accelerations,
angle. What it names is put into the loop again, and the reduction predicted is laid beside the
lab's. Writes experiments/results/controlled.json.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.absorber_rig import Absorber, ControlledRig  # noqa: E402
from experiments.concealed.rig import TWO_STOREY, Array, Rig  # noqa: E402
from twin.channel import Channel  # noqa: E402
from twin.control.controller import Controller  # noqa: E402
from twin.control.plant import Plant  # noqa: E402
from twin.control.study import Settings  # noqa: E402
from twin.diagnosis.pipeline import diagnose  # noqa: E402
from twin.files import write_whole  # noqa: E402
from twin.frame import FrameDesign, Pendulum, to_mjcf  # noqa: E402
from twin.model import Twin  # noqa: E402
from twin.recording import Recording  # noqa: E402

TARGET = ROOT / "experiments" / "results" / "controlled.json"
SEED = 41
FINE_HZ, RATE_HZ, CONTROL_HZ = 4096, 256, 32
DURATION_S, NOISE, FORCE_N = 26.0, 0.005, 0.006
CHANNELS = ("force_floor1", "torque_pendulum", "acc_floor1", "acc_floor2", "angle_pendulum")

CONCEALED: dict[str, dict[str, float]] = {
    "nothing": {},
    "pendulum_friction": {"friction": 1e-4},
    "motor_deadband": {"deadband": 2e-4},
    "motor_delay": {"delay": 6 / RATE_HZ},
}
FIELD = {"pendulum_friction": ("friction", "torque"), "motor_deadband": ("deadband", "torque"),
         "motor_delay": ("delay", "delay")}  # fmt: skip
"""Field of the rig, and parameter of the finding."""


def force_of(rng: np.random.Generator, level: float) -> Array:
    """Return a random force between 0.5 and 8 Hz on the fine grid [N]."""
    count = round(DURATION_S * FINE_HZ) + 1
    sections = butter(4, (0.5, 8.0), btype="bandpass", fs=FINE_HZ, output="sos")
    force = np.asarray(sosfiltfilt(sections, rng.standard_normal(count)))
    time = np.arange(count) / FINE_HZ
    return level * force / np.std(force) * np.minimum(time / 0.5, 1.0)


def controlled(
    rig: Rig, absorber: Absorber, controller: Controller | None, force: Array, delay: int
) -> dict[str, Array]:
    """Run the loop; the controller's torque acts ``delay`` of its samples later. None is off."""
    inner = FINE_HZ // CONTROL_HZ
    late = round(absorber.delay * FINE_HZ)
    plant = ControlledRig(rig, absorber, 1, 1 / FINE_HZ)
    steps = controller.start() if controller is not None else None
    if steps is not None:
        steps.switch(True)
    intervals = (len(force) - 1) // inner
    command = np.zeros(intervals * inner + late)
    waiting = [0.0] * delay
    parts = []
    for k in range(intervals):
        here = slice(k * inner, (k + 1) * inner)
        if steps is not None:
            n = plant.n
            # what the sensors give at this instant, before the torque of this interval acts
            _, now = plant_peek(plant, force[here.start], _motor(absorber, command, here, late)[0])
            y = [*now[:n], plant.state[n]]
            waiting.append(steps.step(np.array(y), float(force[here.start])))
            command[here] = waiting.pop(0)
        torque = _motor(absorber, command, here, late)
        parts.append(plant.run(force[here.start : here.stop + 1], torque))
    states, seen = (np.concatenate(part) for part in zip(*parts, strict=True))
    n = plant.n
    return {
        "force_floor1": force[: len(states)],
        "torque_pendulum": command[: len(states)],
        **{f"acc_floor{i + 1}": seen[:, i] for i in range(n)},
        "angle_pendulum": states[:, n],
        **{f"disp_floor{i + 1}": states[:, i] for i in range(n)},
    }


def plant_peek(plant: ControlledRig, force: float, torque: float) -> tuple[Array, Array]:
    """Return state and accelerations of this instant, the rig left where it is."""
    before = plant.state
    states, seen = plant.run(np.array([force, force]), np.array([torque]))
    plant.state = before
    return states[0], seen[0]


def _motor(absorber: Absorber, command: Array, here: slice, late: int) -> Array:
    """Return what the motor delivers: late, and less what it swallows."""
    index = np.arange(here.start, here.stop) - late
    given = np.where(index >= 0, command[np.maximum(index, 0)], 0.0)
    return np.asarray(given - np.clip(given, -absorber.deadband, absorber.deadband))


def recorded(run: dict[str, Array], rng: np.random.Generator, source: str) -> Recording:
    """Return the recording at 256 Hz, white noise on every channel."""
    columns = []
    for name in CHANNELS:
        column = run[name][:: FINE_HZ // RATE_HZ]
        noise = 0.0 if name == "torque_pendulum" else NOISE * np.std(column)
        columns.append(column + noise * rng.standard_normal(len(column)))
    channels = tuple(Channel(name) for name in CHANNELS)
    return Recording(float(RATE_HZ), channels, np.column_stack(columns), source)


def reduction(on: dict[str, Array], off: dict[str, Array]) -> float:
    """Return by how much control reduces the top floor's RMS displacement."""
    return 1 - float(np.std(on["disp_floor2"]) / np.std(off["disp_floor2"]))


def case(name: str, twin: Twin, controller: Controller, delay: int) -> dict[str, Any]:
    """Conceal, record, diagnose, and predict the reduction with what was found."""
    rng = np.random.default_rng([SEED, list(CONCEALED).index(name)])
    nominal, rig = Absorber(), TWO_STOREY.scattered(rng)
    absorber = replace(nominal, **CONCEALED[name])
    levels = [FORCE_N * x for x in (0.6, 1.0, 1.5, 1.0)]
    forces = [force_of(rng, level) for level in levels]
    runs = [controlled(rig, absorber, controller, force, delay) for force in forces]
    *train, test = [recorded(run, rng, f"run {i + 1}") for i, run in enumerate(runs)]
    found = diagnose(twin, train, [test])
    first = found.findings[0] if found.findings else None
    predicted = nominal
    if first is not None and first.mechanism.name in FIELD:
        field, parameter = FIELD[first.mechanism.name]
        predicted = replace(nominal, **{field: float(first.mechanism.values[parameter])})
    off = controlled(rig, absorber, None, forces[-1], delay)
    mine = [controlled(TWO_STOREY, one, controller, forces[-1], delay)
            for one in (nominal, predicted)]  # fmt: skip
    mine_off = [
        controlled(TWO_STOREY, one, None, forces[-1], delay) for one in (nominal, predicted)
    ]
    return {
        "concealed": name,
        "value": CONCEALED[name],
        "named": None if first is None else f"{first.mechanism.name} {first.location}",
        "found": {} if first is None else dict(first.mechanism.values),
        "probability": None if first is None else first.probability,
        "verdict": found.verdict,
        "unseen_error": {"calibrated": found.fit.test.calibrated,
                         "explained": found.fit.test.explained},
        "reduction": {"lab": reduction(runs[-1], off), "twin": reduction(mine[0], mine_off[0]),
                      "explained": reduction(mine[1], mine_off[1])},
    }  # fmt: skip


def cases(names: Sequence[str]) -> list[dict[str, Any]]:
    """Return what was found in closed loop of each concealed fault of the motor."""
    design = FrameDesign(kind="lumped", pendulum=Pendulum(damping=Absorber().damping))
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "absorber_lumped.xml"
        model.write_text(to_mjcf(design, "absorber_lumped"), encoding="utf-8")
        twin = Twin.load(str(model))
        plant = Plant(twin, "force_floor1", delay=1)
        controller = replace(Settings(), ramp_s=0.0).design(plant.linear(), plant.delay)
        rows = []
        for name in names:
            rows.append(case(name, twin, controller, plant.delay))
            print(json.dumps(rows[-1]), flush=True)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--to", type=Path, default=TARGET)
    parser.add_argument("--only", choices=list(CONCEALED))
    given = parser.parse_args()
    rows = cases(list(CONCEALED) if given.only is None else [given.only])
    if given.only is None:
        text = json.dumps({"command": "python experiments/controlled_run.py", "cases": rows},
                          indent=1, allow_nan=False) + "\n"  # fmt: skip
        write_whole(given.to, lambda part: part.write_text(text))


if __name__ == "__main__":
    main()
