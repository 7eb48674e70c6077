"""``twin test hammer`` and ``twin test shaker``: virtual tests that end in a CSV recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from twin.cli.common import Json, Out, Rerun, Seed
from twin.cli.laboratory_options import (
    HAMMER_HELP,
    SHAKER_HELP,
    AddedMass,
    Bandwidth,
    Bits,
    Channels,
    CutOff,
    Duration,
    InputNoise,
    InputRange,
    Model,
    Noise,
    PhysicsRate,
    PiezoCorner,
    Range,
    Rate,
    Repeat,
    Sensors,
    Structure,
)

if TYPE_CHECKING:
    from twin.laboratory import Analyser, Excitation, Experiment
    from twin.model import Twin

KINDS = ("random", "multisine", "sweep", "earthquake")


def register(app: typer.Typer) -> None:
    """Add the group ``test`` with its two commands."""
    group = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown")
    group.command("hammer", help=HAMMER_HELP)(hammer)
    group.command("shaker", help=SHAKER_HELP)(shaker)
    app.add_typer(group, name="test", help="Run a virtual hammer or shaker test.")


def hammer(
    structure: Structure = None,
    model: Model = "two_storey",
    floor: Annotated[int, typer.Option("--floor", help="Which floor to hit, from 1.")] = 1,
    at: Annotated[
        str | None, typer.Option("--at", metavar="ACTUATOR", help="Hit here; instead of --floor.")
    ] = None,
    width: Annotated[float, typer.Option("--width", help="Duration of the contact [s].")] = 0.008,
    peak: Annotated[float, typer.Option("--peak", help="Largest force [N].")] = 20.0,
    delay: Annotated[float, typer.Option("--delay", help="Pre-trigger [s].")] = 0.5,
    double: Annotated[
        float | None,
        typer.Option("--double", help="Hit again this long after the first contact [s]."),
    ] = None,
    double_strength: Annotated[
        float, typer.Option("--double-strength", help="Peak of the second hit over the first's.")
    ] = 0.4,
    rate: Rate = 32.0,
    duration: Duration = 32.0,
    cut_off: CutOff = None,
    physics_rate: PhysicsRate = None,
    channels: Channels = None,
    sensor: Sensors = None,
    noise: Noise = 0.01,
    input_noise: InputNoise = 0.0,
    range_: Range = None,
    input_range: InputRange = None,
    bits: Bits = 24,
    bandwidth: Bandwidth = None,
    piezo_corner: PiezoCorner = None,
    repeat: Repeat = 1,
    added_mass: AddedMass = None,
    out: Out = None,
    seed: Seed = 0,
    json: Json = None,
    rerun: Rerun = False,
) -> None:
    """Hit a floor."""
    from twin.cli.laboratory_run import LaboratoryRun, instruments, loaded
    from twin.laboratory import Analyser, Experiment, Hammer
    from twin.model import Twin

    experiment = Experiment(
        Hammer(width, peak, delay, double, double_strength),
        at or f"floor{floor}",
        Analyser(rate, duration, cut_off, physics_rate),
        instruments=instruments(
            (), noise, input_noise, range_, input_range, bits, bandwidth, piezo_corner
        ),
    )
    rig = loaded(Twin.load(structure or model), added_mass)
    experiment = _recording(experiment, rig, channels, sensor)
    LaboratoryRun(experiment, rig, seed, repeat).carry_out(out, json, rerun)


def shaker(
    structure: Structure = None,
    model: Model = "two_storey",
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at", help="ground (default), floor1, ..., or an actuator's name; repeat for more."
        ),
    ] = None,
    ground: Annotated[
        list[str] | None,
        typer.Option("--ground", metavar="AXIS", help="Shake the ground along x, y; repeat."),
    ] = None,
    kind: Annotated[str, typer.Option("--kind", help=", ".join(KINDS))] = "random",
    level: Annotated[
        float | None,
        typer.Option(
            "--level",
            help="RMS force [N], default 0.1, with --ground RMS acceleration [m/s^2]; of an "
            "earthquake the peak ground acceleration [m/s^2], default as recorded.",
        ),
    ] = None,
    band: Annotated[
        tuple[float, float] | None,
        typer.Option("--band", help="Lowest and highest frequency [Hz]; default 0.5 12."),
    ] = None,
    burst: Annotated[
        float | None,
        typer.Option("--burst", help="Random: shake for this share of the record, then ring down."),
    ] = None,
    periods: Annotated[
        int | None,
        typer.Option("--periods", help="Multisine: whole number of periods; default 4."),
    ] = None,
    law: Annotated[
        str | None, typer.Option("--law", help="Sweep: linear (default) or logarithmic.")
    ] = None,
    ground_motion: Annotated[
        Path | None,
        typer.Option("--ground-motion", metavar="FILE", help="Earthquake: CSV time,acceleration."),
    ] = None,
    settle: Annotated[
        float | None,
        typer.Option(
            "--settle",
            help="How long the shaker runs before the record begins [s]; default 0, for a "
            "multisine until the start has died out.",
        ),
    ] = None,
    rate: Rate = 32.0,
    duration: Annotated[
        float | None,
        typer.Option("--duration", help="Length of the record [s]; default 32, or the earthquake."),
    ] = None,
    cut_off: CutOff = None,
    physics_rate: PhysicsRate = None,
    channels: Channels = None,
    sensor: Sensors = None,
    noise: Noise = 0.01,
    input_noise: InputNoise = 0.0,
    range_: Range = None,
    input_range: InputRange = None,
    bits: Bits = 24,
    bandwidth: Bandwidth = None,
    piezo_corner: PiezoCorner = None,
    repeat: Repeat = 1,
    added_mass: AddedMass = None,
    out: Out = None,
    seed: Seed = 0,
    json: Json = None,
    rerun: Rerun = False,
) -> None:
    """Shake the ground or a floor."""
    from twin.cli.laboratory_run import LaboratoryRun, instruments, loaded
    from twin.laboratory import Analyser, Experiment
    from twin.model import Twin

    excitation = _shaking(kind, level, band, burst, periods, law, ground_motion)
    if duration is None:
        duration = getattr(excitation, "duration_s", 32.0)
    analyser = Analyser(rate, duration, cut_off, physics_rate)
    _check_band(excitation, analyser)
    rig = loaded(Twin.load(structure or model), added_mass)
    axes, places = tuple(ground or ()), _places(at, ground, rig)
    shaken = tuple(f"acc_ground.{axis}" for axis in axes)
    if excitation.moves_the_ground and not axes:
        shaken = ("acc_ground",)
    if settle is None:
        settle = _settling(excitation, rig, places)
    experiment = Experiment(
        excitation,
        places,
        analyser,
        instruments=instruments(
            shaken, noise, input_noise, range_, input_range, bits, bandwidth, piezo_corner
        ),
        settle_s=settle,
        ground=axes,
    )
    experiment = _recording(experiment, rig, channels, sensor)
    LaboratoryRun(experiment, rig, seed, repeat).carry_out(out, json, rerun)


def _places(at: list[str] | None, ground: list[str] | None, rig: Twin) -> tuple[str, ...]:
    """Return where shakers act: the ground of a frame where nothing else is said."""
    from twin.contract import names_in
    from twin.errors import ExperimentError, available

    if at and ground:
        raise ExperimentError("--at and --ground: a test has shakers or a shaken ground, not both")
    names = names_in(rig.compile())["actuator"]
    if not at and not ground and names and "force_ground" not in names:
        raise ExperimentError(f"{rig.source}: --at which actuator? There is {available(names)}")
    return () if ground else tuple(at or ("ground",))


def _recording(
    experiment: Experiment, rig: Twin, channels: str | None, sensor: list[str] | None
) -> Experiment:
    """Return the experiment with what is to be recorded."""
    from dataclasses import replace

    names = _names(channels)
    if sensor:
        names = (*(names or experiment.inputs(rig)), *sensor)
    return replace(experiment, channels=names)


def _names(channels: str | None) -> tuple[str, ...] | None:
    """Split "a, b"; None stays None."""
    if channels is None:
        return None
    return tuple(name.strip() for name in channels.split(",") if name.strip()) or None


def _shaking(
    kind: str,
    level: float | None,
    band: tuple[float, float] | None,
    burst: float | None,
    periods: int | None,
    law: str | None,
    ground_motion: Path | None,
) -> Excitation:
    """Make the excitation; what belongs to another kind of it is an error, not ignored."""
    from twin.errors import ExperimentError, available
    from twin.laboratory import Multisine, RandomShaking, Sweep, read_ground_motion

    if kind not in KINDS:
        raise ExperimentError(f"no kind of shaking '{kind}'; there is {available(KINDS)}")
    belongs = {
        "--burst": (burst, ("random",)),
        "--periods": (periods, ("multisine",)),
        "--law": (law, ("sweep",)),
        "--ground-motion": (ground_motion, ("earthquake",)),
        "--band": (band, ("random", "multisine", "sweep")),
    }
    for option, (value, kinds) in belongs.items():
        if value is not None and kind not in kinds:
            raise ExperimentError(f"{option} belongs to --kind {' or '.join(kinds)}, not to {kind}")
    if kind == "earthquake":
        if ground_motion is None:
            raise ExperimentError("an earthquake needs --ground-motion FILE")
        return read_ground_motion(ground_motion, level)
    rms = 0.1 if level is None else level
    band = band or (0.5, 12.0)
    if kind == "random":
        return RandomShaking(rms, band, burst)
    if kind == "multisine":
        return Multisine(rms, band, 4 if periods is None else periods)
    return Sweep(rms, band, law or "linear")


def _check_band(excitation: Excitation, analyser: Analyser) -> None:
    """Refuse a shaker that reaches beyond the analyser's band: it would shake unseen."""
    from twin.errors import ExperimentError

    nyquist = analyser.sampling_hz / 2
    highest = getattr(excitation, "band_hz", (0.0, 0.0))[1]
    if highest > nyquist:
        raise ExperimentError(
            f"the band reaches {highest:g} Hz, above the Nyquist frequency {nyquist:g} Hz of "
            f"{analyser.sampling_hz:g} Hz sampling; lower --band or raise --rate"
        )


def _settling(excitation: Excitation, rig: Twin, at: tuple[str, ...]) -> float:
    """Return how long a periodic excitation has to run until the rig answers periodically [s]."""
    from twin.laboratory import settling_time

    if excitation.kind != "multisine":
        return 0.0
    return settling_time(rig.released() if "ground" in at else rig)
