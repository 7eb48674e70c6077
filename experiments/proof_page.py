"""Write docs/PROOF.md and its pictures from the results under experiments/results/.

    python experiments/proof_page.py [--results DIR] [--docs DIR]

Needs concealed.json (``condense_campaign.py``). Each further file that ``SECTIONS`` names adds a
section where it is: ``text``, ``command``, ``tables`` (a list of ``title``, ``columns``, ``rows``),
``pictures`` (paths below the docs), ``curves`` (``proof_drawings.limits``).
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments import proof_calibration as calibration  # noqa: E402
from experiments import proof_drawings as drawings  # noqa: E402
from experiments.concealed.pictures import between, draw_confusion, number, percent  # noqa: E402
from experiments.concealed.score import effects_of  # noqa: E402
from experiments.concealed.summary import summarise  # noqa: E402
from experiments.proof_sections import section  # noqa: E402
from twin.files import folder, write_whole  # noqa: E402

DPI = 110
TEMPLATE = "proof.md.j2"
GUARD_TEST = ROOT / "tests" / "experiments" / "test_concealed_guard.py"
AIMS = {"single": 0.97, "pairs": 0.85, "absorbed": 0.88, "outside": 0.88, "near": 0.9, "none": 1.0}
"""Shares of right answers that were set before the campaign."""

ABOUT = {
    "single": ("one effect of the vocabulary", "mechanism and place first"),
    "none": ("nothing", "no finding"),
    "absorbed": ("one effect that calibration can swallow", "mechanism and place first"),
    "pairs": ("two effects at once", "both among the findings"),
    "outside": ("a law that no name of the vocabulary fits", "`unexplained`, at its place"),
    "near": (
        "a law that is nearly one of the vocabulary",
        "nearest name and place first, or `unexplained` there",
    ),
    "one_sensor": ("one effect, a single accelerometer", "mechanism and place first"),
    "ground": ("one effect, only the ground shaken", "mechanism and place first"),
    "three_storeys": ("one effect in three storeys", "mechanism and place first"),
    "five_storeys": ("one effect in five storeys", "mechanism and place first"),
    "portal": (
        "one effect at a column, a direction or the twist of a frame in space",
        "mechanism and place first",
    ),
    "rotated": ("one effect in a frame seen through turned sensors", "mechanism and place first"),
    "beam": ("one effect in a cantilever of ten hinges", "mechanism and place first"),
    "drive": ("one effect in a drive", "mechanism and place first"),
}
AGAIN = "misses_again"
SECTIONS = {
    AGAIN: "The misses again",
    "detection_limits": "Detection limits",
    "structures": "Any structure",
    "drawings": "Drawings that are off",
    "nuisances": "Not our simulator: instruments that misbehave",
    "p_delta": "Gravity on a flexible frame",
    "controlled": "A controlled run that falls short",
    "real": "Real recordings",
    "peers": "Peers on the same cases",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=Path, default=ROOT / "experiments" / "results")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs")
    given = parser.parse_args()
    print(write_page(given.results, given.docs))


def write_page(results: Path, docs: Path) -> Path:
    """Write the page and its pictures; return the page's path."""
    document = json.loads((results / "concealed.json").read_text())
    rows = document["rows"]
    summary = summarise({row["case"]: row for row in rows})
    pictures = folder(docs / "proof")
    _save(drawings.rates(summary["tables"], AIMS), pictures / "rates.png")
    curve = calibration.table(rows, results)
    panels = {
        f"first finding: sealed cases{' and weak effects' if curve['weak'] else ''}": curve[
            "curve"
        ],
        "findings and alternatives: sealed cases": summary["calibration_all"],
    }
    _save(drawings.calibration(panels), pictures / "calibration.png")
    _save(drawings.fit_ratios(rows), pictures / "fit_ratios.png")
    draw_confusion(summary["confusion"], pictures / "confusion.png", 80)
    loader = FileSystemLoader(Path(__file__).parent / "templates")
    # Markdown for people: nothing to escape for a browser
    environment = Environment(loader=loader, undefined=StrictUndefined, autoescape=False)
    text = environment.get_template(TEMPLATE).render(
        **_facts(document, rows, summary),
        curve=curve,
        again=SECTIONS[AGAIN] if (results / f"{AGAIN}.json").exists() else "",
        sections=_sections(results, pictures),
    )
    text = re.sub(r"\n{3,}", "\n\n", text).rstrip() + "\n"
    return write_whole(docs / "PROOF.md", lambda part: part.write_text(text))


def _save(figure: Figure, path: Path, dpi: int = DPI) -> None:
    write_whole(path, lambda part: figure.savefig(part, dpi=dpi))


def _facts(
    document: Mapping[str, Any], rows: list[dict[str, Any]], summary: dict[str, Any]
) -> dict[str, Any]:
    """Return what the template shows, in words."""
    tables = summary["tables"]
    noise = [row["truth"]["noise"] for row in rows]
    hidden = [row for row in rows if effects_of(row["truth"])]
    effect = [row["truth"]["effect_over_noise"] for row in hidden]
    effect = [value for value in effect if value]
    alarms = tables["none"]["false_alarm"] if "none" in tables else None
    return {
        "total": len(rows),
        "headline": _headline(summary),
        "noise": {"low": percent(min(noise)), "high": percent(max(noise))},
        "effect": {
            "low": number(min(effect)), "high": number(max(effect)),
            "median": number(float(np.median(effect))),
        },
        "tables": [
            dict(zip(("name", "cases", "what", "asked"), (name, of["cases"], *_about(name)),
                     strict=True))
            for name, of in tables.items()
        ],
        "ways": len(re.findall(r'^    "[^"]+": lambda', GUARD_TEST.read_text(), re.MULTILINE)),
        "commands": [p["command"] for c in document["campaigns"] for p in c["pieces"]],
        "campaigns": [
            [i, c["concealed"], c["diagnosed"], _made_with(c)]
            for i, c in enumerate(document["campaigns"], 1)
        ],
        "right": _right(tables),
        "near": _near(tables["near"]) if "near" in tables else None,
        "misses": [_miss(m) for m in summary["misses"] if m["table"] != "none"],
        "alarms": _alarms(alarms, [m for m in summary["misses"] if m["table"] == "none"]),
        "fits": _fits(summary),
        "left": sum(row["score"]["explained_over_calibrated_ahead"] == 1 for row in hidden),
        "worse": [
            [one["case"], f"{one['ratio']:.4g}", number(one["over_true"]),
             f"{one['ratio'] / one['over_true']:.4g}"]
            for one in summary["worse_ahead"]
        ],
    }  # fmt: skip


