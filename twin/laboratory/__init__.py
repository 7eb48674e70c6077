"""The virtual laboratory: excitations, the analyser and experiments on a twin."""

from twin.laboratory.analyser import Analyser
from twin.laboratory.earthquake import Earthquake
from twin.laboratory.excitation import Excitation, TimeBase
from twin.laboratory.experiment import Experiment, Performance, perform, run, settling_time
from twin.laboratory.ground_motion import read_ground_motion
from twin.laboratory.hammer import Hammer
from twin.laboratory.multisine import Multisine
from twin.laboratory.random_shaking import RandomShaking
from twin.laboratory.sweep import Sweep

__all__ = [
    "Analyser",
    "Earthquake",
    "Excitation",
    "Experiment",
    "Hammer",
    "Multisine",
    "Performance",
    "RandomShaking",
    "Sweep",
    "TimeBase",
    "perform",
    "read_ground_motion",
    "run",
    "settling_time",
]
