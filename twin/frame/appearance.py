"""How the frame looks: geometry without mass, so that nothing here changes the motion."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from twin.frame.absorber import PIVOT
from twin.frame.design import Pendulum, Storey
from twin.frame.mjcf import Document, Value, add
from twin.frame.scene import ALUMINIUM, CLAMP_HEIGHT, DEPTH, SPAN, rod_height

STEEL_DENSITY = 7850.0
PLATE = (0.21, 0.08, 0.01)
"""Half sizes of the base plate [m]."""
BLOCK = 0.02
"""Height of the blocks on the base plate that clamp the beams [m]."""

MATERIALS: dict[str, dict[str, Value]] = {
    "aluminium": {"rgba": (0.80, 0.82, 0.85, 1), "specular": 0.6, "shininess": 0.5},
    "dark_aluminium": {"rgba": (0.52, 0.55, 0.60, 1), "specular": 0.5, "shininess": 0.4},
    "steel": {"rgba": (0.40, 0.46, 0.55, 1), "specular": 0.9, "shininess": 0.8},
    "weight": {"rgba": (0.33, 0.35, 0.38, 1), "specular": 0.4, "shininess": 0.3},
    "bolt": {"rgba": (0.18, 0.19, 0.21, 1), "specular": 0.6, "shininess": 0.6},
    "sensor": {"rgba": (0.93, 0.55, 0.13, 1), "specular": 0.3, "shininess": 0.3},
    "motor": {"rgba": (0.13, 0.15, 0.18, 1), "specular": 0.5, "shininess": 0.4},
    "brass": {"rgba": (0.83, 0.66, 0.30, 1), "specular": 0.8, "shininess": 0.7},
    "shaker": {"rgba": (0.16, 0.33, 0.52, 1), "specular": 0.4, "shininess": 0.4},
    "mark": {"rgba": (0.85, 0.15, 0.15, 1), "specular": 0.1, "shininess": 0.1},
}


def _geom(body: Element, kind: str, **attributes: Value) -> None:
    add(body, "geom", type=kind, **attributes)


def box(body: Element, material: str, pos: Value, size: Value) -> None:
    """Draw a box of these half sizes [m]."""
    _geom(body, "box", pos=pos, size=size, material=material)


def rod(body: Element, material: str, start: Value, end: Value, radius: float) -> None:
    """A cylinder from one point to another."""
    assert not isinstance(start, (str, float))
    assert not isinstance(end, (str, float))
    _geom(body, "cylinder", fromto=(*start, *end), size=radius, material=material)


def surroundings(document: Document, height: float, with_shaker: bool = True) -> None:
    """Add materials, lights, cameras, bench and shaker for a structure of that height [m]."""
    asset = document.section("asset")
    add(
        asset,
        "texture",
        type="skybox",
        builtin="gradient",
        rgb1=(0.93, 0.95, 0.97),
        rgb2=(0.55, 0.62, 0.70),
        width=256,
        height=1536,
    )
    add(
        asset,
        "texture",
        name="bench",
        type="2d",
        builtin="checker",
        rgb1=(0.30, 0.32, 0.34),
        rgb2=(0.33, 0.35, 0.37),
        width=256,
        height=256,
    )
    add(asset, "material", name="bench", texture="bench", texrepeat=(30, 30), reflectance=0.08)
    for name, look in MATERIALS.items():
        add(asset, "material", name=name, **look)
    visual = document.section("visual")
    add(visual, "global", offwidth=1920, offheight=1440, azimuth=120, elevation=-12)
    add(visual, "quality", shadowsize=4096, offsamples=8)
    add(
        visual,
        "headlight",
        ambient=(0.30, 0.30, 0.32),
        diffuse=(0.35, 0.35, 0.35),
        specular=(0.2, 0.2, 0.2),
    )
    statistic = document.section("statistic")
    statistic.set("center", f"0 0 {height / 2:.6g}")
    statistic.set("extent", f"{max(height, 0.5):.6g}")
    world = document.section("worldbody")
    look_at = max(height, 0.45)
    add(
        world,
        "light",
        pos=(-0.6, -1.2, look_at + 1.2),
        dir=(0.35, 0.7, -1),
        directional="true",
        diffuse=(0.6, 0.6, 0.58),
    )
    _camera(world, "side", (0, -2.1 * look_at, 0.52 * look_at), (1, 0, 0), (0, 0.03, 1))
    _camera(
        world,
        "rig",
        (0.95 * look_at, -1.75 * look_at, 0.85 * look_at),
        (0.88, 0.4775, 0),
        (-0.0931, 0.1716, 0.98),
    )
    add(world, "geom", type="plane", size=(3, 3, 0.1), material="bench")
    if with_shaker:
        _shaker(world)


def _camera(
    world: Element, name: str, pos: Value, x_axis: tuple[float, ...], y_axis: tuple[float, ...]
) -> None:
    add(world, "camera", name=name, pos=pos, xyaxes=(*x_axis, *y_axis), fovy=32)


def _shaker(world: Element) -> None:
    """The shaker that stands on the bench; its stinger belongs to the ground."""
    z = CLAMP_HEIGHT - BLOCK - PLATE[2]
    rod(world, "shaker", (-0.42, 0, z), (-0.32, 0, z), 0.042)
    rod(world, "bolt", (-0.32, 0, z), (-0.312, 0, z), 0.02)
    box(world, "motor", (-0.37, 0, 0.006), (0.06, 0.05, 0.006))
    for side in (-1, 1):
        box(world, "shaker", (-0.37, side * 0.044, z / 2 + 0.006), (0.018, 0.004, z / 2))


def ground_geometry(document: Document, ground: Element) -> None:
    """Base plate on rails, blocks that clamp the beams, stinger with load cell, accelerometer."""
    plate = -BLOCK - PLATE[2]
    box(ground, "dark_aluminium", (0, 0, plate), PLATE)
    for side in (-1, 1):
        inner = side * (SPAN / 2 - 0.012)
        box(ground, "aluminium", (inner, 0, -BLOCK / 2), (0.012, DEPTH / 2, BLOCK / 2))
        _clamp(ground, side, -BLOCK / 2, BLOCK / 2)
        world = document.section("worldbody")
        rail = CLAMP_HEIGHT - BLOCK - 2 * PLATE[2]
        box(world, "steel", (0, side * 0.055, rail / 4), (0.27, 0.010, rail / 4))
        for end in (-1, 1):
            box(
                ground,
                "motor",
                (end * 0.15, side * 0.055, rail * 0.75 - CLAMP_HEIGHT),
                (0.03, 0.016, rail * 0.25),
            )
    rod(ground, "brass", (-PLATE[0], 0, plate), (-PLATE[0] - 0.022, 0, plate), 0.010)
    rod(ground, "steel", (-PLATE[0] - 0.022, 0, plate), (-0.33, 0, plate), 0.0025)
    _accelerometer(ground, (PLATE[0] - 0.02, 0, -BLOCK))


def _clamp(body: Element, side: int, height: float, half: float) -> None:
    """The plate that holds a beam against a rod's end, with two bolts."""
    outer = side * (SPAN / 2 + 0.0045)
    box(body, "dark_aluminium", (outer, 0, height), (0.003, DEPTH / 2, half))
    for y in (-0.3 * DEPTH, 0.3 * DEPTH):
        head = side * (SPAN / 2 + 0.0075)
        rod(body, "bolt", (head, y, height), (head + side * 0.003, y, height), 0.0035)


