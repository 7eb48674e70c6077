"""What the truth may differ by from the model that the controller was designed on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from twin.control.absorber import GROUND
from twin.errors import ModelError


@dataclass(frozen=True)
class Perturbation:
    """Factors on the truth: the rig is never quite what was identified.

    Attributes:
        stiffness: of each storey, from the ground up.
        mass: of each floor.
    """

    stiffness: tuple[float, ...] = ()
    mass: tuple[float, ...] = ()

    @classmethod
    def drawn(cls, floors: int, spread: float, rng: np.random.Generator) -> Perturbation:
        """Draw factors independently and uniformly from 1 - spread to 1 + spread."""
        factors = 1 + spread * rng.uniform(-1, 1, 2 * floors)
        return cls(tuple(factors[:floors].tolist()), tuple(factors[floors:].tolist()))

    def apply(self, model: mujoco.MjModel) -> None:
        """Change a compiled model.

        Raises:
            ModelError: a storey without a spring of its own.
        """
        for number, factor in enumerate(self.mass, start=1):
            body = model.body(f"floor{number}").id
            model.body_mass[body] *= factor
            model.body_inertia[body] *= factor
        for number, factor in enumerate(self.stiffness, start=1):
            joints, tendon = _springs(model, number)
            model.jnt_stiffness[joints] *= factor
            if tendon >= 0:
                model.tendon_stiffness[tendon] *= factor
        mujoco.mj_setConst(model, mujoco.MjData(model))


def _springs(model: mujoco.MjModel, storey: int) -> tuple[Sequence[int], int]:
    """Return the joints between a floor and what carries it, and its tendon or -1."""
    lower = {model.body(GROUND).id, 0}
    if storey > 1:
        lower.add(model.body(f"floor{storey - 1}").id)
    joints: list[int] = []
    body = model.body(f"floor{storey}").id
    while body not in lower:
        first = model.body_jntadr[body]
        joints += range(first, first + model.body_jntnum[body])
        body = model.body_parentid[body]
    tendon = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TENDON, f"storey{storey}")
    sprung = np.any(model.jnt_stiffness[joints]) or (
        tendon >= 0 and np.any(model.tendon_stiffness[tendon])
    )
    if not sprung:
        raise ModelError(f"storey{storey} has no spring of its own whose stiffness could change")
    return joints, tendon
