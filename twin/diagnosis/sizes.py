"""How large the effect of each mechanism is, beside what no law explains.

The size of what acts on the structure is the RMS of its modal force |p f|, that of an instrument's
fault the RMS of what it changes in its channel. No law is exact: beside one, what is smaller than
the discrepancy, or than the share of the laws' own forces that a discrepancy is expected to have,
is nobody's finding, however much evidence many samples make of it. The spectrum of an unmeasured
force is known much less well than a law, and so is that of what no name explains in a channel: of
what outputs read of them, a share may hide what they read less of. Of what laws leave at their
ports a channel reads something, too: it is no better than that.
Beside any of them, or a fault that is greater, an instrument that is within its calibration is not
told from their form; by itself it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.discrepancy import DISCREPANCY_SHARE
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.left import greatest_law, law_whose_form, left_at, left_in, smeared_by
from twin.diagnosis.predict import Predictor
from twin.diagnosis.problem import Problem
from twin.diagnosis.pushes import altered, edits, push_of, pushes, rms, unexplained_in
from twin.diagnosis.readings import read_of, read_of_disturbance
from twin.diagnosis.scales import ROUNDING
from twin.estimation.fit import Fit
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism, StructuralChange
from twin.model.linear import LinearModel

Array = NDArray[np.float64]

CALIBRATED = 0.005
"""Share of its reading to which an instrument is calibrated at best (ISO 16063-21): what distorts
it by less is no fault beside something else."""

SPECTRUM_SHARE = float(np.sqrt(2) - 1)
"""Share of its reading by which an unmeasured force, or what no name explains in a channel, is
inexact: 3 dB, by which a resonance's spectrum is off another smooth one in its own band."""


def forces(hypothesis: Hypothesis, z: Array, beside: Sequence[Predictor]) -> list[float | None]:
    """Return the RMS modal force of every mechanism; None for what changes an output only.

    Args:
        hypothesis: the twin with its mechanisms.
        z: values of its unknowns, (p,).
        beside: the same beside its recordings.
    """
    return [None if p is None else _size(p) for p in pushes(hypothesis, z, beside)]


def known_forces(hypothesis: Hypothesis, z: Array, beside: Sequence[Predictor]) -> list[float]:
    """Return the RMS modal force of every law that the model itself holds; see ``forces``."""
    model = hypothesis.problem.model
    known = [m for m in hypothesis.problem.known_at(z) if isinstance(m, Law)]
    first = len(hypothesis.laws)
    return [_size(push_of(law, i, model, beside)) for i, law in enumerate(known, first)]


def negligible(
    hypothesis: Hypothesis,
    fit: Fit,
    beside: Sequence[Predictor],
    sizes: Sequence[float | None],
    shown: bool = False,
) -> list[bool]:
    """Return of every mechanism whether it is smaller than what is left beside the others.

    The discrepancy at a port says how good the form of its greatest law is, not whether that is
    there; beside it, what is smaller is a matter of its form.

    Args:
        hypothesis: the twin with its mechanisms.
        fit: how it came out.
        beside: the same beside its recordings.
        sizes: of the mechanisms (``forces``).
        shown: whether the samples show faults of instruments by themselves.
    """
    model, problem = hypothesis.problem.model, hypothesis.problem
    mechanisms = hypothesis.at(fit.z)
    known = known_forces(hypothesis, fit.z, beside)
    of_model = [m for m in problem.known if isinstance(m, Law)]
    acting = [*zip(mechanisms, sizes, strict=True), *zip(of_model, known, strict=True)]
    hidden = _Hidden.beside(hypothesis, fit, beside)
    within = [_calibrated(m, model, beside) for m in mechanisms]
    out = []
    for index, (mechanism, size) in enumerate(zip(mechanisms, sizes, strict=True)):
        if law_whose_form(hypothesis, fit.z, sizes, index) is not None:
            out.append(True)
            continue
        left = max(inexact(mechanisms, sizes, index, known), of_known(problem, mechanism, known))
        own = hypothesis.port_of(mechanism.place) if isinstance(mechanism, Law) else None
        greatest = greatest_law(hypothesis, mechanisms, sizes, own)
        for port in (*hypothesis.ports, *hypothesis.erring):
            if port != own or index != greatest:
                left = max(left, left_at(port, hypothesis, fit, acting))
        if isinstance(mechanism, StructuralChange) and mechanism.verdict == "parameter":
            left = max(left, _scatter(problem, mechanism, beside))
        beyond = [not w for i, w in enumerate(within) if i != index]
        if within[index] and (known or shown or any(beyond)):
            out.append(True)
        elif size is not None:
            out.append(0.0 < size < left or hidden.hides(index))
        elif isinstance(mechanism, ChannelFault):
            out.append(hidden.loses(mechanism, hypothesis, beside))
        else:
            out.append(False)
    return out


