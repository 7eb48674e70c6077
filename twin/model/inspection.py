"""What a model offers: inputs, sensors, ports, bodies, modes, and what in it is not linear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twin.contract import names_in
from twin.errors import ModelError
from twin.model.assembling import ground_names
from twin.model.contents import nonlinear_elements
from twin.model.linear import LinearModel
from twin.model.nonlinear import NonlinearElement
from twin.model.port import distinct
from twin.model.rest import Reduced, settle
from twin.model.sensing import channel_columns
from twin.model.twin import Twin
from twin.sensor_kinds import channel_kinds

Array = NDArray[np.float64]

MOVERS = 3
"""Ports named for each mode."""


@dataclass(frozen=True)
class Mode:
    """One natural mode.

    Attributes:
        frequency_hz: undamped natural frequency [Hz]; 0 for a rigid-body motion.
        damping_ratio: dimensionless; NaN for a rigid-body motion.
        movers: the ports that move most in it, the largest motion first -> motion over the largest
            (m and rad times the model's size alike).
    """

    frequency_hz: float
    damping_ratio: float
    movers: Mapping[str, float]


@dataclass(frozen=True)
class ModelInspection:
    """What is in a model.

    Attributes:
        source: its name.
        inputs: actuator, and names of a shaken ground's acceleration -> kind of channel.
        left_aside: actuator -> why its value cannot be an input.
        outputs: channel of a sensor -> kind of channel.
        linear: the linear equations about its rest, with these inputs and no outputs.
        modes: in the order of frequency.
        nonlinear: elements that are not linear.
    """

    source: str
    inputs: Mapping[str, str]
    left_aside: Mapping[str, str]
    outputs: Mapping[str, str]
    linear: LinearModel
    modes: tuple[Mode, ...]
    nonlinear: tuple[NonlinearElement, ...]

    def as_json(self) -> dict[str, Any]:
        """Return it as plain types."""
        return {
            "model": self.source,
            "inputs": dict(self.inputs),
            "not_inputs": dict(self.left_aside),
            "outputs": dict(self.outputs),
            "ports": [
                {"name": p.name, "kind": p.kind, "unit": p.unit, "element": p.element}
                for p in self.linear.ports.values()
            ],
            "bodies": {name: body.mass for name, body in self.linear.bodies.items()},
            "base": list(self.linear.places("base")),
            "left_out": self.linear.left_out,
            "modes": [
                {
                    "frequency_hz": mode.frequency_hz,
                    "damping_ratio": None if np.isnan(mode.damping_ratio) else mode.damping_ratio,
                    "movers": dict(mode.movers),
                }
                for mode in self.modes
            ],
            "nonlinear": [
                {
                    "element": e.element,
                    "port": e.port,
                    "mechanism": e.mechanism or None,
                    "values": dict(e.values),
                    "words": e.words,
                }
                for e in self.nonlinear
            ],
        }


def inspect(twin: Twin) -> ModelInspection:
    """Return what a model offers.

    Raises:
        ModelError: it has no rest, or nothing in it moves.
    """
    model = twin.compile()
    reduced = Reduced(model)
    settle(reduced)
    kinds = channel_kinds(model)
    bare = twin.linear((), ())
    inputs, left_aside = {}, {}
    for name in names_in(model)["actuator"]:
        try:
            moves = np.any(twin.linear((name,), ()).B)
        except ModelError as error:
            left_aside[name] = str(error)
            continue
        if moves:
            inputs[name] = kinds.get(name, "other")
        else:
            left_aside[name] = "nothing it acts on moves"
    names = ground_names(bare.base)
    # along one axis only the bare name is enough, along several each has its own
    inputs |= dict.fromkeys(names[:1] if len(bare.base) == 1 else names[1:], "acc")
    outputs = {name: kinds.get(name, "other") for name in channel_columns(reduced)}
    linear = twin.linear(tuple(inputs), ())
    extent = float(model.stat.extent) or 1.0
    modes = tuple(_mode(linear, k, extent) for k in range(len(linear.coordinates)))
    return ModelInspection(
        twin.source, inputs, left_aside, outputs, linear, modes, nonlinear_elements(model)
    )


def _mode(model: LinearModel, index: int, extent: float) -> Mode:
    omega = float(np.sqrt(max(model.K[index, index], 0.0)))
    ratio = float(model.R[index, index] / (2 * omega)) if omega > 0 else float("nan")
    names = distinct(model.ports)
    size = {
        name: abs(float(model.ports[name].row[index]))
        * (extent if model.ports[name].unit == "rad" else 1.0)
        for name in names
    }
    largest = max(size.values(), default=0.0) or 1.0
    order = sorted(size, key=lambda name: -size[name])[:MOVERS]
    return Mode(omega / (2 * np.pi), ratio, {name: size[name] / largest for name in order})
