"""A model brought to what a modal test found: masses, stiffnesses and dampings within their priors.

The identified frequencies, damping ratios and residues weigh with their deviations, every parameter
with its prior; the maximum of the posterior is found by Gauss-Newton steps in logarithms, so that
nothing becomes negative. Each residue is a mode's shape at a sensor times its participation of an
input: it tells the masses, which frequencies alone do not.

Source: Friswell and Mottershead 1995, Finite Element Model Updating in Structural Dynamics,
chapter 8 (weighted penalty with priors).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from twin.diagnosis.exported import dashpots, including
from twin.errors import ModelError
from twin.identification.at_sensors import driven, modes_of, sensed
from twin.identification.result import Identification
from twin.mechanisms.mass import Mass
from twin.mechanisms.mechanism import Mechanism
from twin.mechanisms.stiffness import Stiffness
from twin.modal import ModalModel, mac
from twin.model import Twin
from twin.model.linear import LinearModel

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TOLERANCE, DAMPING_TOLERANCE = 0.01, 0.3
"""Prior deviations of masses and stiffnesses, and of modal dampings, as shares: weighed parts and
nominal sections are good for a per cent, dampings for a third (Blevins 1979)."""

SAME_MODE = np.log(1.3)
"""Logarithm of two frequencies' ratio beyond which modes are not taken for one."""

TELLABLE = 1e-6
"""Share of a port's pattern that is no sum of the others': below, it has none of its own."""

LEAST_SHARE = 1e-3
"""Share to which a residue is known at best: an accelerometer's and a load cell's calibration."""

ROUNDS = 3
"""Times modes are paired anew at the updated parameters."""


@dataclass(frozen=True)
class Change:
    """One parameter before and after.

    Attributes:
        kind: "stiffness", "mass" or "damping".
        place: port, body or "mode 1".
        unit: of the values.
        nominal, updated: the values; a stiffness is that seen at the port, a modal damping a ratio.
        std: standard deviation of the updated value.
        moved: in prior standard deviations of its logarithm.
    """

    kind: str
    place: str
    unit: str
    nominal: float
    updated: float
    std: float
    moved: float


@dataclass(frozen=True)
class Updated:
    """An updated model.

    Attributes:
        twin: with masses, springs and dashpots more or less at ports and bodies.
        changes: of every parameter.
        pairs: identified mode -> mode of the model, by index.
        before, after: modes of the model at the sensors.
        notes: what a reader has to know.
    """

    twin: Twin
    changes: tuple[Change, ...]
    pairs: dict[int, int]
    before: ModalModel
    after: ModalModel
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Parameters:
    """Patterns of stiffness (n, n), of mass (n, n) and modes whose damping may change."""

    model: LinearModel
    stiffness: dict[str, tuple[Array, float]]
    mass: dict[str, tuple[Array, float]]
    damping: tuple[int, ...]
    prior: Array

    @classmethod
    def of(cls, model: LinearModel, tolerance: float, modes: Sequence[int]) -> _Parameters:
        stiffness: dict[str, tuple[Array, float]] = {}
        known: list[Array] = []
        compliance = np.linalg.pinv(model.K)
        for name in model.places("drift"):
            row = model.port(name)
            seen = float(row @ compliance @ row)
            pattern = np.outer(row, row)
            rest = pattern.ravel() / np.linalg.norm(pattern)
            for other in known:
                rest = rest - other * float(other @ rest)
            if seen > 0 and float(rest @ rest) > TELLABLE:
                known.append(rest / np.linalg.norm(rest))
                stiffness[name] = (pattern, 1 / seen)
        total = np.linalg.norm(model.M)
        mass = {
            name: (body.translation.T @ body.translation, body.mass)
            for name, body in model.bodies.items()
            if body.mass * np.linalg.norm(body.translation) ** 2 > TELLABLE * total
        }
        sizes = [tolerance] * (len(stiffness) + len(mass)) + [DAMPING_TOLERANCE] * len(modes)
        return cls(model, stiffness, mass, tuple(modes), np.array(sizes))

    def values(self) -> Array:
        model = self.model
        least = 4e-3 * np.sqrt(np.maximum(np.diag(model.K) * np.diag(model.M), 0))
        dampings = [max(model.R[i, i], least[i]) for i in self.damping]
        held = [*self.stiffness.values(), *self.mass.values()]
        return np.array([size for _, size in held] + dampings)

    def at(self, z: Array) -> LinearModel:
        change = self.values() * np.expm1(self.prior * z)
        M, R, K = (np.array(x) for x in (self.model.M, self.model.R, self.model.K))
        first, second = len(self.stiffness), len(self.stiffness) + len(self.mass)
        for (pattern, _), value in zip(self.stiffness.values(), change, strict=False):
            K += value * pattern
        for (pattern, _), value in zip(self.mass.values(), change[first:], strict=False):
            M += value * pattern
        for mode, value in zip(self.damping, change[second:], strict=True):
            R[mode, mode] += value
        return replace(self.model, M=M, R=R, K=K)


