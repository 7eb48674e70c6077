"""Virtual tests in one call: what ``twin test hammer`` and ``twin test shaker`` do.

>>> recording = hammer_test("two_storey_lumped", "floor1", duration_s=4.0)
>>> recording.inputs, recording.outputs
(('force_floor1',), ('acc_floor1', 'acc_floor2'))
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from twin.errors import ExperimentError, available
from twin.instruments import INSTRUMENT_OF, Instrument
from twin.laboratory.analyser import Analyser
from twin.laboratory.excitation import Excitation
from twin.laboratory.experiment import Experiment, run, settling_time
from twin.laboratory.hammer import Hammer
from twin.laboratory.multisine import Multisine
from twin.laboratory.random_shaking import RandomShaking
from twin.laboratory.sweep import Sweep
from twin.model import Twin
from twin.recording import Recording

KINDS = ("random", "multisine", "sweep")


def hammer_test(
    model: Twin | str | Path,
    at: str = "floor1",
    *,
    peak_n: float = 20.0,
    width_s: float = 0.008,
    sampling_hz: float = 32.0,
    duration_s: float = 32.0,
    noise: float = 0.01,
    input_noise: float = 0.0,
    sensors: Sequence[str] | None = None,
    seed: int = 0,
) -> Recording:
    """Hit a structure with an instrumented hammer.

    Args:
        model: a twin, an MJCF file, or a model that comes with the package.
        at: actuator that is hit, or floorI of a frame.
        peak_n: largest force [N].
        width_s: duration of the contact [s].
        sampling_hz: samples per second.
        duration_s: length of the record [s].
        noise: of every response, as a share of its RMS.
        input_noise: of the measured force, the same.
        sensors: what is recorded besides the force, by name or axis ("acc_tip.x"); None for every
            acceleration that varies.
        seed: the same seed gives the same recording, bit for bit.

    Returns:
        The recording, in SI units.

    Raises:
        ExperimentError: no such place or sensor, or a value out of its range.
        ModelError: no such model.
    """
    analyser = Analyser(sampling_hz, duration_s)
    test = Experiment(
        Hammer(width_s, peak_n), at, analyser, instruments=_instruments(noise, input_noise)
    )
    return _carried_out(test, _loaded(model), sensors, seed)


def shaker_test(
    model: Twin | str | Path,
    at: str | Sequence[str] = "ground",
    *,
    ground: Sequence[str] = (),
    kind: str = "random",
    level: float = 0.1,
    band_hz: tuple[float, float] = (0.5, 12.0),
    periods: int = 4,
    sampling_hz: float = 32.0,
    duration_s: float = 32.0,
    noise: float = 0.01,
    input_noise: float = 0.0,
    sensors: Sequence[str] | None = None,
    seed: int = 0,
) -> Recording:
    """Shake a structure at one or several points, or its ground.

    Args:
        model: a twin, an MJCF file, or a model that comes with the package.
        at: actuator, or floorI or ground of a frame; several have a shaker each, with signals of
            their own.
        ground: axes along which the ground is shaken instead ("x", "y").
        kind: random, multisine or sweep.
        level: RMS force [N], of a shaken ground RMS acceleration [m/s^2].
        band_hz: lowest and highest frequency [Hz].
        periods: of a multisine in the record.
        sampling_hz: samples per second.
        duration_s: length of the record [s].
        noise: of every response, as a share of its RMS.
        input_noise: of the measured inputs, the same.
        sensors: as of ``hammer_test``.
        seed: the same seed gives the same recording, bit for bit.

    Returns:
        The recording, in SI units.

    Raises:
        ExperimentError: no such kind, place or sensor, or a value out of its range.
        ModelError: no such model.
    """
    excitations: dict[str, Excitation] = {
        "random": RandomShaking(level, band_hz),
        "multisine": Multisine(level, band_hz, periods),
        "sweep": Sweep(level, band_hz),
    }
    if kind not in excitations:
        raise ExperimentError(f"no kind of shaking '{kind}'; there is {available(KINDS)}")
    twin = _loaded(model)
    places = () if ground else (at,) if isinstance(at, str) else tuple(at)
    instruments = _instruments(noise, input_noise)
    for axis in ground:
        instruments[f"acc_ground.{axis}"] = Instrument(noise_fraction=input_noise)
    settle = 0.0
    if kind == "multisine":
        settle = settling_time(twin.released() if "ground" in places else twin)
    test = Experiment(
        excitations[kind],
        places,
        Analyser(sampling_hz, duration_s),
        None,
        instruments,
        settle,
        tuple(ground),
    )
    return _carried_out(test, twin, sensors, seed)


def _loaded(model: Twin | str | Path) -> Twin:
    return model if isinstance(model, Twin) else Twin.load(model)


def _instruments(noise: float, input_noise: float) -> dict[str, Instrument]:
    """Return instruments by kind: inputs with one noise, all else with the other."""
    noisy = Instrument(noise_fraction=noise)
    measured = Instrument(noise_fraction=input_noise)
    kinds = dict.fromkeys(INSTRUMENT_OF, noisy)
    return {**kinds, "force": measured, "torque": measured}


def _carried_out(
    test: Experiment, twin: Twin, sensors: Sequence[str] | None, seed: int
) -> Recording:
    if sensors is not None:
        test = replace(test, channels=(*test.inputs(twin), *sensors))
    return run(test, twin, seed)