def lost_in_laws(
    hypothesis: Hypothesis, fit: Fit, beside: Sequence[Predictor], fault: ChannelFault
) -> bool:
    """Return whether a fault changes its channels by less than they read of what laws leave."""
    return _Hidden.beside(hypothesis, fit, beside).loses(fault, hypothesis, beside)


@dataclass(frozen=True)
class _Hidden:
    """What outputs read of mechanisms, beside that of disturbances and of what no name explains.

    Attributes:
        read: RMS that outputs read of each mechanism, (m,); None of what changes an output only.
        disturbing: which mechanisms are disturbances.
        latent: RMS of what no name explains, (m,).
        faults: which mechanisms are faults of instruments, that such errors hide nothing of.
        smears: RMS of what the jumps of laws leave in an output, by its name.
        left: RMS that outputs read of what laws leave, at their ports and where they jump.
    """

    read: list[Array | None]
    disturbing: list[bool]
    latent: Array
    faults: list[bool]
    smears: dict[str, float]
    left: dict[str, float]

    @classmethod
    def beside(cls, hypothesis: Hypothesis, fit: Fit, beside: Sequence[Predictor]) -> _Hidden:
        """Return it for a hypothesis as it came out."""
        z = fit.z
        mechanisms, model = hypothesis.at(z), edits(hypothesis, z)[1][0]
        unexplained = unexplained_in(mechanisms)
        latent = np.array([unexplained.get(name, 0.0) for name in model.outputs])
        disturbing = [isinstance(m, Disturbance) for m in mechanisms]
        faults = [isinstance(m, ChannelFault) for m in mechanisms]
        read: list[Array | None] = [None] * len(mechanisms)
        h, n = hypothesis.problem.step_s, len(model.coordinates)
        lengths = [len(s.trial.y) for s in beside]
        heard = beside and (unexplained or any(disturbing) or (hypothesis.erring and any(faults)))
        acting = pushes(hypothesis, z, beside) if heard else []
        for i, (mechanism, push) in enumerate(zip(mechanisms, acting, strict=False)):
            if isinstance(mechanism, Disturbance):
                read[i] = read_of_disturbance(mechanism, lengths, model, h)
            elif push is not None:
                read[i] = read_of(np.split(push[:, :n], np.cumsum(lengths)[:-1]), model, h)
        smears = smeared_by(hypothesis, fit)
        left = left_in(hypothesis, fit, lengths, model, read, smears) if any(faults) else {}
        return cls(read, disturbing, latent, faults, smears, left)

    def hides(self, index: int) -> bool:
        """Return whether all that outputs read of a mechanism may be the others' spectrum."""
        seen = self.read[index]
        if seen is None:
            return False
        others = [r for i, (r, d) in enumerate(zip(self.read, self.disturbing, strict=True))
                  if d and i != index and r is not None]  # fmt: skip
        latent = 0.0 * self.latent if self.faults[index] else self.latent
        inexact_by = SPECTRUM_SHARE * np.linalg.norm([latent, *others], axis=0)
        return bool(np.all((seen < inexact_by) | (seen <= ROUNDING * np.max(seen))))

    def loses(
        self, fault: ChannelFault, hypothesis: Hypothesis, beside: Sequence[Predictor]
    ) -> bool:
        """Return whether a fault changes its channels by less than what laws leave there.

        What an instrument adds, a line or a drift, no law's form does.
        """
        model = hypothesis.problem.model
        left = self.left if _added_by(fault) is None or fault.generic else self.smears
        pairs = ((name, s) for name in fault.channels for s in beside)
        return all(name in left for name in fault.channels) and all(
            _altered_by(fault, s, name, model)[0] < left[name] for name, s in pairs
        )


