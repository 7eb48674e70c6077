"""Condense the folders of concealed campaigns into one small file that the proof page is made from.

    python experiments/condense_campaign.py FOLDER [FOLDER ...] [--after FILE] [--to FILE]

Each folder is what ``twin concealed --out FOLDER`` leaves. The file holds, for each campaign, the
pieces of its manifest (command, versions, commit) and, for each case, the SHA-256 of its truth,
what was concealed, what was named, and the score: whoever runs the commands again, can compare.
--after takes over, unchanged, the campaigns that such a file holds already.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.score import effects_of, score  # noqa: E402
from experiments.concealed.seal import MANIFEST, read_manifest  # noqa: E402
from experiments.concealed.summary import table_of  # noqa: E402
from twin.errors import TwinError  # noqa: E402
from twin.files import write_whole  # noqa: E402

TARGET = ROOT / "experiments" / "results" / "concealed.json"
DIGITS = 5
LEFT_OUT = ("parameter_errors",)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--after", type=Path, help="a file that holds earlier campaigns")
    parser.add_argument("--to", type=Path, default=TARGET)
    given = parser.parse_args()
    try:
        document = condensed(given.folders, given.after)
    except TwinError as error:
        sys.exit(str(error))
    write_whole(given.to, lambda part: part.write_text(as_text(document)))
    print(f"{len(document['rows'])} cases of {len(document['campaigns'])} campaigns: {given.to}")


def condensed(folders: list[Path], after: Path | None = None) -> dict[str, Any]:
    """Return campaigns and rows; a row has ``case``, ``truth``, ``diagnosis`` and ``score``.

    Raises:
        TwinError: a folder holds no campaign, ``after`` none of several, or one again.
    """
    campaigns, rows = _earlier(after) if after is not None else ([], [])
    several = len(campaigns) + len(folders) > 1
    for number, folder in enumerate(folders, len(campaigns) + 1):
        manifest = _manifest(folder)
        if manifest["pieces"] in [c["pieces"] for c in campaigns if c["pieces"]]:
            raise TwinError(f"{folder}: the same campaign is there already")
        results = _results(folder / "results.jsonl")
        prefix = f"{number}/" if several else ""
        rows += [
            row(prefix + name, manifest["sha256"].get(name), result)
            for name, result in sorted(results.items())
        ]
        used = [r["diagnosis"]["made_with"] for r in results.values() if _made_with(r)]
        campaigns.append(
            {
                "pieces": manifest["pieces"],
                "concealed": len(manifest["sha256"]),
                "diagnosed": len(results),
                "diagnosed_with": [dict(one) for one in sorted({tuple(u.items()) for u in used})],
            }
        )
    return {"campaigns": campaigns, "rows": rows}


def row(name: str, digest: str | None, result: dict[str, Any]) -> dict[str, Any]:
    """Return what is kept of a case; the score is computed anew, as the rules now are."""
    truth, diagnosis = result["truth"], result["diagnosis"]
    found = score(truth, diagnosis, result["reference"])
    effects = [{key: e[key] for key in ("mechanism", "location")} for e in effects_of(truth)]
    said = {key: diagnosis[key] for key in ("verdict", "error") if key in diagnosis}
    kept = {
        "case": name,
        "sha256": digest,
        "truth": {
            "table": table_of(truth),
            "effects": effects,
            "noise": truth["noise"],
            "effect_over_noise": truth["effect_over_noise"],
        },
        "diagnosis": said,
        "score": {key: value for key, value in found.items() if key not in LEFT_OUT},
    }
    return _rounded(kept)


def as_text(document: dict[str, Any]) -> str:
    """Return the JSON with a line for each case, so that two campaigns can be compared."""
    rows = ",\n".join(json.dumps(row, allow_nan=False) for row in document["rows"])
    campaigns = json.dumps(document["campaigns"], indent=1, allow_nan=False)
    return f'{{"campaigns": {campaigns},\n"rows": [\n{rows}\n]}}\n'


def _earlier(path: Path) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    try:
        kept = json.loads(path.read_text())
        campaigns, rows = kept["campaigns"], kept["rows"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise TwinError(f"{path}: cannot read these campaigns ({error})") from None
    if any("/" not in row["case"] for row in rows):
        raise TwinError(f"{path}: its cases do not say which campaign they are of")
    return campaigns, rows


def _made_with(result: dict[str, Any]) -> bool:
    return bool(result["diagnosis"].get("made_with"))


def _manifest(folder: Path) -> dict[str, Any]:
    try:
        return read_manifest(folder / "sealed")
    except TwinError:
        path = folder / "sealed" / MANIFEST
        if not path.exists():
            raise
        # campaigns of earlier versions kept the SHA-256 alone
        return {"pieces": [], "sha256": json.loads(path.read_text())}


def _results(path: Path) -> dict[str, dict[str, Any]]:
    try:
        lines = path.read_text().splitlines()
        entries = [json.loads(line) for line in lines[1:]]
    except (OSError, ValueError) as error:
        raise TwinError(f"{path}: cannot read these results ({error})") from None
    return {entry["name"]: entry["result"] for entry in entries}


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {key: _rounded(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_rounded(one) for one in value]
    return value


if __name__ == "__main__":
    main()