def _about(name: str) -> tuple[str, str]:
    return ABOUT.get(name, ("", "mechanism and place first"))


def _headline(summary: dict[str, Any]) -> dict[str, Any]:
    rows = []
    for name, of in summary["tables"].items():
        asked = f"{_about(name)[0]}: {_about(name)[1]}"
        aim = _aim(AIMS[name]) if name in AIMS else "-"
        rows.append([asked, *_counted(of["right"]), between(of["right"]), aim])
    key = "ahead_not_worse"
    rows.append(
        ["two seconds ahead: extended twin no worse than calibrated",
         *_counted(summary["all"][key]), between(summary["all"][key]), "always"]
    )  # fmt: skip
    columns = ["What was asked", "Right", "Share", "95 % interval", "Aim"]
    return {"columns": columns, "rows": rows}


def _aim(share: float) -> str:
    return f"at least {100 * share:g} %" if share < 1 else "all"


def _counted(share: dict[str, Any] | None) -> tuple[str, str]:
    if not share or not share["of"]:
        return "-", "-"
    return f"{share['count']} of {share['of']}", percent(share["share"])


def _right(tables: dict[str, Any]) -> dict[str, Any]:
    columns = ["Table", "Cases", "Right", "95 % interval", "First finding right", "Place right",
               "Verdict right", "Nothing else named", "Strength error, median"]  # fmt: skip
    rows = [
        [
            name, of["cases"], percent(of["right"]["share"]), between(of["right"]),
            *(percent(of[k]["share"]) for k in ("first_right", "place_right", "verdict_right")),
            percent(of["alone"]["share"]), percent(of["strength_error"]),
        ]
        for name, of in tables.items()
    ]  # fmt: skip
    return {"columns": columns, "rows": rows}


def _near(of: dict[str, Any]) -> dict[str, Any]:
    """Return what was said of the laws that are nearly in the vocabulary."""
    rows = [
        [asked, *_counted(of[key]), between(of[key]) if of[key]["of"] else "-", aim]
        for asked, key, aim in (
            ("nearest name and place first, or `unexplained` there", "right", "at least 90 %"),
            ("something else named besides", "spurious", "at most 5 %"),
            ("share explained within 10 points of the true one", "share_near", "-"),
        )
    ]
    return {"columns": ["What was asked", "Cases", "Share", "95 % interval", "Aim"], "rows": rows}


def _fits(summary: dict[str, Any]) -> dict[str, Any]:
    columns = [
        "Table", "Explained over true, free", "Two seconds ahead", "Noise floor over true, free",
        "Below the calibrated twin", "Seconds a diagnosis",
    ]  # fmt: skip
    every = {**summary["tables"], "all with an effect": summary["all"]}
    rows = [
        [
            name, number(of["explained_over_true"]), number(of["explained_over_true_ahead"]),
            number(of["noise_floor_over_true"]),
            percent(of["improved"]["share"]) if name != "none" else "-", number(of["seconds"]),
        ]
        for name, of in every.items()
    ]  # fmt: skip
    return {"columns": columns, "rows": rows}


def _miss(m: dict[str, Any]) -> list[str]:
    effect = "-" if m["effect_over_noise"] is None else f"{m['effect_over_noise']:.0f}"
    reason = str(m["reason"]).replace("|", "/")
    return [m["case"], m["table"], m["truth"], m["found"], number(m["probability"]), effect, reason]


def _alarms(alarms: dict[str, Any] | None, loud: list[dict[str, Any]]) -> str:
    if alarms is None:
        return "No case with nothing concealed."
    said = "; ".join(f"{m['case']}: {m['found']} ({number(m['probability'])})" for m in loud)
    text = (
        f"{alarms['count']} of {alarms['of']} rigs with nothing concealed were said to have "
        f"something: {percent(alarms['share'])}, 95 % interval {between(alarms)}."
    )
    return f"{text} {said}." if said else text


def _made_with(one: dict[str, Any]) -> str:
    used = one["diagnosed_with"] or [p["versions"] for p in one["pieces"]]
    return "; ".join(" ".join(f"{k} {v}" for k, v in u.items()) for u in used) or "not recorded"


def _sections(results: Path, pictures: Path) -> list[dict[str, Any]]:
    """Return the sections whose results are there."""
    found = []
    for name, title in SECTIONS.items():
        path = results / f"{name}.json"
        if not path.exists():
            continue
        given = section(name, json.loads(path.read_text()))
        shown = list(given.get("pictures", []))
        if given.get("curves"):
            _save(drawings.limits(given["curves"]), pictures / f"{name}.png", 75)
            shown.append(f"proof/{name}.png")
        keys = {key: given.get(key, "") for key in ("text", "command")}
        found.append({"title": title, **keys, "tables": given.get("tables", []), "pictures": shown})
    return found


if __name__ == "__main__":
    main()
