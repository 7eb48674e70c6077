"""The verbs of the public interface: what the commands do, from Python.

Results print as tables, show as HTML in a notebook, and have ``.plot()``, ``.to_dict()`` and
``.save(path)``. Errors are ``twin.TwinError``, one line each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from twin.control.controller import Controller
from twin.diagnosis.result import Diagnosis
from twin.frame import Design
from twin.identification.result import Identification
from twin.laboratory import Excitation
from twin.model import Twin
from twin.recording import Recording

Model = Twin | Design | str | Path
Recorded = Recording | str | Path


def read(
    path: str | Path | Sequence[Mapping[str, Any]],
    channel_map: Mapping[str, str] | None = None,
    rate_hz: float | None = None,
) -> Recording:
    r"""Read a recording of any format and convert it to SI units.

    Examples:
        >>> import pathlib, tempfile, twin
        >>> folder = pathlib.Path(tempfile.mkdtemp())
        >>> _ = (folder / "tap.csv").write_text("time [ms],A3 [g]\n0,0\n10,0.5\n20,-0.25\n")
        >>> tap = twin.read(folder / "tap.csv")
        >>> tap
        tap.csv: 3 samples at 100 Hz (0.03 s)
          A3 [m/s^2]  output, RMS 3.165

    Args:
        path: the file, whose suffix says the format; or SEP 005 time series, a dictionary each.
        channel_map: {column: "channel [unit]"} for columns that do not say it themselves.
        rate_hz: sampling rate of a file without time [Hz].

    Raises:
        TwinError: one line that names the file, row and column, and what to do.
    """
    if not isinstance(path, str | Path):
        from twin.formats.sep005 import from_sep005

        return from_sep005(path, channel_map)
    from twin.formats import read_recording

    return read_recording(path, channel_map, rate_hz)


def hammer_test(
    model: Model = "two_storey",
    at: str = "floor1",
    *,
    peak_n: float = 20.0,
    width_s: float = 0.008,
    rate_hz: float = 32.0,
    duration_s: float = 32.0,
    noise: float = 0.01,
    input_noise: float = 0.0,
    sensors: Sequence[str] | None = None,
    seed: int = 0,
    repetition: int = 0,
) -> Recording:
    """Hit a twin with an instrumented hammer and record force and accelerations.

    Examples:
        >>> import twin
        >>> hit = twin.hammer_test("two_storey_lumped", rate_hz=64, duration_s=8)
        >>> hit.names, hit.samples
        (('force_floor1', 'acc_floor1', 'acc_floor2'), 512)

    Args:
        model: a twin, a frame's design, an MJCF file or the name of a shipped model.
        at: the place, or the actuator, that is hit.
        peak_n: largest force [N].
        width_s: duration of the contact [s].
        rate_hz: sampling rate [Hz].
        duration_s: length of the record [s].
        noise: of every response, share of its RMS.
        input_noise: of the measured force, share of its RMS.
        sensors: what is recorded besides the force, by name or axis ("acc_tip.x"); by default
            every acceleration that varies.
        seed: the same seed gives the same recording, bit for bit.
        repetition: of the same test: other noise.

    Raises:
        TwinError: the model has no such place, or a number is out of its range.
    """
    from twin.laboratory import Hammer
    from twin.laboratory.standard import tested

    blow = Hammer(width_s=width_s, peak_n=peak_n)
    return tested(
        _twin(model),
        blow,
        at,
        (),
        rate_hz,
        duration_s,
        noise,
        input_noise,
        sensors,
        seed,
        repetition,
    )


def shaker_test(
    model: Model = "two_storey",
    at: str | Sequence[str] = "ground",
    signal: Excitation | None = None,
    *,
    ground: Sequence[str] = (),
    level_n: float = 0.1,
    band_hz: tuple[float, float] = (0.5, 12.0),
    rate_hz: float = 32.0,
    duration_s: float = 32.0,
    noise: float = 0.01,
    input_noise: float = 0.0,
    sensors: Sequence[str] | None = None,
    seed: int = 0,
    repetition: int = 0,
) -> Recording:
    """Shake a twin at one or several points, or its ground, and record inputs and accelerations.

    Examples:
        >>> import twin
        >>> shaken = twin.shaker_test("two_storey_lumped", at="floor2", rate_hz=64, duration_s=8)
        >>> shaken.inputs
        ('force_floor2',)

    Args:
        model: a twin, a frame's design, an MJCF file or the name of a shipped model.
        at: the place, or the actuator, that the shaker drives; several have a shaker each, with
            signals of their own.
        signal: any excitation of ``twin.laboratory``; random noise in the band by default.
        ground: axes ("x", "y") along which the ground is shaken instead of ``at``.
        level_n: RMS of the random force [N], of a shaken ground its acceleration's [m/s^2].
        band_hz: lowest and highest frequency of the random force [Hz].
        rate_hz: sampling rate [Hz].
        duration_s: length of the record [s].
        noise: of every response, share of its RMS.
        input_noise: of the measured inputs, share of their RMS.
        sensors: what is recorded besides the inputs, as of ``hammer_test``.
        seed: the same seed gives the same recording, bit for bit.
        repetition: of the same test: another realisation, other noise.

    Raises:
        TwinError: the model has no such place, or a number is out of its range.
    """
    from twin.laboratory import RandomShaking
    from twin.laboratory.standard import tested

    chosen = signal or RandomShaking(level_n, band_hz)
    return tested(
        _twin(model), chosen, at, ground, rate_hz, duration_s, noise, input_noise, sensors, seed,
        repetition,
    )  # fmt: skip


def identify(
    recordings: Recorded | Sequence[Recorded],
    *,
    order: int | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    band_hz: tuple[float, float] | None = None,
    poles: Sequence[float] | None = None,
) -> Identification:
    """Identify natural frequencies, damping, shapes and matrices with their uncertainty.

    Examples:
        >>> import twin
        >>> found = twin.identify(twin.hammer_test("two_storey_lumped"))
        >>> print(*found.modal.natural_freq.round(2))
        1.95 6.72

    Args:
        recordings: one or several of one structure, or their files.
        order: number of states; the data decide by default.
        inputs: channels that drive; by default forces that move, or the shaken ground.
        outputs: channels that respond; by default all others.
        band_hz: frequencies to use [Hz]; by default what the input excites.
        poles: frequencies near which poles are chosen in the stabilisation diagram [Hz]; by
            default the data decide.

    Raises:
        TwinError: the recordings do not allow it; the message says why.
    """
    from twin.identification.identify import identify as whole
    from twin.identification.pole_diagram import poles_near

    pick = poles_near(poles) if poles is not None else None
    return whole(_read_all(recordings), order, None, inputs, outputs, band_hz, None, pick)


def diagnose(
    model: Model,
    train: Recorded | Sequence[Recorded],
    test: Recorded | Sequence[Recorded],
    *,
    tolerance: float | None = None,
    damping_tolerance: float | None = None,
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
    unknown_parameters: bool = False,
    seed: int = 0,
) -> Diagnosis:
    """Say where recordings and twin differ, what physics was left out, and model it.

    Examples:
        >>> import twin
        >>> train = twin.shaker_test("two_storey_lumped", "floor2", rate_hz=64, duration_s=16)
        >>> twin.diagnose("two_storey_lumped", train, train)
        Traceback (most recent call last):
        twin.errors.RecordingError: ... a test must be unseen

    Args:
        model: the twin as it stands: a twin, a design, an MJCF file or a shipped model's name.
        train: recordings to explain, or their files.
        test: recordings that only the result is shown on.
        tolerance: of masses and stiffnesses, relative; by default what the recordings show.
        damping_tolerance: of dampings; 10 % by default.
        added_mass: recording's name -> place -> mass bolted on for it [kg].
        unknown_parameters: the model's numbers are not known: they are identified first.
        seed: of what is random.

    Raises:
        TwinError: recordings or model cannot be used; the message says why.
    """
    from twin.diagnosis.pipeline import diagnose as whole

    options = tolerance, damping_tolerance, added_mass, unknown_parameters, seed
    return whole(_twin(model), _read_all(train), _read_all(test), *options)


def design_controller(
    identified: Identification | Recorded | Sequence[Recorded] | None = None,
    model: Model = "two_storey_absorber",
    *,
    known_input: str = "force_ground",
    rate_hz: float | None = None,
    delay: int = 1,
    torque_limit: float | None = None,
    noise: float = 0.01,
    seed: int = 0,
) -> Controller:
    """Design the LQG controller of the absorber, eqs. (54)-(59), on an identified frame.

    Examples:
        >>> import twin
        >>> controller = twin.design_controller(known_input="force_floor1")
        >>> controller.measurements
        ('acc_floor1', 'acc_floor2', 'angle_pendulum')

    Args:
        identified: the frame without pendulum: an identification, or recordings of it; a virtual
            hammer test of the model by default.
        model: the frame with its pendulum.
        known_input: what excites it and is measured: force_ground, force_floor1 or acc_ground.
        rate_hz: of the controller [Hz]; 32 by default.
        delay: samples from reading to acting.
        torque_limit: of the motor [N m]; 0.5 by default.
        noise: of the virtual hammer test, share of the RMS.
        seed: of that noise.

    Raises:
        TwinError: no controller can be designed; the message says why.
    """
    from twin.control.bare import pendulum_of
    from twin.control.plant import Plant
    from twin.control.study import Settings, hammer_tests, identified_model, identify_frame

    changes: dict[str, Any] = {"rate_hz": rate_hz, "torque_limit": torque_limit}
    settings = replace(Settings(), **{k: v for k, v in changes.items() if v is not None})
    plant = Plant(_twin(model), known_input, delay, settings.torque_limit)
    if not isinstance(identified, Identification):
        tests = hammer_tests(plant, noise, seed) if identified is None else _read_all(identified)
        identified = identify_frame(tests)
    believed = identified_model(identified, pendulum_of(plant.twin), known_input)
    return settings.design(believed, delay)


def _twin(model: Model) -> Twin:
    if isinstance(model, Twin):
        return model
    return Twin.load(model) if isinstance(model, str | Path) else Twin.of(model)


def _read_all(recordings: Recorded | Sequence[Recorded]) -> list[Recording]:
    several = [recordings] if isinstance(recordings, Recording | str | Path) else recordings
    return [each if isinstance(each, Recording) else read(each) for each in several]
