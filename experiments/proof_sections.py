"""Sections of the proof's page out of results that are kept as numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from experiments.proof_nuisances import nuisances
from experiments.proof_tolerances import tolerances

Section = dict[str, Any]


def section(name: str, given: Mapping[str, Any]) -> Section:
    """Return text, command, tables and curves of a section; as it is where it has them already."""
    return dict(MADE[name](given)) if name in MADE else dict(given)


def real(given: Mapping[str, Any]) -> Section:
    """Return what the real recordings and the published systems gave."""
    tables = []
    if "silverbox" in given:
        box = given["silverbox"]
        rows = [(value, method) for method, value in box["published_error_mV"].items()]
        rows += [(value, f"**this twin, {name}**") for name, value in box["error_mV"].items()]
        tables.append(
            {
                "title": "Silverbox, measured: error on the growing arrow, trained on the "
                f"multisines. Found: {_found(box)}",
                "columns": ["Method", "RMS error [mV]"],
                "rows": [[method, f"{value:.3g}"] for value, method in sorted(rows, reverse=True)],
            }
        )
    if "bouc_wen" in given:
        tables += _bouc_wen(given["bouc_wen"])
    if "bncs" in given:
        tables.append(_building(given["bncs"]))
    for name, title in (("f16", "F-16 ground vibration test, level 1"), ("robot_arm", "Robot arm")):
        if name in given:
            shares = [
                [key, f"{100 * value:.2g} %"]
                for key, value in given[name].items()
                if isinstance(value, float) and key != "seconds"
            ]
            tables.append(
                {"title": title, "columns": ["Share of the response (or of its power)", ""],
                 "rows": shares}
            )  # fmt: skip
    text = (
        "Recordings that nobody here made, and the Bouc-Wen benchmark generated from its published "
        "equations. Published errors are those that the authors give; on the Bouc-Wen system they "
        "are for the official test files, ours for realisations of the same kind."
    )
    return {"text": text, "command": "python experiments/real_diagnosis.py DATA", "tables": tables}


def _building(part: Mapping[str, Any]) -> Section:
    columns = ("calibrated linear twin", "best equivalent-linear twin", "explained twin",
               "stated beforehand")  # fmt: skip
    held = {name: own for name, own in part.items() if isinstance(own, dict)}
    return {
        "title": "A full-scale building on rubber isolators (BNCS): error on the motion that was "
        "held out, each in turn; the equivalent-linear twin is fitted to that very motion",
        "columns": ["Held out", "Found", *columns, "seconds"],
        "rows": [
            [name, own["found"], *(f"{own[c]:.3g}" for c in columns), f"{own['seconds']:.0f}"]
            for name, own in held.items()
        ],
    }


def _bouc_wen(system: Mapping[str, Any]) -> list[Section]:
    tables = []
    for test, ours in system["rms_error_m"].items():
        rows = [(value, f"**this twin, {name}**") for name, value in ours.items()]
        if "multisine" in test:
            rows += [(value, name) for name, value in system["published_rms_error_m"].items()]
        tables.append(
            {
                "title": f"Bouc-Wen benchmark: {test}. Found: {_found(system)}",
                "columns": ["Method", "RMS error [m]"],
                "rows": [[name, f"{value:.3g}"] for value, name in sorted(rows, reverse=True)],
            }
        )
    return tables


def _found(part: Mapping[str, Any]) -> str:
    named = [f"`{f['mechanism']}` at {f['location']}" for f in part["findings"]]
    return ", ".join(named) or "nothing"


def peers(given: Mapping[str, Any]) -> Section:
    """Return what others said and reached on the same cases."""
    cases = list(given["cases"].values())
    methods = list(dict.fromkeys(key for row in cases for key in row if key != "truth"))
    rows = []
    for method in methods:
        told = [row for row in cases if method in row]
        right = sum(_same(row[method].get("says"), row["truth"]) for row in told)
        rows.append(
            [
                method, f"{right} of {len(told)}",
                *(f"{_median(told, method, key):.3g}" for key in ("free", "ahead")),
                str(sum(row[method].get("free") is None for row in told)),
            ]
        )  # fmt: skip
    text = (
        f"The same training and test recordings, {len(cases)} cases, each package used as its "
        "documentation says. Who has no such feature names nothing: `mujoco.sysid` fits parameters "
        "that it is given, `sysidentpy` a polynomial of inputs and outputs, `pysindy` names terms "
        "of a library of laws. What diverges counts as an infinite error in the medians."
    )
    columns = ["Method", "Mechanism and place right", "Free run, NRMSE, median",
               "Two seconds ahead", "Diverged"]  # fmt: skip
    return {
        "text": text,
        "command": "python benchmarks/diagnosis_peers.py FOLDER --cases 20",
        "tables": [{"title": "", "columns": columns, "rows": rows}],
    }


def _same(says: Mapping[str, str] | None, truth: Mapping[str, Any]) -> bool:
    return bool(says) and all(says[key] == truth[key] for key in ("mechanism", "location"))


def _median(rows: list[Mapping[str, Any]], method: str, key: str) -> float:
    values = [row[method].get(key) for row in rows]
    return float(np.median([np.inf if v is None else v for v in values]))


def p_delta(given: Mapping[str, Any]) -> Section:
    """Return what was said of the flexible frame, before and after a mass was added."""
    rows = []
    for when, one in given["said"].items():
        tied = [f"`{t['mechanism']}` at {t['location']} ({t['probability']:.2f})"
                for t in one["ties"]]  # fmt: skip
        findings = [f"`{f['mechanism']}` at {f['location']} ({f['probability']:.2f})"
                    for f in one["findings"]]  # fmt: skip
        asked = f"`{one['next_experiment']}`" if one["next_experiment"] else "nothing"
        rows.append([when, ", ".join(findings), ", ".join(tied) or "nothing",
                     f"{100 * one['unseen_error']:.2g} %", asked])  # fmt: skip
    text = (
        "The hidden truth is the flexible frame with gravity in MuJoCo, its beams with mass; the "
        "diagnosis is given the lumped frame. Weight takes stiffness from a storey: on one frame "
        "that is a softer storey, too; a recording with a mass bolted on tells them apart. The "
        "beams' own mass couples the floors, which looks like crosstalk of their sensors. "
        "Probabilities in brackets."
    )
    columns = ["Recordings", "Named", "Ties with", "Unseen error", "Asked for next"]
    return {"text": text, "command": given["command"],
            "tables": [{"title": "", "columns": columns, "rows": rows}]}  # fmt: skip


def controlled(given: Mapping[str, Any]) -> Section:
    """Return what was said of recordings of a controlled run, and the reductions predicted."""
    rows = []
    for one in given["cases"]:
        value = ", ".join(f"{v:.3g}" for v in one["value"].values()) or "-"
        known = {"friction": "torque", "deadband": "torque", "delay": "delay"}
        found = [f"{one['found'][known[k]]:.3g}" for k in one["value"] if known[k] in one["found"]]
        odds = one["probability"]
        rows.append(
            [
                one["concealed"].replace("_", " "), value, one["named"] or "nothing",
                ", ".join(found) or "-", "-" if odds is None else f"{odds:.2f}",
                *(f"{100 * one['reduction'][k]:.1f} %" for k in ("lab", "twin", "explained")),
            ]
        )  # fmt: skip
    text = (
        "The pendulum absorber in closed loop under its LQG controller, on an integrator of its "
        "own; torques in N m, delays in s. The reduction of the top floor's motion falls short of "
        "what the twin as it stands predicts; with the mechanism that was named it comes nearer."
    )
    columns = ["Concealed", "True", "Named first", "Found", "Probability", "Reduction in the lab",
               "As the twin stands", "Explained"]  # fmt: skip
    return {"text": text, "command": given["command"],
            "tables": [{"title": "", "columns": columns, "rows": rows}]}  # fmt: skip


def misses_again(given: Mapping[str, Any]) -> Section:
    """Return what the present version says of cases that others missed."""
    told = [case for case in given["cases"] if case["now"]]
    missed = [case for case in told if not case["before"]["right"]]
    worse = [case for case in told if case["before"]["ahead_not_worse"] is False]
    rows = [
        [
            case["case"],
            " and ".join(f"{e['mechanism']} {e['location']}" for e in case["truth"]["effects"]),
            *(f"{case[when]['found']}{'' if case[when]['right'] else ' (missed)'}"
              for when in ("before", "now")),
            *(_ratio(case[when]) for when in ("before", "now")),
        ]
        for case in sorted(told, key=lambda case: _in_order(case["case"]))
    ]  # fmt: skip
    text = (
        "The cases of the sealed campaigns that were missed, and those in which the extended twin "
        "foresaw worse than the calibrated one, diagnosed again by commit "
        f"{given['made_with']['commit']}. They have been opened, and some were used to mend the "
        "tool: what follows counts nowhere else. Of "
        f"{len(missed)} that were missed {sum(case['now']['right'] for case in missed)} are "
        f"answered rightly; of {len(worse)} that foresaw worse "
        f"{sum(bool(case['now']['ahead_not_worse']) for case in worse)} no longer do."
    )
    columns = ["Case", "Concealed", "Named first then", "Now",
               "Two seconds ahead, over calibrated, then", "Now"]  # fmt: skip
    return {"text": text, "command": "python experiments/misses_again.py FOLDER",
            "tables": [{"title": "", "columns": columns, "rows": rows}]}  # fmt: skip


def _in_order(name: str) -> tuple[int, str]:
    campaign, _, case = name.partition("/")
    return int(campaign), case


def _ratio(said: Mapping[str, Any]) -> str:
    value = said["explained_over_calibrated_ahead"]
    return "-" if value is None else f"{value:.4g}"


MADE: dict[str, Callable[[Mapping[str, Any]], Section]] = {
    "real": real, "peers": peers, "p_delta": p_delta, "controlled": controlled,
    "misses_again": misses_again, "nuisances": nuisances,
    "drawings": tolerances,
}  # fmt: skip
