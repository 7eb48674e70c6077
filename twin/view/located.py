"""Where in a model a place is: the box around what moves there, its share of what is missing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.result import Diagnosis
from twin.errors import ModelError
from twin.model.port import GROUND, Port

Array = NDArray[np.float64]

SITE = 0.02
"""Half the edge of the box around a site [m]."""

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)

_OF_ACTUATOR = {
    mujoco.mjtTrn.mjTRN_JOINT: "joint",
    mujoco.mjtTrn.mjTRN_SITE: "site",
    mujoco.mjtTrn.mjTRN_BODY: "body",
    mujoco.mjtTrn.mjTRN_TENDON: "tendon",
}
_OF_SENSOR = {
    mujoco.mjtObj.mjOBJ_SITE: "site",
    mujoco.mjtObj.mjOBJ_BODY: "body",
    mujoco.mjtObj.mjOBJ_XBODY: "body",
    mujoco.mjtObj.mjOBJ_JOINT: "joint",
    mujoco.mjtObj.mjOBJ_TENDON: "tendon",
}


@dataclass(frozen=True)
class Region:
    """What a place consists of, by number.

    Attributes:
        bodies: that move there.
        sites: that it is at.
        below: bodies from whose origins it reaches to those that move.
    """

    bodies: tuple[int, ...] = ()
    sites: tuple[int, ...] = ()
    below: tuple[int, ...] = ()

    def box(self, model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array] | None:
        """Return centre and half the edges of the box around it as it lies now, (3,) each."""
        found = [
            corners(model, data, g)
            for g in range(model.ngeom)
            if model.geom_bodyid[g] in self.bodies and not endless(model, g)
        ]
        found += [data.xpos[[b]] for b in (*self.bodies, *self.below) if b]
        found += [data.site_xpos[s] + SITE * CORNERS for s in self.sites]
        if not found:
            return None
        every = np.vstack(found)
        low, high = every.min(axis=0), every.max(axis=0)
        return (low + high) / 2, np.maximum((high - low) / 2, SITE / 2)


def endless(model: mujoco.MjModel, geom: int) -> bool:
    """Return whether a geom has no end, as a plane has not."""
    kinds = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)
    return int(model.geom_type[geom]) in [int(kind) for kind in kinds]


def corners(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Array:
    """Return the corners of the box around a geom, in the world [m], (8, 3)."""
    box = model.geom_aabb[geom]
    local = box[:3] + CORNERS * box[3:]
    return np.asarray(local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])


def region(model: mujoco.MjModel, ports: Mapping[str, Port], place: str) -> Region | None:
    """Return what a place consists of, or None where the model has nothing of that name.

    A joint or tendon is between the bodies that it holds together, a body's or a site's motion at
    it, a channel at its sensor or actuator, the base at what stands on the ground.

    Args:
        model: compiled.
        ports: of it, by name.
        place: a port, a body, a channel or two joined by "+", "ground".
    """
    parts = []
    for name in place.split("+"):
        one = _element(model, ports, name)
        if one is None and "-" in name:
            halves = [_element(model, ports, half) for half in name.split("-", 1)]
            parts += [half for half in halves if half is not None]
        elif one is not None:
            parts.append(one)
    if not parts:
        return None
    return Region(
        tuple(dict.fromkeys(b for part in parts for b in part.bodies)),
        tuple(dict.fromkeys(s for part in parts for s in part.sites)),
        tuple(dict.fromkeys(b for part in parts for b in part.below)),
    )


def _element(model: mujoco.MjModel, ports: Mapping[str, Port], name: str) -> Region | None:
    if name in ports and " " in ports[name].element:
        kind, element = ports[name].element.split(" ", 1)
        return _of(model, kind, _number(model, kind, element))
    bare = name.removesuffix(".x").removesuffix(".y").removesuffix(".z")
    sensor = _number(model, "sensor", bare)
    if sensor >= 0:
        kind = _OF_SENSOR.get(mujoco.mjtObj(model.sensor_objtype[sensor]), "")
        return _of(model, kind, int(model.sensor_objid[sensor]))
    actuator = _number(model, "actuator", bare)
    if actuator >= 0:
        kind = _OF_ACTUATOR.get(mujoco.mjtTrn(model.actuator_trntype[actuator]), "")
        return _of(model, kind, int(model.actuator_trnid[actuator, 0]))
    if _number(model, "body", bare) >= 0:
        return _of(model, "body", _number(model, "body", bare))
    if bare in (GROUND, f"acc_{GROUND}"):
        return Region(tuple(b for b in range(model.nbody) if model.body_weldid[b] == 0))
    return None


def _number(model: mujoco.MjModel, kind: str, name: str) -> int:
    return int(mujoco.mj_name2id(model, mujoco.mju_str2Type(kind), name))


def _of(model: mujoco.MjModel, kind: str, number: int) -> Region | None:
    if number < 0:
        return None
    if kind == "site":
        return Region((), (number,))
    if kind == "body":
        return Region((number,))
    if kind == "joint":
        body = int(model.jnt_bodyid[number])
        return Region((body,), (), (int(model.body_parentid[body]),))
    if kind == "tendon":
        return _of_tendon(model, number)
    return None


def _of_tendon(model: mujoco.MjModel, tendon: int) -> Region:
    bodies: list[int] = []
    below: list[int] = []
    sites: list[int] = []
    first = model.tendon_adr[tendon]
    for wrap in range(first, first + model.tendon_num[tendon]):
        kind, number = model.wrap_type[wrap], int(model.wrap_objid[wrap])
        if kind == mujoco.mjtWrap.mjWRAP_JOINT:
            held = _of(model, "joint", number)
            bodies += held.bodies if held else ()
            below += held.below if held else ()
        elif kind == mujoco.mjtWrap.mjWRAP_SITE:
            sites.append(number)
    return Region(tuple(dict.fromkeys(bodies)), tuple(sites), tuple(dict.fromkeys(below)))


def regions(diagnosis: Diagnosis, places: Iterable[str]) -> dict[str, Region]:
    """Return the regions of those places that the nominal twin's model has."""
    twin = diagnosis.nominal
    model = twin.compile()
    try:
        ports = twin.linear((), ()).ports
    except ModelError:
        ports = {}
    found = {place: region(model, ports, place) for place in places}
    return {place: r for place, r in found.items() if r is not None}


def shares(diagnosis: Diagnosis) -> dict[str, float]:
    """Return how much of what is missing is at each located place, between 0 and 1.

    It is the RMS of the missing force there times that of the rate [W], forces and moments alike,
    over the sum of all located places; a place without a force (an instrument) has its finding's
    probability.
    """
    drawn = {picture.place: picture for picture in diagnosis.force}
    power = {}
    for finding in diagnosis.findings:
        picture = drawn.get(finding.location)
        if picture is not None:
            size = np.sqrt(np.mean(picture.latent**2) * np.mean(picture.rate**2))
            power[finding.location] = float(size)
    total = sum(power.values())
    out = {place: value / total if total > 0 else 1.0 for place, value in power.items()}
    for finding in diagnosis.findings:
        out.setdefault(finding.location, float(np.clip(finding.probability, 0, 1)))
    return out
