"""The model room: an MJCF model, what moves in it, and its exact linear equations.

``Twin`` and ``Motion`` are imported when first asked for: the rooms below need the nouns of
``twin.model.linear`` only, and not MuJoCo's simulation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from twin.model.motion import Motion
    from twin.model.twin import Twin

__all__ = ["Motion", "Twin"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        from twin.model import twin

        return getattr(twin, name)
    raise AttributeError(f"module 'twin.model' has no attribute '{name}'")
