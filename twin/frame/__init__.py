"""A structure's design and the MuJoCo model that is built from it."""

from twin.frame.build import PLANE, SHIPPED, Design, to_mjcf, write_models
from twin.frame.cantilever import CantileverDesign
from twin.frame.design import FrameDesign, Ground, Kind, Pendulum, Storey
from twin.frame.drive import DriveDesign
from twin.frame.space import (
    Accelerometer,
    Column,
    Load,
    Shaker,
    SpaceFrameDesign,
    SpaceStorey,
    four_columns,
    unequal_columns,
)

__all__ = [
    "PLANE",
    "SHIPPED",
    "Accelerometer",
    "CantileverDesign",
    "Column",
    "Design",
    "DriveDesign",
    "FrameDesign",
    "Ground",
    "Kind",
    "Load",
    "Pendulum",
    "Shaker",
    "SpaceFrameDesign",
    "SpaceStorey",
    "Storey",
    "four_columns",
    "to_mjcf",
    "unequal_columns",
    "write_models",
]
