"""Dashpots that say no more than how a structure is damped: tendons that are no ports.

MJCF has no damping of modes. A twin with it is written with dashpots between many motions, none of
which is an element where anything could be wrong; texts in the file name them.
"""

from __future__ import annotations

import mujoco

NAMED = "dashpot_of_the_structure"
"""How the names of these texts begin; each holds the name of one tendon."""


def note_dashpot(spec: mujoco.MjSpec, tendon: str) -> None:
    """Say in a model that a tendon is such a dashpot."""
    number = 1 + sum(text.name.startswith(NAMED) for text in spec.texts)
    spec.add_text(name=f"{NAMED}_{number}", data=tendon)


def dashpots_noted(model: mujoco.MjModel) -> frozenset[str]:
    """Return the names of the tendons that a model says are such dashpots."""
    noted = set()
    for index in range(model.ntext):
        if mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, index).startswith(NAMED):
            first, size = int(model.text_adr[index]), int(model.text_size[index])
            noted.add(model.text_data[first : first + size].rstrip(b"\0").decode())
    return frozenset(noted)
