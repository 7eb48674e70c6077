"""What each mechanism does to the motion that was estimated: its modal forces, and readings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.plant import axis_of
from twin.diagnosis.predict import Predictor
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def pushes(hypothesis: Hypothesis, z: Array, beside: Sequence[Predictor]) -> list[Array | None]:
    """Return the modal forces of every mechanism, (samples, n), of a disturbance its RMS, (1, n).

    None for what changes an output only. A change of the structure has those of changes before it
    as further coordinates, which come behind.

    Args:
        hypothesis: the twin with its mechanisms.
        z: values of its unknowns, (p,).
        beside: the same beside its recordings.
    """
    mechanisms = hypothesis.at(z)
    at, models = edits(hypothesis, z)
    model = models[-1]
    found: dict[int, Array] = {
        index: np.vstack([_changed(before, after, s) for s in beside])
        for index, before, after in zip(at, models[:-1], models[1:], strict=True)
    }
    law = 0
    for index, mechanism in enumerate(mechanisms):
        if isinstance(mechanism, Law):
            found[index] = push_of(mechanism, law, model, beside)
            law += 1
        elif isinstance(mechanism, Disturbance):
            place = mechanism.place
            based = place in model.places("base")
            row = model.base[axis_of(model, place)].row if based else model.port(place)
            found[index] = mechanism.oscillator()[2] * row[None]
        elif isinstance(mechanism, ChannelFault) and set(mechanism.channels) <= set(model.inputs):
            own = [model.inputs.index(name) for name in mechanism.channels]
            moved = [altered(mechanism, s, model.inputs, s.inputs)[:, own] @ model.B[:, own].T
                     for s in beside]  # fmt: skip
            found[index] = np.vstack(moved)
    return [found.get(index) for index in range(len(mechanisms))]


def push_of(law: Law, index: int, model: LinearModel, beside: Sequence[Predictor]) -> Array:
    """Return the modal forces of a law, (samples, n).

    Args:
        law: the law.
        index: of it among those that the motion followed.
        model: that has its port.
        beside: the motion.
    """
    row, stiffness = model.port(law.place), law.parted()[1]
    whole = [s.followed.f[:, index] + stiffness * (s.followed.moved()[0][:, : len(row)] @ row)
             for s in beside]  # fmt: skip
    return np.outer(np.concatenate(whole), row)


def edits(hypothesis: Hypothesis, z: Array) -> tuple[list[int], list[LinearModel]]:
    """Return which mechanisms edit the model, in order, and the models before and after each."""
    problem = hypothesis.problem
    models = [problem.base(z[: len(problem.base_unknowns)])]
    changes = [(i, m) for i, m in enumerate(hypothesis.at(z)) if isinstance(m, StructuralChange)]
    changes.sort(key=lambda pair: pair[1].stage)
    for _, change in changes:
        models.append(change.edit(models[-1]))
    return [index for index, _ in changes], models


def _changed(before: LinearModel, after: LinearModel, predictor: Predictor) -> Array:
    """Return the modal forces that an edit adds, (samples, n).

    Args:
        before: the model without it.
        after: with it; its further coordinates come behind.
        predictor: the motion.
    """
    old, new = len(before.coordinates), len(after.coordinates)
    q, v = (x[:, :new] for x in predictor.followed.moved())
    a = np.gradient(v, predictor.trial.step_s, axis=0)
    force = np.zeros((len(q), old))
    for own, other, motion in (
        (before.M, after.M, a), (before.R, after.R, v), (before.K, after.K, q)
    ):  # fmt: skip
        matrix = np.array(other[:old])
        matrix[:, :old] -= own
        force += motion @ matrix.T
    return force


def altered(
    fault: ChannelFault, predictor: Predictor, names: Sequence[str], values: Array
) -> Array:
    """Return what a fault changes in channels, (samples, channels)."""
    columns = dict(zip(names, values.T, strict=True))
    changed = fault.distort(columns, 1 / predictor.trial.step_s)
    return np.column_stack([changed[n] - columns[n] for n in names])


def unexplained_in(mechanisms: Sequence[Mechanism]) -> dict[str, float]:
    """Return the RMS of what no name explains, of every channel that has some."""
    latent = (m for m in mechanisms if isinstance(m, ChannelFault) and m.generic)
    return {m.place: m.values["rms"] for m in latent}


def rms(values: Array) -> Array:
    """Return the root of the mean square of each column."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
