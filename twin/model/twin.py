"""A twin: an MJCF model that is compiled anew for each question, never changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin import compiling, rolling
from twin.contract import check_names, floors_of, names_in
from twin.errors import ModelError, available
from twin.files import write_whole
from twin.frame import Design, to_mjcf
from twin.linearise import Linearisation, linearise
from twin.mechanisms.mechanism import ChannelFault, Mechanism
from twin.mechanisms.replay import in_order
from twin.mechanisms.stiffness_drift import CLOCK
from twin.modal import ModalModel
from twin.model.assembling import linear_model
from twin.model.linear import LinearModel
from twin.model.motion import Motion
from twin.model.shaking import drive_name
from twin.model_files import shipped, shipped_names
from twin.presentable import Presentable
from twin.second_order import SecondOrderModel

Array = NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Twin(Presentable):
    """A structure in MuJoCo: any MJCF model that compiles.

    A chain of storeys (names as in ``twin.contract``) can be described by its floors alone, too.

    Examples:
        >>> frame = Twin.load("two_storey_lumped")
        >>> frame.modes().natural_freq.round(2).tolist()
        [1.95, 6.72]
        >>> frame.linear(("force_floor1",), ("acc_floor2",)).places("drift")
        ('storey1', 'storey2')

    Attributes:
        mjcf: the model as MJCF text.
        source: where it came from (a file's path), used in messages and to find its assets.
        clamped: whether the ground's clamp is fast. A model without a joint ``ground`` always is.
        mechanisms: what the frame has beyond its text; replayed on it at each compile.

    Raises:
        ModelError: the MJCF does not compile.
    """

    mjcf: str
    source: str = "model"
    clamped: bool = True
    mechanisms: tuple[Mechanism, ...] = ()

    def __repr__(self) -> str:
        found = (f"{m.name} at {m.place}" for m in self.mechanisms)
        extra = ["" if self.clamped else "its ground released", *found]
        return f"Twin({', '.join([self.source, *filter(None, extra)])})"

    def __post_init__(self) -> None:
        compiling.as_written(self.mjcf, self.source)

    def _title(self) -> str:
        return f"twin of {Path(self.source).name}"

    def _rows(self) -> Iterator[tuple[str, str]]:
        names = names_in(self.compile())
        for kind in ("body", "joint", "tendon", "actuator", "sensor"):
            if names[kind]:
                yield kind, ", ".join(names[kind])
        for mechanism in self.mechanisms:
            yield "mechanism", f"{mechanism.name} at {mechanism.place}"

    @classmethod
    def load(cls, name: str | Path) -> Twin:
        """Load an MJCF file, or by its name a model that comes with the package.

        Raises:
            ModelError: no such file or model, or one that cannot be used.
        """
        path = Path(name)
        if str(name).removesuffix(".xml") in shipped_names() and not path.is_file():
            path = shipped(str(name))
        return cls(compiling.read(path), str(path))

    @classmethod
    def of(cls, design: Design) -> Twin:
        """Build the model of a design."""
        return cls(to_mjcf(design), "frame design")

    @property
    def floors(self) -> tuple[str, ...]:
        """Names of the floors from the ground up: "floor1", "floor2", ..."""
        return floors_of(self.compile())

    def released(self) -> Twin:
        """Return the twin with its ground's bolts undone: it slides on its suspension.

        Raises:
            ModelError: the model has no joint ``ground``.
        """
        if "ground" not in compiling.joints(self.mjcf, self.source):
            raise ModelError(
                f"{self.source}: the ground cannot be released, there is no joint 'ground'; "
                f"joints are {available(compiling.joints(self.mjcf, self.source))}"
            )
        return replace(self, clamped=False)

    def including(self, *mechanisms: Mechanism) -> Twin:
        """Return the twin with further mechanisms.

        Raises:
            ModelError: the model has no such place or channel; the message lists those it has.
        """
        twin = replace(self, mechanisms=(*self.mechanisms, *mechanisms))
        twin.compile()
        return twin

    def mjcf_of(self) -> str:
        """Return MJCF text with the mechanisms; a comment says what it cannot hold of them."""
        return compiling.exported(self.mjcf, self.source, self.clamped, self.mechanisms)

    def export(self, path: str | Path) -> Path:
        """Write ``mjcf_of`` to a file and return its path."""
        text = self.mjcf_of()
        return write_whole(Path(path), lambda part: part.write_text(text, encoding="utf-8"))

    def compile(self) -> mujoco.MjModel:
        """Return a fresh compiled model, the ground fast or free as ``clamped`` says."""
        return compiling.structure(self.mjcf, self.source, self.clamped, self.mechanisms)

    def linearisation(self) -> Linearisation:
        """Return matrices, modes and mode shapes about the static equilibrium."""
        return _linearised(self)

    def second_order(self) -> SecondOrderModel:
        """Return M, R, K in the coordinates of the floors, ground (if released) and pendulum.

        Displacements are absolute, from the ground's rest position. Exact where the model has no
        further freedoms; a hinge chain's are condensed statically (``Linearisation.second_order``).

        Raises:
            ModelError: the model is no chain of storeys by its names; ``linear`` serves any.
        """
        check_names(compiling.as_written(self.mjcf, self.source), self.source)
        return self.linearisation().second_order()

    def modes(self) -> ModalModel:
        """Return the exact damped modes of all freedoms, their shapes at the places.

        Raises:
            ModelError: a mode does not oscillate: it is overdamped or its stiffness negative.
        """
        try:
            return self.linearisation().modes()
        except ValueError as error:
            raise ModelError(f"{self.source}: {error}") from None

    def linear(
        self, inputs: Sequence[str], outputs: Sequence[str], band_hz: float | None = None
    ) -> LinearModel:
        """Return the exact linear equations of motion about the rest under gravity.

        Args:
            inputs: actuators and "acc_ground" (x, or the only axis), "acc_ground.x", ... .
            outputs: sensors; "NAME.x" is one axis of a vector sensor, its bare name the x axis. A
                sensor of absolute position or velocity reads relative to a ground that is shaken.
            band_hz: highest frequency that matters [Hz]; modes far above are left out, their
                static share kept. None keeps all of a model of at most 40 freedoms.

        Raises:
            ModelError: no rest, or no such input or output; the message lists those there are.
        """
        return _equations(self, tuple(inputs), tuple(outputs), band_hz)

    def simulate(
        self,
        forces: Mapping[str, Array],
        rate_hz: float,
        samples: int,
        ground_acceleration: Array | Mapping[str, Array] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Motion:
        """Simulate from rest at the static equilibrium.

        Args:
            forces: actuator -> values at t = n / rate_hz [N, N m], (samples,); linear in between.
            rate_hz: samples per second.
            samples: how many.
            ground_acceleration: prescribes the motion of the ground along x, or by axis ("x", "y",
                "z") [m/s^2], (samples,); linear in between. It starts at rest, and everything in
                the world but planes moves with it: sensors of absolute position see it.
            progress: called with the fraction that is done.

        Raises:
            ModelError: an unknown actuator, values of a wrong length or not finite, or a motion
                that diverges.
        """
        if not (np.isfinite(rate_hz) and rate_hz > 0):
            raise ModelError(f"{self.source}: the rate must be positive, not {rate_hz}")
        if samples < 1:
            raise ModelError(f"{self.source}: at least one sample is needed, not {samples}")
        axes: dict[str, Array] = {}
        if isinstance(ground_acceleration, Mapping):
            axes |= ground_acceleration
        elif ground_acceleration is not None:
            axes["x"] = ground_acceleration
        model, drives = self.driven(tuple(axes))
        inputs = self._faulty(forces, rate_hz, of_motor=True)
        clocks = [name for name in names_in(model)["actuator"] if name.endswith(CLOCK)]
        inputs |= dict.fromkeys(clocks, np.arange(samples) / rate_hz)
        inputs |= {drives[axis]: values for axis, values in axes.items()}
        table = rolling.input_table(model, inputs, samples, self.source)
        qpos, columns, others = rolling.roll(model, table, rate_hz, self.source, progress)
        return Motion(rate_hz, columns, qpos, model, others)

    def driven(self, axes: Sequence[str]) -> tuple[mujoco.MjModel, dict[str, str]]:
        """Return the model as it is simulated, and by axis the actuator that shakes its ground.

        The value of every input is the activation of its actuator, an integrator.

        Args:
            axes: along which the ground's motion is prescribed.
        """
        text = (self.mjcf, self.source)
        model = compiling.driven(*text, self.clamped, axes, self.mechanisms)
        return model, {axis: drive_name(axis) for axis in axes}

    def recorded(self, columns: Mapping[str, Array], rate_hz: float) -> dict[str, Array]:
        """Return channels as instruments record them that have the mechanisms' faults.

        Args:
            columns: channel -> true samples, (samples,).
            rate_hz: samples per second.
        """
        return self._faulty(columns, rate_hz, of_motor=False)

    def _faulty(
        self, columns: Mapping[str, Array], rate_hz: float, of_motor: bool
    ) -> dict[str, Array]:
        changed = {name: np.asarray(values, float) for name, values in columns.items()}
        faults = [m for m in in_order(self.mechanisms) if isinstance(m, ChannelFault)]
        for fault in faults:
            if fault.of_motor == of_motor and set(fault.channels) <= set(changed):
                changed = fault.distort(changed, rate_hz)
        return changed


def _named(twin: Twin, function: Callable[[], Any]) -> Any:
    try:
        return function()
    except ModelError as error:
        raise ModelError(f"{twin.source}: {error}") from None


@lru_cache(maxsize=64)
def _linearised(twin: Twin) -> Linearisation:
    return cast(Linearisation, _named(twin, lambda: linearise(twin.compile())))


@lru_cache(maxsize=64)
def _equations(
    twin: Twin, inputs: tuple[str, ...], outputs: tuple[str, ...], band_hz: float | None
) -> LinearModel:
    shaken = any(name.startswith("acc_ground") for name in inputs)
    rig = replace(twin, clamped=True) if shaken else twin
    made = _named(twin, lambda: linear_model(rig.compile(), inputs, outputs, band_hz))
    return cast(LinearModel, made)
