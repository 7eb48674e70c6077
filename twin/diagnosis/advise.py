"""The next experiment: which test would separate two explanations that tie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import Fit
from twin.diagnosis.predict import from_rest
from twin.diagnosis.result import NextExperiment
from twin.diagnosis.trials import Trial

Array = NDArray[np.float64]

DURATION_S = 30.0
BAND_HZ = (0.5, 12.0)
LEVELS = (0.3, 1.0, 3.0)
"""RMS forces that are tried, as shares of the training recordings'."""

ADDED = 0.2
"""Mass that may be bolted on, as a share of all floors' masses."""

PULSE_S = 0.008
"""Contact of a hammer [s]."""


@dataclass(frozen=True)
class Option:
    """A test that could be done.

    Attributes:
        kind: "shaker" or "hammer".
        floor: where, from 1.
        level: RMS force [N] of a shaker, peak [N] of a hammer.
        added_mass: place -> mass bolted on [kg].
    """

    kind: str
    floor: int
    level: float
    added_mass: Mapping[str, float] = field(default_factory=dict)

    def command(self, model: str, rate_hz: float) -> str:
        """Return the command of ``twin test`` that does it."""
        masses = "".join(f" --added-mass {p}={kg:.3g}" for p, kg in self.added_mass.items())
        common = f"--rate {rate_hz:g} --duration {DURATION_S:g}{masses} --out next_test"
        if self.kind == "hammer":
            return (
                f"twin test hammer --model {model} --floor {self.floor} --peak {self.level:.3g} "
                f"--width {PULSE_S:g} {common}"
            )
        return (
            f"twin test shaker --model {model} --at floor{self.floor} --kind random "
            f"--band {BAND_HZ[0]:g} {BAND_HZ[1]:g} --level {self.level:.3g} {common}"
        )

    def in_words(self) -> str:
        """Return the test in a few words."""
        unit = "N peak" if self.kind == "hammer" else "N RMS"
        masses = "".join(f", {kg:.3g} kg added to {p}" for p, kg in self.added_mass.items())
        return f"{self.kind} on floor{self.floor}, {self.level:.3g} {unit}{masses}"


def next_experiment(
    bench: Bench, first: Fit, second: Fit, model: str, seed: int = 0
) -> NextExperiment | None:
    """Return the test whose outcome the two explanations foresee most differently.

    Both are simulated in every test; half the squared difference of their outputs over the noise is
    the evidence to expect for whichever is true, if nothing else were unknown.

    Args:
        bench: the training recordings, for levels and noise.
        first: the best explanation.
        second: the one that ties with it.
        model: for the command, a file or a shipped model's name.
        seed: of the random forces.
    """
    scored = []
    for option in _options(bench):
        trial = _trial(bench, option, seed)
        alone = replace(bench, trials=(trial,))
        try:
            one, two = (from_rest(alone, f.hypothesis, f.slack)[0] for f in (first, second))
        except np.linalg.LinAlgError:
            continue
        noise = np.maximum(trial.output_noise, 1e-12)
        if np.all(np.isfinite(one)) and np.all(np.isfinite(two)):
            apart = float(np.sum(np.minimum(((one - two) / noise) ** 2, 100.0)))
            scored.append((0.5 * apart, option))
    if not scored:
        return None
    scored.sort(key=lambda pair: -pair[0])
    gain, best = scored[0]
    names = _called(first, second), _called(second, first)
    return NextExperiment(
        (names[0], names[1]),
        best.command(model, 1 / bench.step_s),
        f"{best.in_words()}: there {names[0]} and {names[1]} foresee different motions",
        gain,
        tuple((o.in_words(), g) for g, o in scored[:8]),
    )


def _called(one: Fit, other: Fit) -> str:
    """Return what one explanation has that the other has not."""
    at = instead(other, one)
    name, place = one.hypothesis.labels[-1 if at is None else at]
    return f"{name} at {place}"


def instead(best: Fit, other: Fit) -> int | None:
    """Return the index of the mechanism that ``other`` has and ``best`` has not."""
    labels = other.hypothesis.labels
    return next((i for i, x in enumerate(labels) if x not in best.hypothesis.labels), None)


def _options(bench: Bench) -> list[Option]:
    floors = [c for c in bench.model.coordinates if c.startswith("floor")]
    masses = np.diag(bench.model.M)[[bench.model.coordinates.index(c) for c in floors]]
    forces = [float(np.sqrt(np.mean(t.u**2))) for t in bench.trials]
    peaks = [float(np.max(np.abs(t.u))) for t in bench.trials]
    rms, peak = float(np.median(forces)), float(np.max(peaks))
    extra = round(ADDED * float(np.sum(masses)), 2)
    out = []
    for number in range(1, len(floors) + 1):
        for level in LEVELS:
            out.append(Option("shaker", number, level * rms))
            out.append(Option("hammer", number, level * peak))
        out.append(Option("shaker", number, rms, {floors[-1]: extra}))
        if len(floors) > 1:
            out.append(Option("shaker", number, rms, {floors[0]: extra}))
    return out


def _trial(bench: Bench, option: Option, seed: int) -> Trial:
    """Return the test as a recording without outputs."""
    rate = 1 / bench.step_s
    samples = round(DURATION_S * rate)
    floors = [c for c in bench.model.coordinates if c.startswith("floor")]
    inputs = tuple(f"force_{c}" for c in floors)
    u = np.zeros((samples, len(inputs)))
    if option.kind == "hammer":
        width = max(2, round(PULSE_S * rate))
        begin = round(0.5 * rate)
        u[begin : begin + width, option.floor - 1] = option.level * np.hanning(width + 2)[1:-1]
    else:
        noise = np.random.default_rng(seed).standard_normal(samples)
        high = min(BAND_HZ[1], 0.4 * rate)
        sos = signal.butter(4, (BAND_HZ[0], high), "bandpass", fs=rate, output="sos")
        shaped = signal.sosfilt(sos, noise)
        u[:, option.floor - 1] = option.level * shaped / np.sqrt(np.mean(shaped**2))
    outputs = bench.trials[0].outputs
    return Trial(
        option.in_words(),
        rate,
        inputs,
        outputs,
        u,
        np.ones((samples, len(outputs))),
        np.zeros(len(inputs)),
        np.median([t.output_noise for t in bench.trials], axis=0),
        dict(option.added_mass),
    )