def update(twin: Twin, found: Identification, tolerance: float = TOLERANCE) -> Updated:
    """Move a model's parameters to identified modes, within their priors.

    Args:
        twin: the model, whose sensors have the names of the identified outputs.
        found: what was identified.
        tolerance: prior deviation of masses and stiffnesses, as a share.

    Raises:
        ModelError: no sensor of the model was measured, or no identified mode is near one of it.
    """
    outputs = sensed(twin, found.outputs)
    if not outputs:
        raise ModelError(
            f"{twin.source}: no sensor is called {', '.join(found.outputs[:4])}: nothing to update"
        )
    inputs = driven(twin, found.inputs)
    model = twin.linear(inputs, outputs)
    before, _ = modes_of(model)
    measured = _residues(found, inputs, outputs)
    pairs = _paired(found, before, outputs)
    if not pairs:
        raise ModelError(f"{twin.source}: no identified mode is within 30 % of one of the model")
    parameters = _Parameters.of(model, tolerance, sorted(set(pairs.values())))
    z = np.zeros(len(parameters.prior))
    jacobian = np.zeros((0, len(z)))
    for _ in range(ROUNDS):

        def misfit(z: Array, pairs: dict[int, int] = pairs) -> Array:
            modal, residues = modes_of(parameters.at(z))
            return np.concatenate([_misfit(found, measured, modal, residues, pairs), z])

        done = optimize.least_squares(misfit, z, x_scale=1.0)
        z, jacobian = done.x, done.jac
        after, _ = modes_of(parameters.at(z))
        again = _paired(found, after, outputs)
        if again == pairs:
            break
        pairs = again
    std = np.sqrt(np.maximum(np.diag(np.linalg.inv(jacobian.T @ jacobian)), 0))
    moved = including(twin, _mechanisms(parameters, z))
    changes = _changes(parameters, z, std)
    return Updated(moved, changes, pairs, before, after, _notes(changes, pairs, found, tolerance))


def _residues(
    found: Identification, inputs: Sequence[str], outputs: Sequence[str]
) -> ComplexArray | None:
    """Return the identified residues at the model's sensors and inputs, (modes, m, r)."""
    fit = found.fit
    if fit is None or not inputs:
        return None
    p, dt = fit.parameters, 1 / found.sampling_hz
    participation = p.participation
    if fit.hold == "held":
        participation = participation * (p.poles / (np.exp(p.poles * dt) - 1))[:, None]
    at = [int(np.argmin(np.abs(p.omega - 2 * np.pi * f))) for f in found.modal.natural_freq]
    o, i = [found.outputs.index(n) for n in outputs], [found.inputs.index(n) for n in inputs]
    residues = p.psi.T[:, :, None] * participation[:, None, :]
    return np.asarray(residues[at][:, o][:, :, i])


