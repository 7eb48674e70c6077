"""``twin test hammer`` and ``twin test shaker``: virtual tests that end in a CSV recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from twin.cli.common import Json, Out, Seed

if TYPE_CHECKING:
    from twin.laboratory import Analyser, Excitation
    from twin.model import Twin

HAMMER_HELP = """Hit a floor with an instrumented hammer and record force and accelerations.

The defaults are the paper's test: first floor, 32 Hz, 32 s, anti-alias cut-off 16 Hz.

Example: `twin test hammer --floor 1 --noise 0.01 --repeat 3 --out hits --seed 0`
"""

SHAKER_HELP = """Shake the ground or a floor and record force and accelerations.

On the ground the base plate is unbolted and slides on its suspension; the shaker pushes it through
an ideal stinger (stiff, without mass) with a load cell. An earthquake moves the ground itself: the
recording then has acc_ground and no force.

Example: `twin test shaker --at ground --kind multisine --band 0.5 12 --level 0.2 --periods 4
--duration 128 --out shaken`
"""

KINDS = ("random", "multisine", "sweep", "earthquake")

Model = Annotated[
    str, typer.Option("--model", metavar="MODEL", help="MJCF file, or a model that is shipped.")
]
Rate = Annotated[float, typer.Option("--rate", help="Sampling rate [Hz].")]
Duration = Annotated[float, typer.Option("--duration", help="Length of the record [s].")]
CutOff = Annotated[
    float | None,
    typer.Option("--cut-off", help="Anti-alias cut-off, -6 dB [Hz]; default half the rate."),
]
PhysicsRate = Annotated[
    float | None,
    typer.Option("--physics-rate", help="Rate of the simulation [Hz], a multiple of --rate."),
]
Channels = Annotated[
    str | None,
    typer.Option(
        "--channels",
        metavar="NAMES",
        help="What to record, with commas: force_floor1,acc_floor2,disp_floor1. Default: the "
        "input, all accelerations and the pendulum's angle.",
    ),
]
Noise = Annotated[
    float, typer.Option("--noise", help="Noise of every response, as a fraction of its RMS.")
]
InputNoise = Annotated[
    float,
    typer.Option("--input-noise", help="Noise of the measured input, as a fraction of its RMS."),
]
Range = Annotated[
    float | None,
    typer.Option("--range", help="Range of the accelerometers, +- [m/s^2]; default automatic."),
]
InputRange = Annotated[
    float | None,
    typer.Option("--input-range", help="Range of the load cell, +- [N]; default automatic."),
]
Bits = Annotated[int, typer.Option("--bits", help="Bits of the converters over their range.")]
Bandwidth = Annotated[
    float | None,
    typer.Option("--bandwidth", help="One-pole bandwidth of the accelerometers [Hz]."),
]
PiezoCorner = Annotated[
    float | None,
    typer.Option("--piezo-corner", help="High-pass corner of the accelerometers [Hz]."),
]
AddedMass = Annotated[
    list[str] | None,
    typer.Option("--added-mass", metavar="PLACE=KG", help="Mass bolted to a floor; repeat."),
]
Repeat = Annotated[int, typer.Option("--repeat", min=1, help="How many times to do the test.")]


def register(app: typer.Typer) -> None:
    """Add the group ``test`` with its two commands."""
    group = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown")
    group.command("hammer", help=HAMMER_HELP)(hammer)
    group.command("shaker", help=SHAKER_HELP)(shaker)
    app.add_typer(group, name="test", help="Run a virtual hammer or shaker test.")


def hammer(
    model: Model = "two_storey",
    floor: Annotated[int, typer.Option("--floor", help="Which floor to hit, from 1.")] = 1,
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
) -> None:
    """Hit a floor."""
    from twin.cli.laboratory_run import LaboratoryRun, instruments, loaded
    from twin.laboratory import Analyser, Experiment, Hammer
    from twin.model import Twin

    experiment = Experiment(
        Hammer(width, peak, delay, double, double_strength),
        f"floor{floor}",
        Analyser(rate, duration, cut_off, physics_rate),
        _names(channels),
        instruments(
            "force", noise, input_noise, range_, input_range, bits, bandwidth, piezo_corner
        ),
    )
    LaboratoryRun(experiment, loaded(Twin.load(model), added_mass), seed, repeat).carry_out(
        out, json
    )


def shaker(
    model: Model = "two_storey",
    at: Annotated[str, typer.Option("--at", help="ground, floor1, floor2, ...")] = "ground",
    kind: Annotated[str, typer.Option("--kind", help=", ".join(KINDS))] = "random",
    level: Annotated[
        float | None,
        typer.Option(
            "--level",
            help="RMS force [N], default 0.1; of an earthquake the peak ground acceleration "
            "[m/s^2], default as recorded.",
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
    rig = loaded(Twin.load(model), added_mass)
    if settle is None:
        settle = _settling(excitation, rig, at)
    measured = "acc_ground" if excitation.moves_the_ground else "force"
    experiment = Experiment(
        excitation,
        at,
        analyser,
        _names(channels),
        instruments(
            measured, noise, input_noise, range_, input_range, bits, bandwidth, piezo_corner
        ),
        settle,
    )
    LaboratoryRun(experiment, rig, seed, repeat).carry_out(out, json)


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


def _settling(excitation: Excitation, rig: Twin, at: str) -> float:
    """Return how long a periodic excitation has to run until the rig answers periodically [s]."""
    from twin.laboratory import settling_time

    if excitation.kind != "multisine":
        return 0.0
    return settling_time(rig.released() if at == "ground" else rig)
