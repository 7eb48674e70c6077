"""What large motion adds to linear equations: pseudo-forces and readings, from MuJoCo itself.

    M q'' + R q' + K q = B u + g,    y = rest + Cd q + Cv q' + Ca q'' + Cu u + s

A structure that turns, twists or leans has inertia, gravity and springs that depend on where it is,
and sensors that turn with it. For a motion q, q' with inputs u, MuJoCo's acceleration and readings
less their own tangent at rest are that share, exact at the instant: g and s. Forces of laws that
the model lacks accelerate what has turned as well, and have to be given. Along an estimate of the
motion g and s are known to its accuracy, a few per cent of what is itself a few per cent
(pseudo-force method: Bathe 1996, Finite Element Procedures, section 9.3).
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from twin.contract import names_in
from twin.errors import ModelError
from twin.model.free_run import free_run
from twin.model.linear import LinearModel
from twin.model.nonlinear import structural_elements
from twin.model.port import ground_inputs
from twin.model.rest import Reduced, settle
from twin.model.sensing import sensor_columns
from twin.model.twin import Twin

Array = NDArray[np.float64]

INSTANT_S = 1e-6
"""Step of MuJoCo from which an acceleration is taken [s]: it rounds to 1e-10 of the speed."""

SMALL = 1e-5
"""Displacement, speed or input of the tangent's differences [SI]: what is of second degree cancels,
what is of third is 1e-10 of it, and so is rounding."""

PASSES = 2
"""Times that a simulation is done again with the pseudo-forces of the last one: what is left falls
by their share of all forces, a few per cent, each time."""

NEWTON = 3
"""Steps of MuJoCo's constraint solver: one, and two for rounding."""

FINER = 4
"""Pieces of a sample in which pseudo-forces are straight: they have twice the motion's frequencies
and more, of which straight lines lose (w h)^2 / 12."""

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_HELD = int(mujoco.mjtState.mjSTATE_CTRL) | int(mujoco.mjtState.mjSTATE_QFRC_APPLIED)
_STRAIGHT = (int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE))


@dataclass(frozen=True)
class Geometric:
    """What a motion adds to linear equations.

    Attributes:
        forces: pseudo-forces g on the coordinates, (samples, n).
        readings: s, what outputs read beside the linear equations with g, (samples, m).
    """

    forces: Array
    readings: Array

    def part(self, samples: slice) -> Geometric:
        """Return a part of the samples."""
        return Geometric(self.forces[samples], self.readings[samples])


