"""Hypotheses as MuJoCo twins, and free runs of twins from the measured forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.bench import Bench, Between
from twin.diagnosis.channels import corrected
from twin.diagnosis.trials import MOTOR, SHAKE_TABLE, Trial
from twin.errors import ModelError
from twin.mechanisms.mass import Mass
from twin.mechanisms.mechanism import ChannelFault, Mechanism, StructuralChange
from twin.model import Twin
from twin.signals.resampling import resample

Array = NDArray[np.float64]

FINEST_S = 1e-3
"""Longest step of a simulation [s]."""

FINEST = 100
"""Steps in the period of the highest mode, at least."""

HELD_STEPS = 16
"""Pieces of a sampling interval in which a held input is played back."""


def merged(mechanisms: Sequence[Mechanism]) -> tuple[Mechanism, ...]:
    """Return mechanisms with changes of the same kind at the same place added up."""
    out: list[Mechanism] = []
    for mechanism in mechanisms:
        same = [m for m in out if type(m) is type(mechanism) and m.place == mechanism.place]
        if same and isinstance(mechanism, StructuralChange) and "change" in mechanism.parameters:
            total = same[0].values["change"] + mechanism.values["change"]
            out[out.index(same[0])] = same[0].with_values({"change": total})
        else:
            out.append(mechanism)
    return tuple(out)


def twin_with(twin: Twin, mechanisms: Sequence[Mechanism]) -> Twin:
    """Return a twin that has the mechanisms; those that change nothing are left out."""
    kept = [m for m in merged((*twin.mechanisms, *mechanisms)) if m.values.get("change", 1.0)]
    return replace(twin, mechanisms=()).including(*kept)


def heights_of(twin: Twin) -> dict[str, float]:
    """Return the heights of the storeys [m], from the bodies' initial positions."""
    model = twin.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    out, below = {}, float(data.body("ground").xpos[2])
    for floor in twin.floors:
        level = float(data.body(floor).xpos[2])
        out[floor.replace("floor", "storey")] = max(level - below, 1e-3)
        below = level
    return out


def free_run(twin: Twin, trial: Trial, between: Between) -> Array:
    """Return the outputs of a simulation from rest, as the instruments record them.

    Args:
        twin: with its mechanisms; faults of its channels are applied.
        trial: for the measured inputs and added masses.
        between: what the inputs do between samples.

    Returns:
        (samples, m); NaN throughout where the motion diverges.
    """
    sound = corrected(trial, [m for m in twin.mechanisms if _of_input(m, trial)])
    highest = float(np.max(twin.second_order().undamped_modes().natural_freq))
    fine = max(1, math.ceil(max(1 / FINEST_S, FINEST * highest) / trial.sampling_hz - 1e-9))
    rate = trial.sampling_hz
    u = sound.u
    motor = np.array([name.startswith(MOTOR) for name in trial.inputs], bool)
    if between == "band_limited":
        whole = resample(u, rate, rate * fine)
        whole = np.vstack([whole, np.repeat(whole[-1:], fine - 1, axis=0)])
        u, rate = np.where(motor, np.repeat(u, fine, axis=0), whole), rate * fine
    elif between == "held" or motor.any():
        held = np.repeat(u, HELD_STEPS, axis=0)
        at = np.arange(len(held)) / HELD_STEPS
        straight = np.column_stack([np.interp(at, np.arange(len(u)), c) for c in u.T])
        u = held if between == "held" else np.where(motor, held, straight)
        rate *= HELD_STEPS
    loaded = twin_with(twin, [Mass(place, kg) for place, kg in trial.added_mass.items()])
    columns = dict(zip(trial.inputs, u.T, strict=True))
    table = columns.pop(SHAKE_TABLE, None)
    try:
        motion = loaded.simulate(columns, rate, len(u), ground_acceleration=table)
    except ModelError as error:
        if "diverges" not in str(error):
            raise
        return np.full(trial.y.shape, np.nan)
    step = round(rate / trial.sampling_hz)
    channels = {name: values for name, values in motion.columns.items() if name in trial.outputs}
    if between == "band_limited":
        sampled = {n: _decimated(v, rate, trial) for n, v in channels.items()}
    else:
        sampled = {n: v[::step][: trial.samples] for n, v in channels.items()}
    inputs = dict(zip(trial.inputs, sound.u.T, strict=True))
    recorded = loaded.recorded({**inputs, **sampled}, trial.sampling_hz)
    return np.column_stack([recorded[name] for name in trial.outputs])


def _decimated(values: Array, rate_hz: float, trial: Trial) -> Array:
    """Sample as an analyser does, what is above the Nyquist frequency taken off first."""
    out = resample(values, rate_hz, trial.sampling_hz)[: trial.samples]
    return np.concatenate([out, np.repeat(out[-1:], trial.samples - len(out))])


def _of_input(mechanism: Mechanism, trial: Trial) -> bool:
    return isinstance(mechanism, ChannelFault) and mechanism.place in trial.inputs


def free_runs(twin: Twin, bench: Bench, workers: int = 2) -> list[Array]:
    """Return the free run of every trial; MuJoCo lets go of Python's lock, so threads help."""
    if workers < 2:
        return [free_run(twin, trial, bench.between) for trial in bench.trials]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda t: free_run(twin, t, bench.between), bench.trials))