def _scatter(problem: Problem, change: StructuralChange, beside: Sequence[Predictor]) -> float:
    """Return the RMS modal force by which dampings scatter beforehand; 0 for what does not damp.

    Stiffnesses and masses are calibrated where they are; of damping the modes' own are, not how it
    is spread over the structure, which no drawing says.
    """
    model = problem.model
    edited = change.edit(model)
    if not np.allclose(edited.K, model.K) or not np.allclose(edited.M, model.M):
        return 0.0
    n = len(model.coordinates)
    rates = [s.followed.moved()[1][:, :n] for s in beside]
    return problem.damping_tolerance * _size(np.vstack(rates) @ model.R.T)


def inexact(
    mechanisms: Sequence[Mechanism],
    sizes: Sequence[float | None],
    index: int,
    known: Sequence[float] = (),
) -> float:
    """Return the RMS modal force by which laws besides one are likely inexact.

    No law has quite the form that it is given.

    Args:
        mechanisms: of the hypothesis.
        sizes: their RMS modal forces.
        index: the one.
        known: RMS modal forces of the laws that the model itself holds.
    """
    left = [DISCREPANCY_SHARE * (s or 0.0)
            for i, (s, m) in enumerate(zip(sizes, mechanisms, strict=True))
            if i != index and isinstance(m, Law)]  # fmt: skip
    left += [DISCREPANCY_SHARE * s for s in known]
    return float(np.linalg.norm(left))


def of_known(problem: Problem, mechanism: Mechanism, known: Sequence[float]) -> float:
    """Return the RMS modal force by which a law of this kind that the model holds here scatters.

    Its value is known as well as a damping: what changes it by less is no other law beside it.

    Args:
        problem: the estimation problem.
        mechanism: what was found.
        known: RMS modal forces of the laws that the model itself holds.
    """
    if not isinstance(mechanism, Law):
        return 0.0
    row = problem.model.port(mechanism.place)
    laws = [m for m in problem.known if isinstance(m, Law)]
    there = [
        size
        for law, size in zip(laws, known, strict=True)
        if law.name == mechanism.name and np.allclose(problem.model.port(law.place), row)
    ]
    return problem.damping_tolerance * max(there, default=0.0)


def _calibrated(fault: Mechanism, model: LinearModel, beside: Sequence[Predictor]) -> bool:
    """Return whether a fault distorts its channels by less than a calibration is good for."""
    if not isinstance(fault, ChannelFault) or fault.of_motor or not fault.parameters:
        return False
    pairs = [_altered_by(fault, s, name, model) for name in fault.channels for s in beside]
    return max((change / level for change, level in pairs if level), default=0.0) < CALIBRATED


def _added_by(fault: ChannelFault) -> float | None:
    """Return the RMS of what an instrument adds, which has no one history; None if nothing."""
    instrument = fault.instrument(1.0)
    if instrument is None or not instrument.G.size:
        return None
    return float(np.sqrt(np.max(np.diag(instrument.C @ instrument.start @ instrument.C.T))))


def _altered_by(
    fault: ChannelFault, predictor: Predictor, name: str, model: LinearModel
) -> tuple[float, float]:
    """Return the RMS of what a fault changes in a channel, and of the channel."""
    driven = name in model.inputs
    names = model.inputs if driven else model.outputs
    values = predictor.inputs if driven else np.nan_to_num(predictor.trial.y) - predictor.followed.e
    column = list(names).index(name)
    level, added = float(rms(values[:, column])), _added_by(fault)
    if added is not None:
        return added, level
    return float(rms(altered(fault, predictor, names, values)[:, column])), level


def _size(push: Array) -> float:
    """Return the RMS of modal forces, (samples, n)."""
    return float(rms(np.linalg.norm(push, axis=1)))
