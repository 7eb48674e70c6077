"""Writes the tables of README.md from the files in results/; no number there is typed by hand.

python benchmarks/report.py
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from identification_speed import GROUPS, size_label

FOLDER = Path(__file__).parent
TESTS = {
    "hammer": "hammer, whole instrument chain",
    "held": "hammer force held between samples",
    "floor": "random shaker on floor 1, whole instrument chain",
}


def table(header: list[str], rows: list[list[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def seconds(value: float) -> str:
    return f"{1e3 * value:.3g} ms" if value < 1 else f"{value:.3g} s"


def memory(value: float) -> str:
    return (
        "< 1 MiB"
        if value < 1
        else f"{value:.3g} MiB"
        if value < 1000
        else f"{value / 1024:.3g} GiB"
    )


def speed(rows: list[dict], group: str) -> str:
    """One line a size and method; ratios above 1 are in our favour."""
    lines = []
    for row in (r for r in rows if r["group"] == group):
        start = [size_label(group, row["size"]), row["method"]]
        if "skipped" in row:
            lines.append([*start, f"skipped: {row['skipped']}", "", "", ""])
            continue
        ours = row["method"] == GROUPS[group][0]
        lines.append(
            [
                *start,
                seconds(row["seconds"]),
                "" if ours else f"{row['time_ratio']:.3g}",
                memory(row["peak_mib"]),
                "" if ours else ratio_of_memory(row, rows),
            ]
        )
    return table(["size", "method", "time", "time / ours", "peak memory", "memory / ours"], lines)


def ratio_of_memory(row: dict, rows: list[dict]) -> str:
    same = [r for r in rows if r["group"] == row["group"] and r["size"] == row["size"]]
    ours = next(r for r in same if r["method"] == GROUPS[row["group"]][0])
    # Below a few MiB the allocator's granularity decides, and a ratio says nothing.
    return (
        f"{row['peak_mib'] / ours['peak_mib']:.3g}"
        if min(ours["peak_mib"], row["peak_mib"]) > 4
        else "-"
    )


def accuracy(result: dict) -> str:
    lines = [["*bound [%]*", *[f"{x:.2g}" for x in result["bound_percent"]], ""]]
    ranked = sorted(result["routes"].items(), key=lambda item: sum(item[1]["rmse_over_bound"]))
    for name, row in ranked:
        shown = [f"{x:.2f}" if x < 100 else f"{x:.1e}" for x in row["rmse_over_bound"]]
        lines.append([name, *shown, str(row["failed"] or "")])
    return table(["route", "f1", "f2", "zeta1", "zeta2", "failed"], lines)


def run_line(result: dict) -> str:
    named = ", ".join(f"{k} {v}" for k, v in result["versions"].items())
    return f"{result['machine']}; {named}."


def main() -> None:
    blocks = {}
    found = json.loads((FOLDER / "results" / "identification_speed.json").read_text())
    blocks["speed"] = "\n\n".join(
        [run_line(found), *(f"### {group}\n\n{speed(found['rows'], group)}" for group in GROUPS)]
    )
    found = json.loads((FOLDER / "results" / "identification_accuracy.json").read_text())
    blocks["accuracy"] = "\n\n".join(
        f"### {TESTS[test]} ({result['draws']} draws)\n\n{accuracy(result)}"
        for test, result in found["tests"].items()
    )
    fill(blocks)


def fill(blocks: dict[str, str]) -> None:
    """Put every block where README.md has a place for it.

    Raises:
        SystemExit: it has none.
    """
    readme = FOLDER / "README.md"
    text = readme.read_text()
    for name, block in blocks.items():
        pattern = rf"(<!-- {name} -->\n).*?(\n<!-- end of {name} -->)"
        text, hits = re.subn(
            pattern, lambda m, b=block: m[1] + "\n" + b + "\n" + m[2], text, flags=re.DOTALL
        )
        if hits != 1:
            raise SystemExit(f"README.md has no place for {name}")
    readme.write_text(text)


if __name__ == "__main__":
    main()