def _paired(found: Identification, model: ModalModel, outputs: Sequence[str]) -> dict[int, int]:
    """Return identified mode -> mode of the model: near in frequency, alike in shape."""
    rows = [found.outputs.index(n) for n in outputs]
    mine = found.modal
    far = np.abs(np.log(mine.natural_freq[:, None] / model.natural_freq[None, :])) / SAME_MODE
    unlike = np.zeros(far.shape)
    if len(rows) > 1:
        unlike = 1 - mac(mine.mode_shape[rows], model.mode_shape)
    cost = np.minimum(far, 10) + unlike
    pairs = zip(*optimize.linear_sum_assignment(cost), strict=True)
    return {int(i): int(j) for i, j in pairs if far[i, j] < 1}


def _misfit(
    found: Identification, measured: ComplexArray | None, modal: ModalModel,
    residues: ComplexArray, pairs: dict[int, int],
) -> Array:  # fmt: skip
    """Return identified less modelled in standard deviations, one number a datum."""
    mine, out = found.modal, []
    f_std, z_std = mine.natural_freq_std, mine.damping_ratio_std
    share = max(float(found.nrmse), LEAST_SHARE)
    for i, j in pairs.items():
        j = min(j, len(modal.natural_freq) - 1)
        f, zeta = mine.natural_freq[i], mine.damping_ratio[i]
        df = f_std[i] if f_std is not None else share * f
        dz = z_std[i] if z_std is not None else share * zeta
        out += [(modal.natural_freq[j] - f) / df, (modal.damping_ratio[j] - zeta) / dz]
        if measured is not None:
            off = (residues[j] - measured[i]) / (share * np.abs(measured[i]).max())
            out += [*off.real.ravel(), *off.imag.ravel()]
    return np.array(out, float)


def _mechanisms(parameters: _Parameters, z: Array) -> tuple[Mechanism, ...]:
    change = parameters.values() * np.expm1(parameters.prior * z)
    first, second = len(parameters.stiffness), len(parameters.stiffness) + len(parameters.mass)
    springs = [Stiffness(n, float(c)) for n, c in zip(parameters.stiffness, change, strict=False)]
    masses = [Mass(n, float(c)) for n, c in zip(parameters.mass, change[first:], strict=False)]
    R = np.zeros_like(parameters.model.R)
    for mode, value in zip(parameters.damping, change[second:], strict=True):
        R[mode, mode] = value
    return (*springs, *masses, *dashpots(parameters.model, R))


def _changes(parameters: _Parameters, z: Array, std: Array) -> tuple[Change, ...]:
    model = parameters.model
    critical = 2 * np.sqrt(np.maximum(np.diag(model.K) * np.diag(model.M), 1e-300))
    named = [("stiffness", n, "N/m") for n in parameters.stiffness]
    named += [("mass", n, "kg") for n in parameters.mass]
    named += [("damping", f"mode {i + 1}", "") for i in parameters.damping]
    scale = np.ones(len(named))
    scale[len(named) - len(parameters.damping) :] = critical[list(parameters.damping)]
    values = parameters.values() / scale
    updated = values * np.exp(parameters.prior * z)
    spread = updated * parameters.prior * std
    return tuple(
        Change(*name, float(a), float(b), float(s), float(t))
        for name, a, b, s, t in zip(named, values, updated, spread, z, strict=True)
    )


def _notes(
    changes: Sequence[Change], pairs: dict[int, int], found: Identification, tolerance: float
) -> tuple[str, ...]:
    notes = []
    count = len(found.modal.natural_freq)
    if len(pairs) < count:
        notes.append(f"{count - len(pairs)} of {count} identified modes are near none of the model")
    far = [f"{c.kind} of {c.place}" for c in changes if abs(c.moved) > 3]
    if far:
        notes.append(
            f"warning: {', '.join(far)}: moved by more than three prior deviations; the model may "
            f"be wrong there, or the prior of {100 * tolerance:g} % too narrow (--tolerance)"
        )
    return tuple(notes)
