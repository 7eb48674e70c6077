"""A hypothesis: which mechanisms, and which of their parameters a fit may change."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twin.mechanisms.mechanism import Law, Mechanism

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """One parameter that a fit changes.

    Attributes:
        index: of its mechanism in the hypothesis.
        name: of the parameter.
        log: whether its logarithm is what is fitted.
        size: a change of it that matters, in the fitted coordinate.
        prior_std: standard deviation of its normal prior, or infinite.
        prior_mean: of that prior.
    """

    index: int
    name: str
    log: bool
    size: float
    prior_std: float = np.inf
    prior_mean: float = 0.0


@dataclass(frozen=True)
class Hypothesis:
    """Mechanisms on top of a model.

    Attributes:
        base: deviations that every rig has (its masses, stiffnesses and dampings), with priors.
        tolerance: the priors' standard deviation for each of ``base``.
        found: the mechanisms that the hypothesis is about.
    """

    base: tuple[Mechanism, ...]
    tolerance: tuple[float, ...]
    found: tuple[Mechanism, ...] = ()

    @property
    def mechanisms(self) -> tuple[Mechanism, ...]:
        """All mechanisms, those of the base first."""
        return self.base + self.found

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """Mechanism and place of each that was found."""
        return tuple((m.name, m.place) for m in self.found)

    @property
    def sticks(self) -> bool:
        """Whether something that was found sticks and slips."""
        return any(isinstance(m, Law) and m.sticks for m in self.found)

    def including(self, *more: Mechanism) -> Hypothesis:
        """Return the hypothesis with further mechanisms.

        A deviation of the base that one of them stands for goes back to zero.
        """
        taken = {(type(m), m.place) for m in more}
        base = tuple(
            b.with_values({"change": 0.0}) if (type(b), b.place) in taken else b for b in self.base
        )
        return replace(self, base=base, found=self.found + more)

    def unknowns(self) -> tuple[Unknown, ...]:
        """Return what a fit changes, the base's deviations first."""
        out = []
        taken = {(type(m), m.place) for m in self.found}
        for index, mechanism in enumerate(self.mechanisms):
            if index < len(self.base) and (type(mechanism), mechanism.place) in taken:
                continue  # the finding has that freedom now
            for name, parameter in mechanism.parameters.items():
                value = float(mechanism.values[name])
                if index < len(self.base):
                    std = self.tolerance[index]
                    out.append(Unknown(index, name, False, std, std))
                elif name in (known := mechanism.priors()):
                    mean, std = known[name]
                    out.append(Unknown(index, name, parameter.scale == "log", std, std, mean))
                elif parameter.scale == "log":
                    out.append(Unknown(index, name, True, 0.3))
                else:
                    out.append(Unknown(index, name, False, max(0.3 * abs(value), 1e-12)))
        return tuple(out)

    def vector(self, unknowns: tuple[Unknown, ...]) -> Array:
        """Return the unknowns' values in the fitted coordinates, (unknowns,)."""
        mechanisms = self.mechanisms
        values = [float(mechanisms[u.index].values[u.name]) for u in unknowns]
        return np.array(
            [np.log(max(v, 1e-300)) if u.log else v for u, v in zip(unknowns, values, strict=True)]
        )

    def at(self, unknowns: tuple[Unknown, ...], vector: Array) -> Hypothesis:
        """Return the hypothesis with the unknowns at other values, (unknowns,) or (.., unknowns).

        More than one vector gives mechanisms whose parameters are arrays (1, vectors).
        """
        mechanisms = list(self.mechanisms)
        by_mechanism: dict[int, dict[str, object]] = {}
        for column, unknown in enumerate(unknowns):
            value = np.asarray(vector)[..., column]
            if unknown.log:
                value = np.exp(np.clip(value, -200, 200))
            plain = float(value) if np.ndim(value) == 0 else value[None, :]
            by_mechanism.setdefault(unknown.index, {})[unknown.name] = plain
        for index, values in by_mechanism.items():
            mechanisms[index] = mechanisms[index].with_values(values)
        count = len(self.base)
        return replace(self, base=tuple(mechanisms[:count]), found=tuple(mechanisms[count:]))
