"""The options that ``twin test hammer`` and ``twin test shaker`` share, and their help."""

from __future__ import annotations

from typing import Annotated

import typer

HAMMER_HELP = """Hit a structure with an instrumented hammer and record force and accelerations.

The defaults are the paper's test: first floor, 32 Hz, 32 s, anti-alias cut-off 16 Hz. Any
actuator of any model can be hit.

Example: `twin test hammer two_storey_lumped --floor 1 --noise 0.01 --repeat 3 --out hits`

Example: `twin test hammer cantilever --at force_tip --peak 1 --rate 256 --duration 16 --out hits`
"""

SHAKER_HELP = """Shake a structure at some points, or its ground; record inputs and accelerations.

Several `--at` are one shaker each, with signals of their own. `--ground x` prescribes the motion of
the ground along an axis, `--level` is then in m/s^2.

On a frame's `--at ground` the base plate is unbolted and slides on its suspension; the shaker
pushes it through an ideal stinger (stiff, without mass) with a load cell. An earthquake moves the
ground itself: the recording then has acc_ground and no force.

Example: `twin test shaker --at ground --kind multisine --band 0.5 12 --level 0.2 --periods 4
--duration 128 --out shaken`

Example: `twin test shaker portal_3d --at force_floor1_x --at force_floor2_y --rate 128`

Example: `twin test shaker portal_3d --ground y --level 0.3 --rate 128 --out shaken`
"""

Structure = Annotated[
    str | None,
    typer.Argument(metavar="[MODEL]", help="MJCF file, or a model that is shipped; as --model."),
]
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
Sensors = Annotated[
    list[str] | None,
    typer.Option(
        "--sensor",
        metavar="NAME",
        help="Record the inputs and this sensor, by name or by axis (acc_tip.x); repeat.",
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
