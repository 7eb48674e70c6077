"""The innovations likelihood of a model with unknowns, its gradient and its Fisher information.

    log p(y | z) = -1/2 sum_k ( e_k^T S_k^-1 e_k + log det 2 pi S_k )

with the innovations e of a one-step predictor that has the laws inside (Ljung 1999, section 7.4).
The state before the first sample is Gaussian with a wide covariance and so integrated out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from twin.estimation.kalman import Gains, gains, stationary_gains
from twin.estimation.laws import Law, pointers
from twin.estimation.stepping import predict
from twin.estimation.system import Noise, Sampled, System, sampled

Array = NDArray[np.float64]

STEP = 1e-6
"""Step of the differences of matrices and gains, in prior standard deviations: between rounding
(1e-16 / 1e-6) and curvature (1e-6)."""


@dataclass(frozen=True)
class Trial:
    """One recording as the likelihood sees it.

    Attributes:
        u: inputs at the samples, (samples, r).
        between: inputs as they drive the states in between, (samples, r).
        y: outputs, (samples, m); NaN where there is none.
        step_s: sampling interval [s].
    """

    u: Array
    between: Array
    y: Array
    step_s: float


@dataclass(frozen=True)
class Assembly:
    """A model at certain values of its unknowns.

    Attributes:
        systems: the distinct linear systems (recordings with added masses have their own).
        which: index into ``systems`` for each trial.
        noises: noise levels of each trial.
        laws: the laws at the systems' ports, in order.
        numbers: of the laws, (l, MOST_NUMBERS).
        scales: of force, displacement and rate at each law's port, (l, 3).
        steps: parts of a sample in which the laws are stepped.
        held: inputs that are held from sample to sample, (r,).
        trials: the recordings, in whose samples a fault may have been taken back.
    """

    systems: tuple[System, ...]
    which: tuple[int, ...]
    noises: tuple[Noise, ...]
    laws: tuple[Law, ...]
    numbers: Array
    scales: Array
    steps: int
    held: NDArray[np.bool_]
    trials: tuple[Trial, ...]


@dataclass(frozen=True)
class Unknown:
    """A number that is estimated; its prior is normal, of its logarithm where it is positive.

    Attributes:
        name: what it is.
        mean, deviation: of the prior (of the logarithm where ``log``).
        log: whether it is estimated through its logarithm.
        role: what it changes: the system, the noise levels alone, the laws' numbers alone, or the
            samples themselves (a fault that is taken back in them).
        trial: the one recording that it belongs to, or None.
    """

    name: str
    mean: float
    deviation: float
    log: bool = False
    role: Literal["system", "noise", "law", "samples"] = "system"
    trial: int | None = None

    def value(self, z: float) -> float:
        """Return the value that lies z prior deviations above the prior's mean."""
        linear = self.mean + self.deviation * z
        return float(np.exp(linear)) if self.log else float(linear)


