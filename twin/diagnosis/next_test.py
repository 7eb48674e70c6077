"""The next experiment: which test would separate two explanations that tie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.explanation import Explanation
from twin.diagnosis.measured import Measured
from twin.diagnosis.predict import placed, predictors
from twin.diagnosis.problem import Problem
from twin.diagnosis.result import NextExperiment
from twin.diagnosis.search import Found
from twin.diagnosis.verdict import TIE
from twin.laboratory.hammer import Hammer
from twin.laboratory.random_shaking import RandomShaking
from twin.model_files import shipped_names

Array = NDArray[np.float64]

DURATION_S = 30.0
"""Length of a test [s], as virtual tests have it by default."""

BAND_HZ = RandomShaking.band_hz
"""Band of random shaking [Hz], as virtual tests have it by default."""

LEVELS = (0.3, 1.0, 3.0)
"""Forces that are tried, as shares of the training recordings'."""

ADDED = 0.2
"""Mass that may be bolted on, as a share of all bodies' masses."""

PULSE_S = Hammer.width_s
"""Contact of a hammer [s], as virtual tests have it by default."""

MOST_TOLD = 100.0
"""Squared difference in noise levels that one sample may count: beyond, a model is wrong anyway."""


@dataclass(frozen=True)
class Option:
    """A test that could be done.

    Attributes:
        kind: "random" (shaker) or "hammer".
        actuator: where.
        level: RMS force [N] of a shaker, peak [N] of a hammer.
        added_mass: body -> mass bolted on [kg].
    """

    kind: str
    actuator: str
    level: float
    added_mass: Mapping[str, float] = field(default_factory=dict)

    def command(self, model: str, rate_hz: float) -> str:
        """Return the command of ``twin test`` that does it."""
        masses = "".join(f" --added-mass {p}={kg:.3g}" for p, kg in self.added_mass.items())
        common = f"--rate {rate_hz:g} --duration {DURATION_S:g}{masses} --out next_test"
        at = self.actuator.removeprefix("force_")
        if self.kind == "hammer":
            return (
                f"twin test hammer --model {model} --at {at} --peak {self.level:.3g} "
                f"--width {PULSE_S:g} {common}"
            )
        return (
            f"twin test shaker --model {model} --at {at} --kind random "
            f"--band {BAND_HZ[0]:g} {BAND_HZ[1]:g} --level {self.level:.3g} {common}"
        )

    def in_words(self) -> str:
        """Return the test in a few words."""
        unit, kind = ("N peak", "hammer") if self.kind == "hammer" else ("N RMS", "shaker")
        masses = "".join(f", {kg:.3g} kg added to {p}" for p, kg in self.added_mass.items())
        return f"{kind} at {self.actuator}, {self.level:.3g} {unit}{masses}"


def next_test(found: Found, model: str, seed: int = 0) -> NextExperiment | None:
    """Return the test that separates the best explanation from its nearest rival, if any is near.

    Both are simulated in every test; half the squared difference of their outputs over the noise is
    the evidence to expect for whichever is true, if nothing else were unknown.

    Args:
        found: the explanations.
        model: for the command, a file or a shipped model's name.
        seed: of the random forces.
    """
    rivals = [e for e in found.others if e.log_odds - found.best.log_odds > np.log(TIE)]
    rivals = [e for e in rivals if set(e.labels) != set(found.best.labels)]
    if not rivals:
        return None
    first, second = found.best, rivals[0]
    problem = first.hypothesis.problem
    scored = []
    for option in _options(problem):
        apart = _apart(problem, first, second, option, seed)
        if np.isfinite(apart):
            scored.append((apart, option))
    if not scored:
        return None
    scored.sort(key=lambda pair: -pair[0])
    gain, best = scored[0]
    names = _called(first, second), _called(second, first)
    return NextExperiment(
        names,
        best.command(_short(model), problem.sampling_hz),
        f"{best.in_words()}: there {names[0]} and {names[1]} predict different motions",
        gain,
        tuple((o.in_words(), g) for g, o in scored[:8]),
    )


def _apart(
    problem: Problem, first: Explanation, second: Explanation, option: Option, seed: int
) -> float:
    """Return the evidence that a test is expected to give for whichever is true [nat]."""
    test = _trial(problem, option, seed)
    alone = replace(problem, recordings=(test,), scale=problem.scale[:1])
    outputs = []
    for explanation in (first, second):
        hypothesis, z = placed(explanation.hypothesis, explanation.fit.z, alone)
        try:
            outputs.append(predictors(hypothesis, z)[0].from_rest())
        except np.linalg.LinAlgError:
            return float("nan")
    noise = np.maximum(test.output_noise, 1e-12)
    apart = ((outputs[0] - outputs[1]) / noise) ** 2
    if not np.all(np.isfinite(apart)):
        return float("nan")
    return 0.5 * float(np.sum(np.minimum(apart, MOST_TOLD)))


def _called(one: Explanation, other: Explanation) -> str:
    """Return what one explanation has that the other has not."""
    own = [f"{name} at {place}" for name, place in one.labels if (name, place) not in other.labels]
    return " and ".join(own) or "nothing else"


def _short(source: str) -> str:
    """Return the name of a shipped model, or the file as it is."""
    path = Path(source)
    return path.stem if path.stem in shipped_names() else source


def _options(problem: Problem) -> list[Option]:
    used = [r.u[:, i] for r in problem.recordings for i in range(r.u.shape[1])]
    moving = [u for u in used if np.any(u)]
    rms = float(np.median([np.sqrt(np.mean(u**2)) for u in moving]))
    peak = float(np.max([np.max(np.abs(u)) for u in moving]))
    forces = [n for n in problem.model.inputs if not n.startswith("acc_ground")]
    heaviest = sorted(problem.model.bodies, key=lambda b: -problem.model.bodies[b].mass)[:2]
    extra = round(ADDED * sum(b.mass for b in problem.model.bodies.values()), 2)
    out = []
    for name in forces:
        for level in LEVELS:
            out.append(Option("random", name, level * rms))
            out.append(Option("hammer", name, level * peak))
        out += [Option("random", name, rms, {body: extra}) for body in heaviest]
    return out


def _trial(problem: Problem, option: Option, seed: int) -> Measured:
    """Return the test as a recording that nobody has made yet."""
    rate = problem.sampling_hz
    samples = round(DURATION_S * rate)
    u = np.zeros((samples, len(problem.model.inputs)))
    column = problem.model.inputs.index(option.actuator)
    if option.kind == "hammer":
        width, begin = max(2, round(PULSE_S * rate)), round(0.5 * rate)
        u[begin : begin + width, column] = option.level * np.hanning(width + 2)[1:-1]
    else:
        noise = np.random.default_rng(seed).standard_normal(samples)
        high = min(BAND_HZ[1], 0.4 * rate)
        sos = signal.butter(4, (BAND_HZ[0], high), "bandpass", fs=rate, output="sos")
        shaped = signal.sosfilt(sos, noise)
        u[:, column] = option.level * shaped / np.sqrt(np.mean(shaped**2))
    levels = np.median([r.output_noise for r in problem.recordings], axis=0)
    still = np.zeros((samples, len(problem.model.outputs)))
    return Measured(option.in_words(), u, still, np.zeros(u.shape[1]), levels, option.added_mass)
