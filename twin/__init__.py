"""A digital twin of a laboratory frame, on MuJoCo."""

from twin.channel import Channel
from twin.errors import TwinError
from twin.modal import ModalModel, mac
from twin.place import Place
from twin.recording import Recording
from twin.second_order import SecondOrderModel
from twin.state_space import StateSpace

__all__ = [
    "Channel",
    "ModalModel",
    "Place",
    "Recording",
    "SecondOrderModel",
    "StateSpace",
    "TwinError",
    "mac",
]
__version__ = "0.1.0"
