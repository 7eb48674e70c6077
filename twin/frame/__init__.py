"""A frame's design and the MuJoCo model that is built from it."""

from twin.frame.build import SHIPPED, to_mjcf, write_models
from twin.frame.design import FrameDesign, Ground, Kind, Pendulum, Storey

__all__ = [
    "SHIPPED",
    "FrameDesign",
    "Ground",
    "Kind",
    "Pendulum",
    "Storey",
    "to_mjcf",
    "write_models",
]