def _accelerometer(body: Element, base: tuple[float, float, float]) -> None:
    """An accelerometer block with its plug, standing on a surface, sensitive along x."""
    x, y, z = base
    box(body, "sensor", (x, y, z + 0.006), (0.008, 0.008, 0.006))
    rod(body, "bolt", (x, y + 0.008, z + 0.006), (x, y + 0.016, z + 0.006), 0.003)


def floor_geometry(floor: Element, storey: Storey, with_motor: bool) -> None:
    """Rod, clamps, accelerometer, hammer's mark, and what is bolted on: weight or motor."""
    half = rod_height(storey) / 2
    box(floor, "aluminium", (0, 0, 0), (SPAN / 2, DEPTH / 2, half))
    for side in (-1, 1):
        _clamp(floor, side, 0, half)
    _accelerometer(floor, (SPAN / 2 - 0.02, 0, half))
    mark = -SPAN / 2 - 0.0075
    rod(floor, "mark", (mark - 0.001, 0, 0), (mark, 0, 0), 0.005)
    extra = storey.floor_mass - ALUMINIUM * SPAN * DEPTH * 2 * half
    if with_motor:
        _motor(floor, half)
    elif extra > 0.05:
        height = extra / (STEEL_DENSITY * 0.12 * DEPTH)
        box(floor, "weight", (0, 0, half + height / 2), (0.06, DEPTH / 2, height / 2))
        for x in (-0.045, 0.045):
            top = half + height
            rod(floor, "bolt", (x, 0, top), (x, 0, top + 0.004), 0.005)


