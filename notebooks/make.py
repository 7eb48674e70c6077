"""Write the notebooks from the cells below: python notebooks/make.py."""

from __future__ import annotations

import json
from pathlib import Path

HERE = Path(__file__).parent

NOTEBOOKS = {
    "1_test_and_identify": [
        "# Hit a virtual frame and identify it",
        """import twin

hits = [twin.hammer_test("two_storey_lumped", repetition=i) for i in range(2)]
hits[0]""",
        "Two blows on the first floor, sampled at 32 Hz as the paper does.",
        "hits[0].plot()",
        "Modes and matrices with the standard deviation of every number:",
        """found = twin.identify(hits)
found""",
        "found.plot()",
        "Beside the truth, which only a virtual test knows:",
        """true = twin.Twin.load("two_storey_lumped")
print(true.modes().natural_freq, true.second_order().K)
twin.mac(found.modal.mode_shape, true.modes().mode_shape).round(4)""",
        "The report that can be zoomed:",
        'found.save("identified.html")',
    ],
    "2_from_file_to_physics": [
        "# From recordings to named physics",
        "A cubic spring hides in a rig; its recordings are files like any laboratory's.",
        """import twin
from twin.mechanisms import vocabulary

nominal = twin.Twin.load("two_storey_lumped")
rig = nominal.including(vocabulary()["cubic_stiffness"]("storey1", 2e6))
shake = dict(at="floor2", rate_hz=128, duration_s=8, noise=0.005)
for name, seed, level in (("soft", 1, 0.1), ("hard", 2, 0.4), ("unseen", 3, 0.3)):
    twin.shaker_test(rig, level_n=level, seed=seed, **shake).save(f"{name}.csv")""",
        "Told the recordings and the nominal model, nothing else:",
        """found = twin.diagnose("two_storey_lumped", ["soft.csv", "hard.csv"], "unseen.csv")
found""",
        "found.plot()",
        "The twin that has it, as MJCF, and the report:",
        """found.save("explained.xml")
found.save("diagnosis.html")
assert found.findings[0].mechanism.name == "cubic_stiffness\"""",
    ],
    "3_own_structure": [
        "# A structure of your own",
        "Any MJCF is a twin, with the names that it has.",
        """import twin

portal = twin.Twin.load("portal_3d")
portal""",
        "Its ports are where something can act; its sensors are channels.",
        """model = portal.linear(("force_floor2_x",), ("acc_floor2_a.x",))
print(model.places("drift")[:6])
portal.modes().natural_freq.round(2)""",
        """shaken = twin.shaker_test(
    portal, at=("force_floor2_x", "force_floor2_y"), level_n=0.5, rate_hz=64, duration_s=16,
    band_hz=(0.5, 12), sensors=["acc_floor2_a.x", "acc_floor2_a.y", "acc_floor2_b.y"],
)
shaken""",
        """found = twin.identify(shaken)
found""",
        "found.plot()",
    ],
}


def cell(text: str) -> dict[str, object]:
    """Return a cell: of text where it begins as a heading or a sentence, else of code."""
    lines = text.splitlines(keepends=True)
    code = not (text.startswith("#") or text.rstrip().endswith((".", ":")))
    base: dict[str, object] = {"metadata": {}, "source": lines}
    if code:
        return {"cell_type": "code", "execution_count": None, "outputs": [], **base}
    return {"cell_type": "markdown", **base}


def main() -> None:
    """Write every notebook, without outputs."""
    for name, cells in NOTEBOOKS.items():
        notebook = {
            "cells": [{"id": f"cell{i}", **cell(text)} for i, text in enumerate(cells)],
            "metadata": {
                "kernelspec": {
                    "display_name": "Python 3", "language": "python", "name": "python3"
                },
                "language_info": {"name": "python"},
            },
            "nbformat": 4,
            "nbformat_minor": 5,
        }  # fmt: skip
        path = HERE / f"{name}.ipynb"
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", "utf-8")


if __name__ == "__main__":
    main()