class Geometry:
    """The equations of motion of a model beyond their tangent at rest, evaluated by MuJoCo."""

    def __init__(self, twin: Twin, model: LinearModel) -> None:
        """Prepare a twin and its linear model.

        Raises:
            ModelError: the model has a joint whose displacement is no single number, a spring that
                yields or an element else that is no smooth function of its place.
        """
        shaken = ground_inputs(model.inputs, model.base)
        driven, drives = twin.driven(tuple(shaken))
        self._linear = model
        self._model = bare = _smooth(driven, twin.source)
        self._data = mujoco.MjData(bare)
        rest = Reduced(driven)
        settle(rest)
        self._rest = rest.qpos
        assert model.shapes is not None
        own = slice(bare.nv - len(model.shapes), bare.nv)
        self._shapes = np.zeros((bare.nv, model.shapes.shape[1]))
        self._shapes[own] = model.shapes
        mass, still = np.zeros((bare.nv, bare.nv)), mujoco.MjData(bare)
        still.qpos[:] = self._rest
        mujoco.mj_forward(bare, still)
        mujoco.mj_fullM(bare, still, mass)
        self._momentum = np.zeros((len(model.coordinates), bare.nv))
        self._momentum[:, own] = model.shapes.T @ mass[own, own]
        columns = sensor_columns(bare)
        self._outputs = [columns[name] for name in model.outputs]
        names = list(names_in(bare)["actuator"])
        at = {column: drives[axis] for axis, column in shaken.items()}
        self._inputs = [
            int(bare.actuator_actadr[names.index(at.get(i, name))])
            for i, name in enumerate(model.inputs)
        ]
        self._level, self._tangent = self._about_rest()

    def along(self, q: Array, v: Array, u: Array, pushed: Array | None = None) -> Geometric:
        """Return what a motion adds.

        Args:
            q: displacement of the model's coordinates, (samples, n).
            v: their velocity, (samples, n).
            u: inputs, (samples, r).
            pushed: further forces on the coordinates, which the model lacks, (samples, n); none
                without.
        """
        x = np.hstack([q, v, u])
        pushed = np.zeros_like(q) if pushed is None else pushed
        more = self._exact(x, pushed) - self._level - x @ self._tangent
        n, model = q.shape[1], self._linear
        seen = more[:, n:] - more[:, :n] @ np.linalg.solve(model.M, model.Ca.T)
        return Geometric(more[:, :n] - pushed, seen)

    def moved_by(self, geometric: Geometric, rate_hz: float) -> Array:
        """Return what pseudo-forces change in the outputs of the linear model, (samples, m)."""
        u = np.zeros((len(geometric.forces), len(self._linear.inputs)))
        return self._run(u, geometric.forces, rate_hz)[1] + geometric.readings

    def simulated(self, u: Array, rate_hz: float) -> Array:
        """Return what large motion changes in a free run from rest, (samples, m).

        Args:
            u: inputs, (samples, r).
            rate_hz: samples per second.
        """
        times = np.arange(FINER * (len(u) - 1) + 1) / FINER
        u = np.column_stack([np.interp(times, np.arange(len(u)), column) for column in u.T])
        rate_hz, n = FINER * rate_hz, len(self._linear.coordinates)
        forces = np.zeros((len(u), n))
        x, linear = self._run(u, forces, rate_hz)
        for _ in range(PASSES):
            found = self.along(x[:, :n], x[:, n:], u)
            x, moved = self._run(u, found.forces, rate_hz)
        return np.asarray((moved + found.readings - linear)[::FINER])

    def _run(self, u: Array, forces: Array, rate_hz: float) -> tuple[Array, Array]:
        """Return states [q, q'] and outputs of the linear model with forces on its coordinates."""
        model, n = self._linear, forces.shape[1]
        inputs = (*model.inputs, *(f"force on {name}" for name in model.coordinates))
        wide = replace(
            model, inputs=inputs, B=np.hstack([model.B, np.eye(n)]),
            Cu=np.hstack([model.Cu, np.zeros((len(model.outputs), n))]),
        )  # fmt: skip
        eye, none = np.eye(n), np.zeros((n, n))
        states = wide.seeing(np.vstack([eye, none]), np.vstack([none, eye]))
        every = np.hstack([u, forces])
        return free_run(states, every, rate_hz), free_run(wide, every, rate_hz) - model.rest

    def _exact(self, x: Array, pushed: Array) -> Array:
        """Return MuJoCo's M q'' and readings at states, inputs and forces, (samples, n + m)."""
        model, n = self._model, self._shapes.shape[1]
        first = np.zeros((len(x), mujoco.mj_stateSize(model, _STATE)))
        first[:, 1 : 1 + model.nq] = self._rest + x[:, :n] @ self._shapes.T
        speeds = slice(1 + model.nq, 1 + model.nq + model.nv)
        first[:, speeds] = x[:, n : 2 * n] @ self._shapes.T
        first[:, 1 + model.nq + model.nv + np.array(self._inputs, int)] = x[:, 2 * n :]
        held = np.zeros((len(x), 1, model.nu + model.nv))
        held[:, 0, model.nu :] = pushed @ np.linalg.solve(self._linear.M, self._momentum)
        mujoco.set_mju_user_warning(lambda message: None)  # else a log file in the user's folder
        try:
            then, read = rollout.rollout(model, self._data, first, held, control_spec=_HELD)
        finally:
            mujoco.set_mju_user_warning(None)
        acceleration = (then[:, 0, speeds] - first[:, speeds]) / INSTANT_S
        return np.hstack([acceleration @ self._momentum.T, read[:, 0, self._outputs]])

    def _about_rest(self) -> tuple[Array, Array]:
        """Return what MuJoCo says at rest, (n + m,), and its tangent there, (2 n + r, n + m)."""
        largest = np.max(np.abs(self._shapes), axis=0)
        sizes = SMALL / np.concatenate([largest, largest, np.ones(len(self._linear.inputs))])
        steps = np.diag(sizes)
        none = np.zeros((len(steps), len(largest)))
        slope = (self._exact(steps, none) - self._exact(-steps, none)) / (2 * sizes[:, None])
        return self._exact(0 * steps[:1], none[:1])[0], slope


def geometry_of(twin: Twin, model: LinearModel) -> Geometry | None:
    """Return the geometry of a twin, None where its elements do not allow to tell it apart."""
    try:
        return Geometry(twin, model)
    except ModelError:
        return None


def _smooth(model: mujoco.MjModel, source: str) -> mujoco.MjModel:
    """Return a model to be asked for accelerations, its springs and dashpots linear."""
    model = copy.copy(model)
    _straight(model, source)
    for values in (
        *(model.jnt_stiffnesspoly, model.tendon_stiffnesspoly),
        *(model.dof_dampingpoly, model.tendon_dampingpoly),
        *(model.dof_frictionloss, model.tendon_frictionloss),
        *(model.jnt_limited, model.tendon_limited),
    ):
        values[:] = 0
    model.eq_solimp[:, :2] = 0.9999  # a coupling then gives way by 1e-4 of what it resists
    # couplings alone are quadratic: Newton's method has them in a step, however small the motion
    model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
    model.opt.tolerance, model.opt.iterations = 0.0, NEWTON
    model.opt.timestep = INSTANT_S
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for element in structural_elements(model, data, weights=False):
        raise ModelError(f"{source}: {element}")
    return model


def _straight(model: mujoco.MjModel, source: str) -> None:
    if not np.all(np.isin(model.jnt_type, _STRAIGHT)):
        raise ModelError(f"{source}: a ball or free joint has no single displacement")
    ties: Sequence[int] = model.eq_type[model.eq_active0.astype(bool)].tolist()
    if any(kind != int(mujoco.mjtEq.mjEQ_JOINT) for kind in ties):
        raise ModelError(f"{source}: a loop is closed by a connection or a weld")
