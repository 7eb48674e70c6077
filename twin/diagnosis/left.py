"""What laws leave at their ports: to the discrepancy, and to forces that stand for their form.

A further mechanism must be more than that to be a finding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.discrepancy import DISCREPANCY_SHARE
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.problem import Problem
from twin.diagnosis.readings import read_of_disturbance
from twin.estimation.fit import Fit
from twin.mechanisms.mechanism import Law, Mechanism
from twin.mechanisms.restoring_force import RestoringForce
from twin.mechanisms.unmeasured_force import UnmeasuredForce
from twin.model.linear import LinearModel

Array = NDArray[np.float64]


def greatest_law(
    hypothesis: Hypothesis, mechanisms: Sequence[Mechanism], sizes: Sequence[float | None],
    port: str | None,
) -> int | None:  # fmt: skip
    """Return the index of the greatest law at a port where a discrepancy stands."""
    laws = [i for i, m in enumerate(mechanisms)
            if isinstance(m, Law) and hypothesis.port_of(m.place) == port]  # fmt: skip
    return max(laws, key=lambda i: sizes[i] or 0.0, default=None)


def law_whose_form(
    hypothesis: Hypothesis, z: Array, sizes: Sequence[float | None], index: int
) -> int | None:
    """Return the index of the law whose form a force without a name stands for, if for one's.

    A force of the displacement that is smaller than a law of the same one is what that leaves.

    A latent force at a law's port is what that law leaves there, whatever its spectrum: the
    discrepancy has one band, and laws may leave several. It is another force where it is greater
    than the law, or narrower than every resonance, for what laws leave goes with the motion; and at
    the port of a stop, which errs only while it acts.

    Args:
        hypothesis: the twin with its mechanisms.
        z: values of its unknowns, (p,).
        sizes: RMS modal forces of the mechanisms (``forces``).
        index: of the force; None is returned for what is none.
    """
    mechanisms, model = hypothesis.at(z), hypothesis.problem.model
    force, size = mechanisms[index], sizes[index]
    if isinstance(force, RestoringForce):
        there = (i for i, m in enumerate(mechanisms) if force.includes(m))
        return next((i for i in there if (sizes[i] or 0.0) > (size or 0.0)), None)
    if not isinstance(force, UnmeasuredForce) or size is None or force.place not in model.ports:
        return None
    port = hypothesis.port_of(force.place)
    law = greatest_law(hypothesis, mechanisms, sizes, port) if port in hypothesis.ports else None
    base = hypothesis.problem.base(z[: len(hypothesis.problem.base_unknowns)])
    narrowest = float(np.min(np.diag(base.R) / np.diag(base.M))) / (2 * np.pi)
    if law is None or size > (sizes[law] or 0.0) or force.oscillator()[1] < narrowest:
        return None
    return law


def left_share(
    hypothesis: Hypothesis, fit: Fit, index: int, sizes: Sequence[float | None]
) -> float | None:
    """Return the share of the missing force that is left without a name at a law's port.

    To the discrepancy there, and to forces that stand for the law's form.

    Args:
        hypothesis: the twin with its mechanisms.
        fit: how it came out.
        index: of the law; None is returned for what is none.
        sizes: RMS modal forces of the mechanisms (``forces``).
    """
    mechanism, size = hypothesis.mechanisms[index], sizes[index]
    if not isinstance(mechanism, Law) or size is None:
        return None
    left = left_at(hypothesis.port_of(mechanism.place), hypothesis, fit, [(mechanism, size)])
    beside = (other or 0.0 for i, other in enumerate(sizes)
              if law_whose_form(hypothesis, fit.z, sizes, i) == index)  # fmt: skip
    left = float(np.linalg.norm([left, *beside]))
    return float(left / np.hypot(left, size)) if left or size else None


def left_at(
    port: str, hypothesis: Hypothesis, fit: Fit, sizes: Sequence[tuple[Mechanism, float | None]]
) -> float:
    """Return the RMS modal force by which the discrepancy at a port varies within a recording.

    Args:
        port: where laws stand.
        hypothesis: the twin with its mechanisms.
        fit: how it came out.
        sizes: RMS modal forces of mechanisms; of laws that act at times there, a share is left.
    """
    if port in hypothesis.ports:
        row = hypothesis.problem.model.port(port)
        latent = {one.place: one for one in hypothesis.latent(fit.z)}[port]
        return latent.varying(_longest_s(hypothesis.problem)) * float(np.linalg.norm(row))
    there = [size or 0.0 for law, size in sizes
             if isinstance(law, Law) and hypothesis.port_of(law.place) == port]  # fmt: skip
    return fit.values[f"discrepancy {port} share"] * float(np.linalg.norm(there))


def _longest_s(problem: Problem) -> float:
    """Return how long the longest recording is [s].

    A discrepancy that is slower is a force that stays: a structure at rest between jaws that grip
    it knows one, and no motion does.
    """
    return max(len(r.y) for r in problem.recordings) * problem.step_s


def smeared_by(hypothesis: Hypothesis, fit: Fit) -> dict[str, float]:
    """Return the RMS of what the jumps of laws leave in outputs, by their names.

    Args:
        hypothesis: the twin with its mechanisms.
        fit: how it came out.
    """
    readings = hypothesis.problem.readings
    return {one.place: max(one.rms, DISCREPANCY_SHARE * readings[one.place])
            for one in hypothesis.latent(fit.z) if one.place in hypothesis.smeared}  # fmt: skip


def left_in(
    hypothesis: Hypothesis, fit: Fit, lengths: Sequence[int], model: LinearModel,
    read: Sequence[Array | None], smears: Mapping[str, float],
) -> dict[str, float]:  # fmt: skip
    """Return the RMS that outputs read of what laws leave, at their ports and where they jump.

    Args:
        hypothesis: the twin with its mechanisms.
        fit: how it came out.
        lengths: samples of every recording.
        model: the structure.
        read: RMS that outputs read of each mechanism, (m,), of laws that act at times at least.
        smears: what the jumps of laws leave (``smeared_by``).
    """
    step_s = hypothesis.problem.step_s
    parts = [read_of_disturbance(one, lengths, model, step_s)
             for one in hypothesis.latent(fit.z) if one.place in hypothesis.ports]  # fmt: skip
    for mechanism, seen in zip(hypothesis.mechanisms, read, strict=True):
        port = hypothesis.port_of(mechanism.place) if isinstance(mechanism, Law) else None
        if port in hypothesis.erring and seen is not None:
            parts.append(fit.values[f"discrepancy {port} share"] * seen)
    whole = np.linalg.norm([np.zeros(len(model.outputs)), *parts], axis=0)
    return {name: max(float(rms), smears.get(name, 0.0))
            for name, rms in zip(model.outputs, whole, strict=True)}  # fmt: skip
