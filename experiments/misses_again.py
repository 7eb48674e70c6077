"""Every miss of the sealed campaigns, and what foresaw worse, diagnosed again by this version.

    python experiments/misses_again.py FOLDER [--budget MINUTES] [--workers N]

These cases have been opened, and some were used to mend the tool: their second answers count
nowhere else. They tell which misses are left. Each case is made anew from its campaign's seed; what
is concealed, its noise and its effect over the noise must be those that were written down (the
SHA-256 of the first two campaigns covers nats that are reckoned otherwise since). FOLDER keeps what
is done; run it again to go on. Writes experiments/results/misses_again.json.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.steps import (  # noqa: E402
    Blind,
    Concealing,
    Opening,
    conceal,
    diagnose_blind,
    open_and_score,
)
from experiments.concealed.tables import case_name  # noqa: E402
from experiments.condense_campaign import row  # noqa: E402
from experiments.in_pieces import RESULTS, pieces  # noqa: E402
from twin.files import folder  # noqa: E402

RESULT = "misses_again"
TITLE = "misses diagnosed again"
SAYS = ("right", "found", "probability", "explained_over_calibrated_ahead", "ahead_not_worse")


@dataclass(frozen=True)
class Again:
    """A case that was opened.

    Attributes:
        name: campaign and case, "2/pairs_0005".
        table: of the case.
        seed: of its campaign.
        truth: what is kept of it.
        before: what was said of it.
    """

    name: str
    table: str
    seed: int
    truth: Mapping[str, Any]
    before: Mapping[str, Any]

    @property
    def number(self) -> int:
        """The case's, within its table."""
        return int(self.name.rpartition("_")[2])


def main() -> None:
    with pieces(__doc__, TITLE) as work:
        cases = work.done(diagnosed_again, tasks(), "cases")
        path = work.write({"made_with": work.made_with, "cases": cases}, RESULT)
    told = [c for c in cases if c["now"]]
    print(f"{len(told)} cases, {sum(c['now']['right'] for c in told)} right; {path}")


def tasks(source: Path = RESULTS / "concealed.json") -> list[Again]:
    """Return what is to be diagnosed again: what foresaw worse first, then the newest misses."""
    document = json.loads(source.read_text())
    seeds = [_seed(campaign["pieces"]) for campaign in document["campaigns"]]
    chosen = [r for r in document["rows"] if _worse(r) or not r["score"]["right"]]
    chosen.sort(key=lambda r: (not _worse(r), -_campaign(r), r["case"]))
    return [
        Again(r["case"], r["truth"]["table"], seeds[_campaign(r) - 1], r["truth"], _said(r))
        for r in chosen
    ]


def diagnosed_again(task: Again) -> dict[str, Any]:
    """Make a case anew, diagnose it blind, open and score it; nothing is said of another case."""
    case = case_name(task.number, task.table)
    with tempfile.TemporaryDirectory(prefix="twin-") as name:
        recordings, sealed = folder(Path(name) / "recordings"), folder(Path(name) / "sealed")
        made = conceal(Concealing(task.table, task.number, task.seed, recordings, sealed))
        kept = Path(name) / "diagnosis.json"
        diagnose_blind(Blind(recordings / case, made["model"], kept, (sealed,)))
        truth = sealed / f"{case}.json"
        result = open_and_score(Opening(truth, made["sha256"], recordings, kept))
    found = row(task.name, made["sha256"], result)
    same = found["truth"] == task.truth
    return {
        "case": task.name, "truth": dict(task.truth), "before": dict(task.before),
        "now": _said(found) if same else None,
    }  # fmt: skip


def _said(one: Mapping[str, Any]) -> dict[str, Any]:
    return {key: one["score"].get(key) for key in SAYS}


def _worse(one: Mapping[str, Any]) -> bool:
    return one["score"].get("ahead_not_worse") is False


def _campaign(one: Mapping[str, Any]) -> int:
    return int(one["case"].partition("/")[0])


def _seed(parts: list[Mapping[str, Any]]) -> int:
    """Return the seed of a campaign's command."""
    found = re.search(r"--seed (\d+)", parts[0]["command"])
    assert found is not None
    return int(found.group(1))


if __name__ == "__main__":
    main()
