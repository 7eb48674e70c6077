"""The section of the proof's page about drawings that are off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from experiments.concealed.pictures import between, percent
from experiments.concealed.shares import share

TEXT = (
    "Simulated rigs diagnosed with a drawing whose masses and stiffnesses are off by normal "
    "deviates of 1, 3, 10 or 30 %, its damping ratios by 10 %; one effect of the vocabulary is "
    "concealed, or nothing. What nothing tells from such a drawing is not asked: a mass or a "
    "stiffness from 3 % on, with unknown numbers a damping and a gain besides."
)
COMMAND = (
    "python -m experiments.drawings --cases 15 --none 5 [--unsaid] "
    "--to experiments/results/drawings.json"
)
KINDS = {
    "said": "The diagnosis is told how well the drawing is known",
    "unsaid": "The diagnosis is told nothing",
}


def tolerances(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the section, a table for each kind that was run."""
    tables = [_table(title, list(given[kind].values())) for kind, title in KINDS.items()
              if kind in given]  # fmt: skip
    commit = given.get("versions", {}).get("commit")
    text = f"{TEXT} All with one engine, commit {commit}." if commit else TEXT
    return {"text": text, "command": COMMAND, "tables": tables}


def _table(title: str, cases: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    rows = []
    for known in dict.fromkeys(c["known"] for c in cases):
        own = [c for c in cases if c["known"] == known]
        hidden = [c for c in own if c["concealed"]]
        quiet = [c for c in own if not c["concealed"]]
        of = share(c["right"] for c in hidden)
        alone = sum(c["right"] and c["said"] == c["concealed"] for c in hidden)
        rows.append([
            known, f"{of['count']} of {of['of']}", percent(of["share"]), between(of),
            f"{alone} of {len(hidden)}", f"{sum(c['right'] for c in quiet)} of {len(quiet)}",
        ])  # fmt: skip
    return {
        "title": title,
        "columns": ["Drawing known to", "mechanism and place first", "share", "95 % interval",
                    "and nothing else named", "nothing concealed, nothing found"],
        "rows": rows,
    }  # fmt: skip
