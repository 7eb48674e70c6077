"""From a rig to a controller that has been tried: identify, design, close the loop, compare."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from twin.control.absorber import SHAKE_TABLE, DesignModel, with_pendulum
from twin.control.bare import without_pendulum
from twin.control.closed_loop import Schedule, run
from twin.control.controller import Controller
from twin.control.excitation import PRINTED_FREQUENCIES, WorstCase
from twin.control.loop import stability_margin
from twin.control.lqg import lqg
from twin.control.outcome import Outcome, joined
from twin.control.plant import Plant, frame_frequencies
from twin.control.weights import Covariances, Weights
from twin.errors import ControlError
from twin.frame import Pendulum
from twin.identification.identify import identify
from twin.identification.result import Identification
from twin.instruments import Instrument
from twin.laboratory import Earthquake, Experiment, Hammer
from twin.laboratory import run as carry_out
from twin.recording import Recording

FORCE_AMPLITUDE = 0.1
"""F_0,1 and F_0,2 of (57) [N]."""

NOISE_STD = 0.01
"""Of w(t) in (57), which the paper does not print: a tenth of the harmonics' amplitude [N]."""

TABLE_AMPLITUDE = 0.04
"""The same for a shake table [m/s^2]: about the same swing of the pendulum."""


@dataclass(frozen=True)
class Settings:
    """Everything about a design but the model.

    Attributes:
        weights: of the regulator.
        covariances: of the estimator.
        rate_hz: of the controller [Hz].
        extra_delay: samples the design reckons with beyond the computation's.
        torque_limit: [N m].
        ramp_s: soft start [s].
    """

    weights: Weights = field(default_factory=Weights)
    covariances: Covariances = field(default_factory=Covariances)
    rate_hz: float = 32.0
    extra_delay: float = 0.5
    torque_limit: float = 0.5
    ramp_s: float = 10.0

    def design(self, model: DesignModel, delay: int) -> Controller:
        """Return the controller for a model and the computation's delay [samples]."""
        return lqg(
            model,
            self.rate_hz,
            self.weights,
            self.covariances,
            delay + self.extra_delay,
            torque_limit=self.torque_limit,
            ramp_s=self.ramp_s,
        )

    def as_json(self) -> dict[str, Any]:
        """Return plain types."""
        return asdict(self)

    @classmethod
    def from_json(cls, found: Mapping[str, Any]) -> Settings:
        """Return the settings that ``as_json`` gave.

        Raises:
            ControlError: something lacks, or is no number.
        """
        try:
            weights = Weights(**found["weights"])
            covariances = Covariances(**found["covariances"])
            rest = {key: value for key, value in found.items() if not isinstance(value, dict)}
            return cls(weights, covariances, **rest)
        except (KeyError, TypeError) as error:
            raise ControlError(f"these are no settings of a controller: {error}") from None


def hammer_tests(plant: Plant, noise: float = 0.01, seed: int = 0) -> tuple[Recording, ...]:
    """Hit the frame, its pendulum taken off, as the model of the plant's excitation needs it.

    The first floor of the clamped frame, eqs. (50)-(53); for a shaker on the ground the released
    ground, so that its mass and suspension are identified, too.

    Args:
        plant: what will be controlled.
        noise: of every channel, share of its RMS.
        seed: of the noise.
    """
    at = "ground" if plant.known_input == "force_ground" else "floor1"
    instruments = {kind: Instrument(noise_fraction=noise) for kind in ("acc", "force")}
    experiment = Experiment(Hammer(), at, instruments=instruments)
    return (carry_out(experiment, without_pendulum(plant.twin), seed),)


def identify_frame(recordings: Sequence[Recording]) -> Identification:
    """Identify the frame; where the data suggest other orders than M, K and R can have, insist.

    Raises:
        TwinError: the recordings do not allow it.
    """
    found = identify(recordings)
    floors = sum(name.startswith("acc_") for name in found.outputs)
    if found.second_order is None and found.order != 2 * floors:
        return identify(recordings, order=2 * floors)
    return found


def identified_model(
    identification: Identification, pendulum: Pendulum, known_input: str
) -> DesignModel:
    """Return the design model (54) from an identification of the frame without pendulum.

    Raises:
        ControlError: the recording did not determine M, K and R, or not at the place it takes.
    """
    frame = identification.second_order
    if frame is None:
        why = "; ".join(identification.notes)
        raise ControlError(f"the design model needs M, K and R of the frame: {why}")
    return DesignModel.of(with_pendulum(frame, pendulum), known_input)


def worst_case(plant: Plant, printed: bool = False, noise_std: float = NOISE_STD) -> WorstCase:
    """Return (57) on the plant's own first two natural frequencies, or on the printed ones."""
    own = PRINTED_FREQUENCIES if printed else frame_frequencies(plant.linear().structure)
    table = plant.known_input == SHAKE_TABLE
    amplitude = TABLE_AMPLITUDE if table else FORCE_AMPLITUDE
    noise = noise_std * amplitude / FORCE_AMPLITUDE
    return WorstCase(own, (amplitude,) * len(own), noise, moves_the_ground=table)


def shaken(
    plant: Plant,
    controller: Controller,
    quake: Earthquake,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Outcome:
    """Run an earthquake twice from rest, without control and with; return both as one run."""
    duration = np.ceil(quake.duration_s + quake.delay_s + 8.0)
    ready = replace(controller, ramp_s=0.0)
    off = run(plant, ready, quake, Schedule(duration, duration), seed, progress=progress)
    on = run(plant, ready, quake, Schedule(duration, 0.0), seed, progress=progress)
    return joined(off, on)


def step_time(controller: Controller, steps: int = 4000) -> tuple[float, float]:
    """Return median and 99th percentile of a controller step in Python [us]."""
    running = controller.start()
    running.switch(True)
    y = np.random.default_rng(0).normal(size=(steps, len(controller.measurements)))
    taken = np.empty(steps)
    for k in range(steps):
        begin = time.perf_counter_ns()
        running.step(y[k], 0.1)
        taken[k] = time.perf_counter_ns() - begin
    return float(np.median(taken) / 1e3), float(np.percentile(taken, 99) / 1e3)


def judged(
    outcome: Outcome, controller: Controller, model: DesignModel, delay: int
) -> dict[str, Any]:
    """Return the numbers of the contract for one run.

    Args:
        outcome: the run.
        controller: that ran.
        model: what the margin refers to.
        delay: of the computation [samples].
    """
    median, high = step_time(controller)
    return {
        "reduction": outcome.reduction.as_json(),
        "peak_swing_rad": outcome.peak_swing_rad,
        "peak_torque_nm": outcome.peak_torque_nm,
        "stability_margin": stability_margin(controller, model, delay),
        "controller_step_us": {"median": median, "p99": high},
        "notes": list(outcome.notes),
    }
