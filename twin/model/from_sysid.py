"""A twin and its recordings from what ``mujoco.sysid`` works on: its model and its time series.

sysid fits the parameters it is given. When it has converged and the residual is still no noise, the
model lacks something; with the same data in hand a diagnosis says what.

Nothing of sysid is imported: what has its attributes is taken for one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.errors import ModelError, RecordingError, available
from twin.formats.time_axis import uniform
from twin.model.twin import Twin
from twin.recording import Recording
from twin.sensor_kinds import channel_kinds

Array = NDArray[np.float64]

CONTROL, SENSOR = "MjCtrl", "MjSensor"
JOINT = {
    "MjStateQPos": ("_qpos", mujoco.mjtSensor.mjSENS_JOINTPOS),
    "MjStateQVel": ("_qvel", mujoco.mjtSensor.mjSENS_JOINTVEL),
}
"""States that sysid observes: how their names end, and the sensor that measures the same."""

TOGETHER = 1e-3
"""Share of a step by which the times of controls and sensors may differ."""


def from_sysid(sequences: Any, parameters: Any = None) -> tuple[Twin, tuple[Recording, ...]]:
    """Return the twin and the recordings of ``mujoco.sysid``'s sequences, to be diagnosed.

    Examples:
        >>> from types import SimpleNamespace as Of
        >>> import mujoco, twin
        >>> spec = mujoco.MjSpec.from_string(twin.Twin.load("two_storey_lumped").mjcf)
        >>> t = [0.0, 0.1, 0.2]
        >>> pushed = {"force_floor1_ctrl": (Of(name="MjCtrl"), [0])}
        >>> felt = {"acc_floor2": (Of(name="MjSensor"), [0])}
        >>> frame, (run,) = twin.from_sysid(Of(
        ...     name="frame", spec=spec, sequence_name=["run 1"],
        ...     control=[Of(times=t, data=[[0.0], [8.0], [0.0]], signal_mapping=pushed)],
        ...     sensordata=[Of(times=t, data=[[0.0], [0.1], [0.2]], signal_mapping=felt)]))
        >>> run.inputs, run.outputs, run.sampling_hz
        (('force_floor1',), ('acc_floor2',), 10.0)

    Args:
        sequences: a ``ModelSequences``: ``spec`` (MjSpec) and, one each a recording,
            ``sequence_name``, ``control`` and ``sensordata`` (``TimeSeries``: times (N,) [s], data
            (N, columns), signal_mapping).
        parameters: the ``ParameterDict`` that was found; each one that is not frozen edits the
            model. The model as it is without.

    Returns:
        The twin, with a sensor for each joint whose position or velocity was observed; and the
        recordings, one a sequence, of its actuators' controls and its sensors.

    Raises:
        ModelError: several models, or one that does not compile.
        RecordingError: series that do not belong together, or to the model; the message names the
            sequence.
    """
    if isinstance(sequences, list | tuple):
        if len(sequences) != 1:
            raise ModelError(f"{len(sequences)} sysid models: diagnose one model at a time")
        sequences = sequences[0]
    lacking = [n for n in ("spec", "control", "sensordata") if not hasattr(sequences, n)]
    if lacking:
        raise ModelError(
            f"a {type(sequences).__name__} is no ModelSequences of mujoco.sysid: it has no "
            f"'{lacking[0]}'"
        )
    name = str(getattr(sequences, "name", "sysid model"))
    spec = sequences.spec.copy()
    for parameter in parameters.values() if parameters is not None else ():
        if not parameter.frozen:
            parameter.apply_modifier(spec)
    series = list(zip(sequences.control, sequences.sensordata, strict=True))
    for _, sensed in series:
        _add_sensors(spec, sensed.signal_mapping or {})
    try:
        spec.compile()
        twin = Twin(spec.to_xml(), name)
    except ValueError as error:
        raise ModelError(f"{name}: {error}") from None
    titles = list(sequences.sequence_name)
    recordings = [
        _recording(twin, f"{name}, {title}", control, sensed)
        for title, (control, sensed) in zip(titles, series, strict=True)
    ]
    return twin, tuple(recordings)


def _add_sensors(spec: mujoco.MjSpec, mapping: Mapping[str, Any]) -> None:
    """Add a sensor of each joint whose state is observed, under the observation's name."""
    there = {sensor.name for sensor in spec.sensors}
    joints = {joint.name for joint in spec.joints}
    for signal, (kind, indices) in mapping.items():
        ending, sensor = JOINT.get(_kind(kind), ("", None))
        joint = signal.removesuffix(ending)
        if sensor is None or signal in there or joint not in joints or len(indices) != 1:
            continue
        spec.add_sensor(name=signal, type=sensor, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=joint)


