"""How frames in three dimensions look: geometry without mass, columns that bend as skins."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from twin.frame.appearance import STEEL_DENSITY, box, strip_faces
from twin.frame.mjcf import Document, Value, add
from twin.frame.space import Column, SpaceStorey

LEVELS = 12
"""Slices of a column that is drawn."""


def ground(body: Element, storey: SpaceStorey) -> None:
    """Draw the base plate, its upper face at the origin, and the clamps of the columns."""
    x, y, _ = storey.floor_size
    box(body, "dark_aluminium", (0, 0, -0.02), (0.65 * x, 0.65 * y, 0.02))


def floor(body: Element, storey: SpaceStorey) -> None:
    """Draw the plate."""
    box(body, "aluminium", (0, 0, 0), tuple(size / 2 for size in storey.floor_size))


def load_size(mass: float) -> tuple[float, float, float]:
    """Return the edges of a steel cube of that mass [m]."""
    edge = float(round((mass / STEEL_DENSITY) ** (1 / 3), 6))
    return (edge, edge, edge)


def load(body: Element, mass: float, storey: SpaceStorey) -> None:
    """Draw a load on its floor's surface."""
    half = load_size(mass)[0] / 2
    box(body, "weight", (0, 0, storey.floor_size[2] / 2 + half), (half, half, half))


def accelerometer(
    body: Element, point: tuple[float, float, float], above: float, quat: Value
) -> None:
    """Draw an accelerometer's block over the point where it measures."""
    x, y, z = point
    add(
        body,
        "geom",
        type="box",
        pos=(x, y, z + above + 0.006),
        size=(0.009, 0.007, 0.006),
        quat=quat,
        material="sensor",
    )


def columns(document: Document, number: int, storey: SpaceStorey, base: float) -> None:
    """Draw the columns of a storey as skins; they follow the floors and weigh nothing.

    At height s L a column follows the body below by 1 - w and the floor above by
    w = 3 s^2 - 2 s^3, the deflection of a beam whose clamps stay parallel.

    Args:
        document: gets the skins.
        number: of the storey, from 1.
        storey: its columns.
        base: height of the origin of the body below in the world [m].
    """
    half = storey.floor_size[2] / 2
    lower = base if number == 1 else base + half
    length = storey.height - half - (0 if number == 1 else half)
    for index, column in enumerate(storey.columns, start=1):
        skin = add(
            document.section("deformable"),
            "skin",
            name=f"column{index}_storey{number}",
            material="steel",
            vertex=_vertices(column, lower, length),
            face=strip_faces(LEVELS),
        )
        shares = [(k / LEVELS) ** 2 * (3 - 2 * k / LEVELS) for k in range(LEVELS + 1)]
        below = "ground" if number == 1 else f"floor{number - 1}"
        _bone(skin, below, base, [1 - share for share in shares])
        _bone(skin, f"floor{number}", base + storey.height, shares)


def _vertices(column: Column, lower: float, length: float) -> list[float]:
    (x, y), (wide, deep) = column.position, (size / 2 for size in column.section)
    corners = ((-wide, -deep), (wide, -deep), (wide, deep), (-wide, deep))
    return [
        round(value, 6)
        for k in range(LEVELS + 1)
        for dx, dy in corners
        for value in (x + dx, y + dy, lower + length * k / LEVELS)
    ]


def _bone(skin: Element, body: str, origin: float, shares: list[float]) -> None:
    used = [k for k, share in enumerate(shares) if share > 0]
    add(
        skin,
        "bone",
        body=body,
        bindpos=(0, 0, round(origin, 6)),
        bindquat=(1, 0, 0, 0),
        vertid=[4 * k + corner for k in used for corner in range(4)],
        vertweight=[round(shares[k], 6) for k in used for _ in range(4)],
    )
