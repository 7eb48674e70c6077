"""The nominal rigs of the tables, and the models of those that do not come with the package."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from twin.frame import FrameDesign, Storey, to_mjcf

from .rig import TWO_STOREY, Rig

MODEL_FILE = "model.xml"
TALL = {"three_storeys": 3, "five_storeys": 5}

FLOOR_KG, TOP_KG, STOREY_N_M = 0.65, 1.55, TWO_STOREY.stiffnesses[0]
RATIOS = TWO_STOREY.damping_ratios


def nominal_of(table: str) -> Rig:
    """Return the rig of a table before its scatter."""
    return tall(TALL[table]) if table in TALL else TWO_STOREY


def tall(storeys: int) -> Rig:
    """Return a frame of that many storeys like the shipped one: equal, the top floor heavier."""
    masses = (FLOOR_KG,) * (storeys - 1) + (TOP_KG,)
    ratios = (RATIOS + (RATIOS[-1],) * storeys)[:storeys]
    return Rig(masses, (STOREY_N_M,) * storeys, ratios, model=MODEL_FILE)


def write_model(rig: Rig, folder: Path) -> None:
    """Write the model that a diagnosis is told, unless it comes with the package."""
    if rig.model != MODEL_FILE:
        return
    stiffest = Storey().stiffness
    storeys = tuple(
        Storey(floor_mass=mass, young_modulus=Storey().young_modulus * stiffness / stiffest)
        for mass, stiffness in zip(rig.masses, rig.stiffnesses, strict=True)
    )
    design = FrameDesign(storeys=storeys, kind="lumped", damping_ratio=rig.damping_ratios)
    (folder / MODEL_FILE).write_text(to_mjcf(design, f"{rig.storeys}_storeys"), encoding="utf-8")


def model_of(case: str | dict[str, Any], folder: Path | None = None) -> str:
    """Return the model that a diagnosis is told.

    Args:
        case: a table's name, or an opened truth.
        folder: of the case's recordings; None leaves the file's name alone.
    """
    table = case if isinstance(case, str) else case["table"]
    model = nominal_of(table).model
    return str(folder / model) if folder is not None and model == MODEL_FILE else model
