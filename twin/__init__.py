"""A digital twin of a laboratory structure, on MuJoCo: test it, identify it, say what it lacks.

Examples:
    >>> import twin
    >>> hit = twin.hammer_test("two_storey_lumped")
    >>> twin.identify(hit).modal.natural_freq.round(2).tolist()
    [1.95, 6.72]

Everything is imported when it is first asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from twin.api import (
        design_controller,
        diagnose,
        hammer_test,
        identify,
        read,
        shaker_test,
    )
    from twin.channel import Channel
    from twin.errors import TwinError
    from twin.frame import FrameDesign
    from twin.modal import ModalModel, mac
    from twin.model import Twin
    from twin.model.from_sysid import from_sysid
    from twin.place import Place
    from twin.recording import Recording
    from twin.rehearsal.plan import read_plan
    from twin.rehearsal.rehearse import rehearse
    from twin.second_order import SecondOrderModel
    from twin.state_space import StateSpace

__version__ = "0.1.0"

__all__ = [
    "Channel",
    "FrameDesign",
    "ModalModel",
    "Place",
    "Recording",
    "SecondOrderModel",
    "StateSpace",
    "Twin",
    "TwinError",
    "design_controller",
    "diagnose",
    "from_sysid",
    "hammer_test",
    "identify",
    "mac",
    "read",
    "read_plan",
    "rehearse",
    "shaker_test",
]

_ROOMS = {
    "Channel": "channel",
    "FrameDesign": "frame",
    "ModalModel": "modal",
    "Place": "place",
    "Recording": "recording",
    "SecondOrderModel": "second_order",
    "StateSpace": "state_space",
    "Twin": "model",
    "TwinError": "errors",
    "from_sysid": "model.from_sysid",
    "mac": "modal",
    "read_plan": "rehearsal.plan",
    "rehearse": "rehearsal.rehearse",
}
"""Where the nouns are; the verbs are in ``twin.api``."""


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'twin' has no attribute '{name}'; it has {__all__}")
    value = getattr(import_module(f"twin.{_ROOMS.get(name, 'api')}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
