"""The section of the proof's page about instruments that misbehave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from experiments.concealed.pictures import between, percent
from experiments.concealed.shares import share
from experiments.instrument_faults import NUISANCES, STRENGTHS

TEXT = (
    "Recordings of simulated rigs, spoilt afterwards: each of fourteen nuisances at three "
    "strengths, of which 1 is what a laboratory would notice, alone. What is an instrument's must "
    "not be said of the structure, nor hide what is the structure's."
)
COMMAND = (
    "python -m experiments.nuisances --draws 2 --seed {seed}{effect} --to FILE  # commit {commit}"
)
EFFECT = {"none": "", "effect": " --effect"}
ASKED = {
    "none": "Nothing concealed: no structural finding",
    "effect": "One structural effect: mechanism and place first",
}


def nuisances(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the section, a table for each kind that was run."""
    tables = [_table(kind, given[kind]["cases"]) for kind in ASKED if kind in given]
    command = "\n".join(
        COMMAND.format(seed=given[kind]["seed"], effect=EFFECT[kind],
                       commit=given[kind]["made_with"].get("commit", "not known"))
        for kind in ASKED if kind in given
    )  # fmt: skip
    return {"text": TEXT, "command": command, "tables": tables}


def _table(kind: str, cases: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    rows = []
    for name, (how, _) in NUISANCES.items():
        own = [c for c in cases if c["case"].split(", ")[0] == name]
        if own:
            strengths = [
                [c for c in own if float(c["case"].split(", ")[1]) == s] for s in STRENGTHS
            ]
            rows.append([f"{name}: {_about(how)}", *map(_right, strengths), _last(kind, own)])
    rows.append(["all", *(_right([c for c in cases if float(c["case"].split(", ")[1]) == s])
                          for s in STRENGTHS), _last(kind, cases)])  # fmt: skip
    total = share(c["right"] for c in cases)
    title = f"{ASKED[kind]}: {total['count']} of {total['of']}, {percent(total['share'])}, "
    last = "channel named or noted" if kind == "none" else "without a spurious structural finding"
    return {
        "title": f"{title}95 % interval {between(total)}",
        "columns": ["Nuisance", *(f"right at {s:g}" for s in STRENGTHS), last],
        "rows": rows,
    }


def _about(how: Any) -> str:
    text = str(how.__doc__).rstrip(".")
    return text[0].lower() + text[1:]


def _right(cases: Sequence[Mapping[str, Any]]) -> str:
    return f"{sum(c['right'] for c in cases)} of {len(cases)}" if cases else "-"


def _last(kind: str, cases: Sequence[Mapping[str, Any]]) -> str:
    good = sum(c["noted"] if kind == "none" else not c["spurious"] for c in cases)
    return f"{good} of {len(cases)}"