def _motor(floor: Element, half: float) -> None:
    """The brushless motor with its encoder, its shaft along y."""
    x, y, z = PIVOT
    box(floor, "dark_aluminium", (x, 0, half + 0.004), (0.04, DEPTH / 2, 0.004))
    rod(floor, "motor", (x, -0.022, z), (x, 0.036, z), 0.022)
    rod(floor, "sensor", (x, 0.036, z), (x, 0.048, z), 0.016)
    rod(floor, "steel", (x, -0.022, z), (x, y - 0.007, z), 0.004)


def pendulum_geometry(body: Element, pendulum: Pendulum) -> None:
    """A rod of twice the distance to its centre of mass, with the mass at its tip."""
    tip = -2 * pendulum.centre_distance
    rod(body, "bolt", (0, -0.006, 0), (0, 0.006, 0), 0.009)
    box(body, "aluminium", (0, 0, tip / 2), (0.004, 0.002, -tip / 2))
    rod(body, "brass", (0, -0.009, tip), (0, 0.009, tip), 0.014)


def beam_skins(
    document: Document,
    number: int,
    storey: Storey,
    lower_clamp: float,
    origins: tuple[float, float],
) -> None:
    """Draw both beams of a storey as skins that bend as clamped beams do.

    A vertex at height s L follows the body below by 1 - w and the floor above by
    w = 3 s^2 - 2 s^3, the deflection of a beam whose clamps stay parallel. Skins move with the
    bodies and weigh nothing.

    Args:
        document: gets the skins.
        number: of the storey.
        storey: its beams.
        lower_clamp: height of the lower clamp in the world [m].
        origins: heights of the origins of the body below and of the floor in the world [m].
    """
    levels = 12
    weights = [(k / levels) ** 2 * (3 - 2 * k / levels) for k in range(levels + 1)]
    below = "ground" if number == 1 else f"floor{number - 1}"
    faces = strip_faces(levels)
    for side, name in ((-1, "left"), (1, "right")):
        inner, outer = (side * (SPAN / 2 + d) for d in (0.0, storey.beam_thickness))
        near, far = sorted((inner, outer))
        half = storey.beam_width / 2
        corners = ((near, -half), (far, -half), (far, half), (near, half))
        vertices = [
            round(value, 6)
            for k in range(levels + 1)
            for x, y in corners
            for value in (x, y, lower_clamp + storey.beam_length * k / levels)
        ]
        skin = add(
            document.section("deformable"),
            "skin",
            name=f"beam{number}_{name}",
            material="steel",
            vertex=vertices,
            face=faces,
        )
        for body, share, origin in (
            (below, [1 - w for w in weights], origins[0]),
            (f"floor{number}", weights, origins[1]),
        ):
            used = [k for k in range(levels + 1) if share[k] > 0]
            add(
                skin,
                "bone",
                body=body,
                bindpos=(0, 0, origin),
                bindquat=(1, 0, 0, 0),
                vertid=[4 * k + corner for k in used for corner in range(4)],
                vertweight=[round(share[k], 6) for k in used for _ in range(4)],
            )


def strip_faces(levels: int) -> list[float]:
    """Triangles of a closed box of four corners a level, turned outwards."""
    faces: list[int] = []
    for k in range(levels):
        for a in range(4):
            b = (a + 1) % 4
            low_a, low_b, top_a, top_b = 4 * k + a, 4 * k + b, 4 * k + 4 + a, 4 * k + 4 + b
            faces += [low_a, low_b, top_b, low_a, top_b, top_a]
    return [float(index) for index in faces]
