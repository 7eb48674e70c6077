"""A test with the standard instruments: all sensors alike, all inputs alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from twin.instruments import Instrument
from twin.laboratory.analyser import Analyser
from twin.laboratory.excitation import Excitation
from twin.laboratory.experiment import Experiment, run
from twin.model import Twin
from twin.recording import Recording


def tested(
    twin: Twin, excitation: Excitation, at: str | Sequence[str], ground: Sequence[str],
    rate_hz: float, duration_s: float, noise: float, input_noise: float,
    sensors: Sequence[str] | None, seed: int, repetition: int,
) -> Recording:  # fmt: skip
    """Return what an analyser records of a twin that is excited.

    Args:
        twin: the structure.
        excitation: the signal.
        at: where it acts, one input or several.
        ground: axes along which the ground is shaken.
        rate_hz: sampling rate [Hz].
        duration_s: length [s].
        noise: of the sensors, share of the RMS.
        input_noise: of the measured inputs, share of the RMS.
        sensors: channels beside the inputs; all of the model without.
        seed: of noise and random signals.
        repetition: number of the test with this seed.

    Raises:
        TwinError: the model has no such place, or a number is out of its range.
    """
    measured = dict.fromkeys(("acc", "disp", "angle"), Instrument(noise_fraction=noise))
    driven = dict.fromkeys(("force", "torque"), Instrument(noise_fraction=input_noise))
    shaken = {f"acc_ground.{axis}": Instrument(noise_fraction=input_noise) for axis in ground}
    experiment = Experiment(
        excitation, at if isinstance(at, str) else tuple(at), Analyser(rate_hz, duration_s),
        instruments={**measured, **driven, **shaken}, ground=tuple(ground),
    )  # fmt: skip
    if sensors is not None:
        experiment = replace(experiment, channels=(*experiment.inputs(twin), *sensors))
    return run(experiment, twin, seed, repetition)