def _recording(twin: Twin, source: str, control: Any, sensed: Any) -> Recording:
    """Return one sequence: the controls, which are held between samples, and what was sensed."""
    model = twin.compile()
    kinds = channel_kinds(model)
    time, times = (np.asarray(one.times, float).ravel() for one in (control, sensed))
    if len(time) != len(times) or len(time) < 2:
        raise RecordingError(
            f"{source}: {len(time)} controls and {len(times)} sensor samples; cut both to the same "
            "times, two at least"
        )
    axis = uniform(times, lambda sample: f"{source}: sample {sample + 1}")
    apart = np.abs(time - times).max() * axis.sampling_hz
    if not apart < TOGETHER:
        raise RecordingError(
            f"{source}: controls and sensors are {apart:.3g} steps apart; resample them together"
        )
    columns: dict[str, Array] = {}
    left = []
    for one, wanted in ((control, CONTROL), (sensed, SENSOR)):
        for name, kind, data in _signals(model, one, wanted, source):
            if kinds.get(name) in (None, "other"):
                if kind in (CONTROL, SENSOR) and name not in kinds:
                    there = available([n for n in kinds if "." not in n])
                    raise RecordingError(
                        f"{source}: the model has no sensor or actuator '{name}'; there are {there}"
                    )
                left.append(name)
                continue
            columns[name] = data
    notes = [f"left out, as it is no force or motion: {', '.join(left)}"] if left else []
    notes.append("the controls are held between samples")
    return Recording.build(
        axis.sampling_hz, columns, source, axis.start_s, tuple(notes), kinds=kinds
    )


def _signals(
    model: mujoco.MjModel, series: Any, wanted: str, source: str
) -> Iterator[tuple[str, str, Array]]:
    """Return the name, the kind and the samples of each column; a vector's are NAME.x, .y, .z."""
    data = np.asarray(series.data, float)
    data = data[:, None] if data.ndim == 1 else data
    mapping = series.signal_mapping or _all(model, wanted)
    for signal, (which, indices) in mapping.items():
        kind = _kind(which)
        name = signal.removesuffix("_ctrl") if kind == CONTROL else signal
        indices = np.atleast_1d(indices)
        if indices.size and indices.max() >= data.shape[1]:
            raise RecordingError(
                f"{source}: '{signal}' is column {indices.max() + 1} of {data.shape[1]}"
            )
        if len(indices) == 1:
            yield name, kind, data[:, indices[0]]
        elif len(indices) == 3:
            yield from (
                (f"{name}.{axis}", kind, data[:, i]) for axis, i in zip("xyz", indices, strict=True)
            )
        else:
            yield name, "", data[:, indices[0]]


def _all(model: mujoco.MjModel, wanted: str) -> dict[str, tuple[str, Array]]:
    """Return all sensors or all actuators in the model's order, as sysid does without a mapping."""
    if wanted == CONTROL:
        return {model.actuator(i).name: (CONTROL, np.array([i])) for i in range(model.nu)}
    return {
        model.sensor(i).name: (
            SENSOR, model.sensor_adr[i] + np.arange(model.sensor_dim[i])
        )
        for i in range(model.nsensor)
    }  # fmt: skip


def _kind(which: Any) -> str:
    return str(getattr(which, "name", which))
