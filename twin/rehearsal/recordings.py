"""The plan carried out on a virtual structure that has an effect, with the plan's instruments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twin.errors import TwinError
from twin.instruments import INSTRUMENT_OF, Instrument
from twin.laboratory import Analyser, Experiment, run
from twin.laboratory.experiment import stream
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Mechanism
from twin.model import Twin
from twin.model.linear import LinearModel
from twin.quantity import QUANTITIES
from twin.recording import Recording
from twin.rehearsal.plan import SHARE, Plan, PlannedTest
from twin.rehearsal.responses import force_response

Array = NDArray[np.float64]

INPUTS = ("force", "torque")


def recorded(
    twin: Twin, plan: Plan, seed: int, effect: Mechanism | None = None,
    model: LinearModel | None = None,
) -> tuple[Recording, ...]:  # fmt: skip
    """Return the plan's recordings of a twin, with an effect where one is named.

    Args:
        twin: the structure as it is believed to be.
        plan: what is done and how it is measured.
        seed: of excitation and noise; the same seed, the same samples.
        effect: what the structure, or an instrument, has besides.
        model: linear equations with the plan's inputs and outputs, along which a force acts that
            nobody measures; needed for a ``Disturbance`` only.

    Raises:
        TwinError: the twin has no such place or sensor, or its motion diverges with the effect.
    """
    in_twin = effect is not None and not isinstance(effect, Disturbance)
    by_instrument = isinstance(effect, ChannelFault) and not effect.of_motor
    rig = twin.including(effect) if effect and in_twin and not by_instrument else twin
    out = []
    for number, test in enumerate(plan.recordings):
        recording = run(_experiment(rig, plan, test), rig, seed, number)
        if isinstance(effect, Disturbance):
            assert model is not None
            recording = _disturbed(recording, model, effect, stream(seed, number, "disturbance"))
        elif (
            isinstance(effect, ChannelFault)
            and by_instrument
            and set(effect.channels) <= set(recording.names)
        ):
            columns = {name: recording.column(name) for name in recording.names}
            faulty = effect.distort(columns, recording.sampling_hz)
            data = np.column_stack([faulty[name] for name in recording.names])
            recording = replace(recording, data=data)
        out.append(replace(recording, source=f"{test.use}_{number + 1}"))
    return tuple(out)


def _experiment(twin: Twin, plan: Plan, test: PlannedTest) -> Experiment:
    instruments = {
        kind: replace(
            INSTRUMENT_OF.get(kind, Instrument()), noise_fraction=0.0 if kind in INPUTS else SHARE
        )
        for kind in QUANTITIES
    }
    for axis in test.ground:
        instruments[f"acc_ground.{axis}"] = Instrument()
    for name, noise in plan.noise.items():
        usual = instruments.get(name, Instrument())
        instruments[name] = replace(usual, noise_fraction=noise.share, noise_std=noise.std)
    made = Experiment(
        test.excitation,
        test.at or "floor1",
        Analyser(test.rate_hz, test.duration_s),
        instruments=instruments,
        ground=test.ground,
    )
    if plan.sensors is not None:
        made = replace(made, channels=(*made.inputs(twin), *plan.sensors))
    return made


def _disturbed(
    recording: Recording, model: LinearModel, effect: Disturbance, rng: np.random.Generator
) -> Recording:
    """Return a recording with what a force that nobody measures adds to it."""
    if not hasattr(effect, "realisation"):
        raise TwinError(f"{effect.name}: states no history, so it cannot be rehearsed")
    force = effect.realisation(recording.samples, recording.sampling_hz, rng)
    added = force_response(model, effect.place, force, recording.sampling_hz)
    data = recording.data.copy()
    for column, name in enumerate(model.outputs):
        if name in recording.names:
            data[:, recording.names.index(name)] += added[:, column]
    return replace(recording, data=data)
