"""Springs whose stiffness changes with time: what the exported twin has for a drift."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco

from twin.model.nonlinear import NonlinearElement

KINDS = {
    int(mujoco.mjtTrn.mjTRN_TENDON): ("tendon", mujoco.mjtObj.mjOBJ_TENDON),
    int(mujoco.mjtTrn.mjTRN_JOINT): ("joint", mujoco.mjtObj.mjOBJ_JOINT),
}


def drifting_springs(model: mujoco.MjModel) -> Iterator[NonlinearElement]:
    """Yield actuators that stand for a spring growing with time.

    Their activation is the integral of their control, the time where that is 1, and their gain is
    in proportion to the displacement along a tendon or joint.

    Args:
        model: as it was compiled.
    """
    for index in range(model.nu):
        integrates = int(model.actuator_dyntype[index]) == int(mujoco.mjtDyn.mjDYN_INTEGRATOR)
        affine = int(model.actuator_gaintype[index]) == int(mujoco.mjtGain.mjGAIN_AFFINE)
        slope = -float(model.actuator_gainprm[index, 1])
        kind = KINDS.get(int(model.actuator_trntype[index]))
        if not (integrates and affine and slope and kind):
            continue
        what, object_kind = kind
        at = mujoco.mj_id2name(model, object_kind, int(model.actuator_trnid[index, 0]))
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, index)
        yield NonlinearElement(
            f"actuator {name}", at or "", "stiffness_drift", {"rate": slope},
            f"a {what}'s spring that grows by {slope:.4g} a second",
        )  # fmt: skip
