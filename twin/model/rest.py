"""The rest of any MuJoCo model under gravity, and its forces near it.

The equations of motion are projected on the null space of the active equality constraints, so a
mechanism closed by couplings, connections or welds gives the matrices of its true freedoms. Limits,
contacts and dry friction have no linear part and are left out.
"""

from __future__ import annotations

import copy

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from twin.errors import ModelError

Array = NDArray[np.float64]

STEP = 1e-6
"""Step of the finite differences [m, rad, m/s, rad/s]: below any gap that matters; forces round to
1e-16, so what is found is right to 1e-10 of the largest force over a metre."""


class Reduced:
    """The model's forces along the freedoms that its equality constraints leave."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = copy.copy(model)
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        # What is of second degree in speed, a limit or an instrument's buffer has no linear part.
        for values in (
            self.model.dof_dampingpoly,
            self.model.tendon_dampingpoly,
            self.model.actuator_dampingpoly,
            self.model.actuator_ctrllimited,
            self.model.actuator_forcelimited,
            self.model.jnt_actfrclimited,
            self.model.sensor_cutoff,
            self.model.actuator_delay,
            self.model.sensor_delay,
            self.model.sensor_interval,
        ):
            values[:] = 0
        self.data = mujoco.MjData(self.model)
        self.qpos: Array = self._closed(self.data.qpos.copy())
        self._evaluate(self.qpos)
        J, _ = self._constraints()
        self.basis: Array = linalg.null_space(J) if len(J) else np.eye(self.model.nv)

    def _evaluate(self, qpos: Array, qvel: Array | None = None) -> None:
        self.data.qpos[:] = qpos
        self.data.qvel[:] = 0 if qvel is None else qvel
        mujoco.mj_forward(self.model, self.data)

    def _constraints(self) -> tuple[Array, Array]:
        """Jacobian (rows, nv) and residual (rows,) of the active equality constraints."""
        data, nv = self.data, self.model.nv
        rows = np.flatnonzero(data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        J = np.array(data.efc_J[: data.nefc * nv]).reshape(data.nefc, nv)[rows]
        return J, np.array(data.efc_pos[rows])

    def moved(self, qpos: Array, step: Array) -> Array:
        """Return joint positions moved by joint displacements (nv,)."""
        moved = qpos.copy()
        mujoco.mj_integratePos(self.model, moved, step, 1)
        return moved

    def _closed(self, qpos: Array) -> Array:
        """Return the joint positions nearest to ``qpos`` that satisfy the constraints."""
        for _ in range(20):
            self._evaluate(qpos)
            J, residual = self._constraints()
            if not len(J) or np.max(np.abs(residual)) < 1e-14:
                return qpos
            qpos = self.moved(qpos, -np.asarray(np.linalg.lstsq(J, residual, rcond=None)[0], float))
        if np.max(np.abs(residual)) > 1e-8:
            raise ModelError("the equality constraints contradict each other")
        return qpos

    def at_rest(self) -> None:
        """Bring ``data`` to the equilibrium."""
        self._evaluate(self.qpos)

    def force(self, y: Array) -> Array:
        """Force along the freedoms at rest, displaced by y from ``qpos``, (n,)."""
        return self.displaced(y).T @ self._applied()

    def displaced(self, y: Array) -> Array:
        """Displace ``data`` by y from ``qpos``, at rest; return the freedoms there, (nv, n)."""
        self._evaluate(self._closed(self.moved(self.qpos, self.basis @ y)))
        J, _ = self._constraints()
        if not len(J):
            return self.basis
        return np.asarray(self.basis - np.linalg.lstsq(J, J @ self.basis, rcond=None)[0])

    def force_at_speed(self, speed: Array) -> Array:
        """Force along the freedoms at the equilibrium, moving with the given speed, (n,)."""
        self._evaluate(self.qpos, self.basis @ speed)
        return np.asarray(self.basis.T @ self._applied())

    def _applied(self) -> Array:
        data = self.data
        return np.asarray(data.qfrc_passive + data.qfrc_actuator - data.qfrc_bias)

    def control_forces(self) -> tuple[Array, Array]:
        """What a unit of each control does at the equilibrium.

        Returns:
            Forces along the freedoms, (n, nu), and the resultant of forces from outside, of an
            actuator at a site that pushes against nothing that moves, along x, y, z, (3, nu).
        """
        model, data = self.model, self.data
        columns = []
        for unit in np.vstack([np.zeros(model.nu), np.eye(model.nu)]):
            data.ctrl[:], data.act[:] = unit, 0.0
            for index in np.flatnonzero(model.actuator_dyntype == mujoco.mjtDyn.mjDYN_INTEGRATOR):
                data.act[model.actuator_actadr[index]] = unit[model.actuator_ctrladr[index]]
            self._evaluate(self.qpos)
            outside = np.zeros(3)
            for index in np.flatnonzero(model.actuator_trntype == mujoco.mjtTrn.mjTRN_SITE):
                site, against = model.actuator_trnid[index]
                if against < 0:
                    turned = data.site_xmat[site].reshape(3, 3)
                    push = turned @ model.actuator_gear[index, :3]
                    outside += data.actuator_force[model.actuator_outadr[index]] * push
            columns.append(np.concatenate([self.basis.T @ data.qfrc_actuator, outside]))
        data.ctrl[:], data.act[:] = 0.0, 0.0
        forces = np.column_stack(columns)
        forces = forces[:, 1:] - forces[:, :1]
        return forces[:-3], forces[-3:]

    def mass(self) -> Array:
        """Mass matrix of the freedoms, (n, n)."""
        self._evaluate(self.qpos)
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        return np.asarray(self.basis.T @ full @ self.basis)


def symmetric(matrix: Array) -> Array:
    """Remove the asymmetry that rounding leaves; keep one that is real (a servo, a rotor)."""
    mean = (matrix + matrix.T) / 2
    return mean if np.allclose(mean, matrix, rtol=1e-6, atol=1e-6 * np.abs(mean).max()) else matrix


def derivative(function: object, n: int) -> Array:
    """Fourth-order central differences of a function of n variables at zero, (m, n)."""
    assert callable(function)
    columns = []
    for step in STEP * np.eye(n):
        near = function(step) - function(-step)
        far = function(2 * step) - function(-2 * step)
        columns.append((8 * near - far) / (12 * STEP))
    return np.column_stack(columns)


def settle(reduced: Reduced) -> None:
    """Move ``reduced`` to its static equilibrium by Newton's method, if it is not there yet."""
    n = reduced.basis.shape[1]
    weight = float(reduced.model.body_mass.sum() * np.linalg.norm(reduced.model.opt.gravity))
    for _ in range(50):
        force = reduced.force(np.zeros(n))
        if np.max(np.abs(force), initial=0.0) <= 1e-12 * max(weight, 1.0):
            return
        K = -derivative(reduced.force, n)
        y = np.linalg.lstsq(K, force, rcond=1e-12)[0]
        y /= max(1.0, 2 * float(np.max(np.abs(y))))
        reduced.qpos = reduced._closed(reduced.moved(reduced.qpos, reduced.basis @ y))
        reduced._evaluate(reduced.qpos)
        J, _ = reduced._constraints()
        if len(J):
            reduced.basis = linalg.null_space(J)
        if np.max(np.abs(y)) < 1e-12:
            # No step left: rounding is all that remains, or a force that nothing resists.
            if np.max(np.abs(force)) <= 1e-6 * max(weight, 1.0):
                return
            break
    raise ModelError("the model has no static equilibrium near its initial position")


def equilibrium(model: mujoco.MjModel) -> Array:
    """Return the joint positions of the static equilibrium near the initial position, (nq,).

    Raises:
        ModelError: there is none.
    """
    reduced = Reduced(model)
    settle(reduced)
    return reduced.qpos
