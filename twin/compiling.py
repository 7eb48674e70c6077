"""Compile an MJCF text with the edits that a simulation needs; the text itself never changes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import mujoco

from twin.contract import names_in
from twin.errors import ModelError, available
from twin.mechanisms.mechanism import Mechanism
from twin.mechanisms.replay import in_words, replay
from twin.model.shaking import shaken
from twin.model_files import shipped_names

SIZE_LIMIT = 64 * 2**20
"""Largest MJCF file that is read [bytes]."""


def read(path: Path) -> str:
    """Return the text of an MJCF file, its includes resolved.

    Raises:
        ModelError: there is no such file, or it is no text.
    """
    try:
        if path.stat().st_size > SIZE_LIMIT:
            raise ModelError(f"{path}: larger than {SIZE_LIMIT >> 20} MiB, no MJCF model")
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ModelError(f"{path}: not a text file, so no MJCF model") from None
    except OSError as error:
        raise ModelError(
            f"{path}: cannot read ({error.strerror}); models that come with the package are "
            f"{available(shipped_names())}"
        ) from None
    if "<include" in text:
        try:
            text = mujoco.MjSpec.from_file(str(path)).to_xml()
        except ValueError as error:
            raise ModelError(f"{path}: {error}") from None
    return text


def _spec(mjcf: str, source: str) -> mujoco.MjSpec:
    try:
        spec = mujoco.MjSpec.from_string(mjcf)
    except ValueError as error:
        raise ModelError(f"{source}: {error}") from None
    if Path(source).is_file():
        spec.modelfiledir = str(Path(source).resolve().parent)
    return spec


def _compiled(spec: mujoco.MjSpec, source: str) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        raise ModelError(f"{source}: does not compile: {error}") from None


def as_written(mjcf: str, source: str) -> mujoco.MjModel:
    """Compile the text as it is. Raises ModelError when it does not compile."""
    return _compiled(_spec(mjcf, source), source)


def joints(mjcf: str, source: str) -> tuple[str, ...]:
    """Return the names of the joints."""
    return names_in(as_written(mjcf, source))["joint"]


def structure(
    mjcf: str, source: str, clamped: bool, mechanisms: Iterable[Mechanism] = ()
) -> mujoco.MjModel:
    """Compile with the ground fast or free, and with mechanisms."""
    spec = _structured(mjcf, source, clamped)
    replay(spec, mechanisms)
    return _compiled(spec, source)


def exported(mjcf: str, source: str, clamped: bool, mechanisms: Iterable[Mechanism]) -> str:
    """Return MJCF text of all digits with mechanisms; a fast ground stays in its clamp."""
    spec = _spec(mjcf, source) if clamped else _structured(mjcf, source, clamped)
    replay(spec, mechanisms)
    spec.compiler.savecompiled = False  # else numbers keep six digits
    _compiled(spec.copy(), source)
    head, line, rest = spec.to_xml().partition("\n")
    comment = in_words(mechanisms).replace("--", "- -")
    return f"{head}{line}  <!--\n{comment}\n  -->\n{rest}" if comment else head + line + rest


def _structured(mjcf: str, source: str, clamped: bool) -> mujoco.MjSpec:
    """Take the clamp away and, where it is fast, the joint with it: exact, and faster."""
    spec = _spec(mjcf, source)
    clamp = spec.equality("clamp")
    if clamp is not None:
        spec.delete(clamp)
    joint = spec.joint("ground")
    if clamped and joint is not None:
        spec.delete(joint)
        if not _complete(spec):
            # An actuator, a sensor or a tendon needs the joint: let the clamp hold it.
            spec = _spec(mjcf, source)
            if spec.equality("clamp") is None:
                _add_clamp(spec)
    return spec


def _complete(spec: mujoco.MjSpec) -> bool:
    """Whether nothing refers to what was deleted; a copy drops tendons that do."""
    try:
        compiled = spec.copy().compile()
    except ValueError:
        return False
    return bool(compiled.ntendon == len(spec.tendons))


def _add_clamp(spec: mujoco.MjSpec) -> None:
    clamp = spec.add_equality()
    clamp.name = "clamp"
    clamp.type = mujoco.mjtEq.mjEQ_JOINT
    clamp.objtype = mujoco.mjtObj.mjOBJ_JOINT
    clamp.name1 = "ground"
    clamp.solref = [0.002, 1]
    clamp.solimp = [0.9999, 0.9999, 0.001, 0.5, 2]


def driven(
    mjcf: str,
    source: str,
    clamped: bool,
    axes: Sequence[str] = (),
    mechanisms: Iterable[Mechanism] = (),
) -> mujoco.MjModel:
    """Compile for a simulation: inputs become integrators, so that they are linear between samples.

    The control of every actuator is then the slope of its input [1/s]. The integrator is RK4
    whatever the file says: at 2 ms Euler is off by 0.05 % in frequency, ``discrete`` by ten times
    the damping.

    Args:
        mjcf: the model's text.
        source: its name, for messages.
        clamped: whether a joint ``ground`` is held fast; it is on a ground that is shaken.
        axes: along which all that stands in the world is shaken, by the actuators
            ``twin.model.shaking.drive_name``.
        mechanisms: what the model has beyond its text.
    """
    spec = _structured(mjcf, source, clamped or bool(axes))
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    replay(spec, mechanisms)
    for actuator in spec.actuators:
        if actuator.dyntype != mujoco.mjtDyn.mjDYN_NONE:
            continue
        actuator.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
        if actuator.ctrllimited != mujoco.mjtLimited.mjLIMITED_FALSE and any(actuator.ctrlrange):
            # A limit on the input would now be one on its slope.
            actuator.ctrllimited = mujoco.mjtLimited.mjLIMITED_FALSE
            if actuator.forcelimited != mujoco.mjtLimited.mjLIMITED_TRUE:
                actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
                actuator.forcerange = actuator.gainprm[0] * actuator.ctrlrange
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    if axes:
        spec = shaken(spec, tuple(axes), source)
    return _compiled(spec, source)