class Model(Protocol):
    """What a likelihood needs of a model."""

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """What is estimated."""

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The recordings."""

    def assemble(self, z: Array) -> Assembly:
        """Return the model at values z [prior deviations from the prior's mean], (p,)."""

    def blur(self, trial: int, forces: Array, system: System) -> Array | None:
        """Return variances by which outputs are uncertain because of the laws, (samples, m)."""


@dataclass(frozen=True)
class Run:
    """The predictor's pass over one recording.

    Attributes:
        e: innovations, (samples, m); zero where nothing was measured.
        de: their derivatives, (samples, m, p); p = 0 without.
        x: states before each sample, (samples, n).
        z: memories of the laws, (samples, l).
        f: forces of the laws at the samples, (samples, l).
        gains: of the predictor.
        sampled: the sampled system.
    """

    e: Array
    de: Array
    x: Array
    z: Array
    f: Array
    gains: Gains
    sampled: Sampled


@dataclass(frozen=True)
class Value:
    """Log likelihood, its gradient (p,) and Fisher information (p, p) in prior deviations."""

    log_likelihood: float
    gradient: Array
    information: Array
    runs: tuple[Run, ...]
    trials: tuple[Trial, ...]


def _each(function: Callable[[int], Run], count: int) -> list[Run]:
    if count == 1:
        return [function(0)]
    with ThreadPoolExecutor(max_workers=2) as pool:
        return list(pool.map(function, range(count)))


def _difference(moved: Array, here: Array) -> Array:
    return (moved - here) / STEP


class _Sensitivity:
    """Derivatives of the sampled systems, gains and numbers with respect to the unknowns."""

    def __init__(self, model: Model, z: Array, here: Assembly, plants: Sequence[Sampled]) -> None:
        self.model, self.here, self.plants = model, here, plants
        self.moved: list[Assembly] = []
        self.moved_plants: list[Sequence[Sampled]] = []
        for index, unknown in enumerate(model.unknowns):
            step = z.copy()
            step[index] += STEP
            moved = model.assemble(step)
            self.moved.append(moved)
            self.moved_plants.append(_plants(moved, model) if unknown.role == "system" else plants)

    def columns(self, trial: int) -> list[int]:
        """Return the unknowns that change this trial."""
        return [i for i, u in enumerate(self.model.unknowns) if u.trial is None or u.trial == trial]

    def of(self, trial: int) -> tuple[dict[str, Array], Array, list[int]]:
        """Return derivatives for the stepping loop, those of S (m, m, p), and the unknowns."""
        here, which = self.here, self.here.which[trial]
        plant = self.plants[which]
        base = stationary_gains(plant, here.noises[trial])
        columns = self.columns(trial)
        names = ("A", "B0", "B1", "E", "W")
        outputs = ("C", "D", "F")
        out: dict[str, list[Array]] = {n: [] for n in (*names, *outputs, "numbers", "Kf", "Ku")}
        dS = []
        for i in columns:
            moved, other = self.moved[i], self.moved_plants[i][which]
            for name in names:
                out[name].append(_difference(getattr(other, name), getattr(plant, name)))
            for name in outputs:
                out[name].append(
                    _difference(getattr(other.system, name), getattr(plant.system, name))
                )
            out["numbers"].append(_difference(moved.numbers, here.numbers))
            if self.model.unknowns[i].role in ("law", "samples"):
                out["Kf"].append(np.zeros_like(base.state[0]))
                out["Ku"].append(np.zeros_like(base.held[0]))
                dS.append(np.zeros_like(base.innovation[0]))
                continue
            near = stationary_gains(other, moved.noises[trial])
            out["Kf"].append(_difference(near.state[0], base.state[0]))
            out["Ku"].append(_difference(near.held[0], base.held[0]))
            dS.append(_difference(near.innovation[0], base.innovation[0]))
        stacked = {n: np.ascontiguousarray(np.stack(v, axis=-1)) for n, v in out.items()}
        return stacked, np.stack(dS, axis=-1), columns


def _plants(assembly: Assembly, model: Model) -> list[Sampled]:
    step_s = model.trials[0].step_s
    return [sampled(s, step_s, assembly.steps, assembly.held) for s in assembly.systems]


def _nothing(plant: Sampled, laws: int, held: int, gain: Gains, most: int) -> dict[str, Array]:
    """Return derivatives with respect to no unknown at all."""
    shapes = {n: getattr(plant, n).shape for n in ("A", "B0", "B1", "E", "W")}
    shapes |= {n: getattr(plant.system, n).shape for n in ("C", "D", "F")}
    shapes |= {"numbers": (laws, most), "Kf": gain.state.shape[1:], "Ku": gain.held.shape[1:]}
    return {name: np.zeros((*shape, 0)) for name, shape in shapes.items()}


def run(
    assembly: Assembly,
    trial: Trial,
    plant: Sampled,
    gain: Gains,
    slopes: dict[str, Array] | None = None,
    x0: Array | None = None,
    z0: Array | None = None,
    begin_s: float = 0.0,
    dx0: Array | None = None,
) -> Run:
    """Step the predictor over one recording.

    Args:
        assembly: for laws and numbers.
        trial: the recording.
        plant: its sampled system.
        gain: gains of the predictor.
        slopes: derivatives with respect to p unknowns, as ``predict`` takes them, or None.
        x0: state before the first sample, (n,), or rest.
        z0: memories of the laws before it, (l,), or zero.
        begin_s: time of the first sample [s].
        dx0: derivatives of the first state, (n, p).
    """
    laws = len(assembly.laws)
    forces, flows = pointers(assembly.laws)
    system = plant.system
    n, (samples, m) = len(plant.A), trial.y.shape
    d = slopes or _nothing(plant, laws, system.W.shape[1], gain, assembly.numbers.shape[1])
    p = d["A"].shape[-1]
    # gains settle within some samples: their derivatives are those of the stationary ones
    e, de = np.empty((samples, m)), np.empty((samples, m, p))
    x, z, f = np.empty((samples, n)), np.empty((samples, laws)), np.empty((samples, laws))
    c = np.ascontiguousarray
    predict(
        forces, flows, c(plant.A), c(plant.B0), c(plant.B1), c(plant.E), c(plant.W), c(system.C),
        c(system.D), c(system.F), c(system.drift), c(system.rate), c(assembly.numbers.copy()),
        c(gain.state), c(gain.held), c(trial.u), c(trial.between), c(trial.y),
        np.zeros(n) if x0 is None else c(x0, dtype=float),
        np.zeros(laws) if z0 is None else c(z0, dtype=float),
        begin_s, plant.steps, trial.step_s, (~assembly.held).astype(float), c(assembly.scales),
        d["A"], d["B0"], d["B1"], d["E"], d["W"], d["C"], d["D"], d["F"], d["numbers"],
        d["Kf"], d["Ku"], np.zeros((n, p)) if dx0 is None else c(dx0), e, de, x, z, f,
    )  # fmt: skip
    return Run(e, de, x, z, f, gain, plant)


def open_loop(gain: Gains) -> Gains:
    """Return gains that listen to nothing: the predictor is then a simulation."""
    return Gains(0 * gain.state[-1:], 0 * gain.held[-1:], gain.innovation, gain.predicted)


def evaluate(model: Model, z: Array, derivatives: bool = True) -> Value:
    """Return the log likelihood at values z, (p,), and its derivatives unless they are not asked.

    Raises:
        ValueError: no stationary filter, or a model that cannot be.
    """
    here = model.assemble(z)
    plants = _plants(here, model)
    sensitivity = _Sensitivity(model, z, here, plants) if derivatives else None
    p = len(model.unknowns)
    log_likelihood, gradient, information = 0.0, np.zeros(p), np.zeros((p, p))

    slopes_of = [sensitivity.of(t) if sensitivity else None for t in range(len(model.trials))]

    def one(index: int) -> Run:
        plant = plants[here.which[index]]
        gain = gains(plant, here.noises[index])
        slopes = slopes_of[index]
        result = run(here, here.trials[index], plant, gain, slopes[0] if slopes else None)
        if sensitivity and slopes:
            for place, i in enumerate(slopes[2]):
                if model.unknowns[i].role == "samples":
                    moved = run(here, sensitivity.moved[i].trials[index], plant, gain)
                    result.de[:, :, place] = _difference(moved.e, result.e)
        return result

    runs = _each(one, len(model.trials))
    for index, result in enumerate(runs):
        trial = here.trials[index]
        blur = model.blur(index, result.f, result.sampled.system) if here.laws else None
        part = gaussian(result, trial, blur)
        log_likelihood += part.value
        slopes = slopes_of[index]
        if slopes is None:
            continue
        _, dS, columns = slopes
        white = part.whitened(result.de)  # (samples m, p)
        g = -white.T @ part.white.ravel() - 0.5 * np.einsum("ij,ijp->p", part.balance, dS)
        half = np.einsum("ij,jkp->ikp", np.linalg.inv(result.gains.innovation[-1]), dS)
        H = white.T @ white
        H += 0.5 * len(trial.y) * np.einsum("ijp,jiq->pq", half, half)
        gradient[columns] += g
        information[np.ix_(columns, columns)] += H
    return Value(log_likelihood, gradient, information, tuple(runs), here.trials)


@dataclass(frozen=True)
class Part:
    """One recording's share: log density, whitened innovations, sum of S^-1 - S^-1 e e^T S^-1."""

    value: float
    white: Array
    balance: Array
    roots: Array
    which: NDArray[np.intp]

    def whitened(self, de: Array) -> Array:
        """Return L^-1 de for every sample as rows, (samples m, p)."""
        samples, m, p = de.shape
        out = np.empty_like(de)
        last = len(self.roots) - 1
        if len(self.roots) == samples and last > 0 and self.which[-1] == samples - 1:
            np.matmul(self.roots, de, out=out)
        else:
            head = int(np.searchsorted(self.which, last))
            out[:head] = np.matmul(self.roots[self.which[:head]], de[:head])
            tail = de[head:]
            out[head:] = np.einsum("ij,kjp->kip", self.roots[last], tail, optimize=True)
        return out.reshape(samples * m, p)


def gaussian(result: Run, trial: Trial, blur: Array | None) -> Part:
    """Return the log density of one recording's innovations and what its derivatives need.

    Args:
        result: the predictor's pass.
        trial: the recording; what is missing in it does not count.
        blur: further variances of the outputs, (samples, m), or None.
    """
    samples, m = result.e.shape
    S = result.gains.innovation
    missing = np.isnan(trial.y)
    if blur is None and not missing.any():
        which = np.minimum(np.arange(samples), len(S) - 1)
    else:
        which = np.arange(samples)
        S = S[np.minimum(which, len(S) - 1)].copy()
        if blur is not None:
            S[:, range(m), range(m)] += blur
        if missing.any():
            both = missing[:, :, None] | missing[:, None, :]
            S[both] = 0.0
            S[:, range(m), range(m)] += missing
    root = np.linalg.cholesky(S)
    roots = np.linalg.inv(root)
    logs = 2 * np.sum(np.log(np.einsum("kii->ki", root)), axis=1)
    white = np.einsum("kij,kj->ki", roots[which], result.e)
    counted = samples * m - int(missing.sum())
    value = -0.5 * (np.sum(white**2) + np.sum(logs[which]) + counted * np.log(2 * np.pi))
    v = np.einsum("kji,kj->ki", roots[which], white)
    inverse = np.einsum("kji,kjl->kil", roots, roots)
    counts = np.bincount(which, minlength=len(S)).astype(float)
    balance = np.einsum("k,kij->ij", counts, inverse) - v.T @ v
    return Part(float(value), white, balance, roots, which)
