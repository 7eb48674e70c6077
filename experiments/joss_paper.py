"""Write docs/paper.md, a draft for the Journal of Open Source Software, from the results.

    python experiments/joss_paper.py [--docs DIR]

The words stand in ``templates/paper.md.j2``; every number comes from ``experiments/results/``,
``benchmarks/results/`` or the package itself.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from experiments.concealed.summary import summarise  # noqa: E402
from twin.files import write_whole  # noqa: E402

TEMPLATE = "paper.md.j2"
OURS, PAPER, CONTROL = (
    "twin identify",
    "twin OKID/ERA as in the paper, p = 20",
    "python-control markov + ERA, m = 800",
)
"""Routes of the accuracy benchmark that the table has."""

TABLES = {
    "single": "one effect: mechanism and place named first",
    "none": "nothing hidden: nothing found",
    "absorbed": "an effect that calibration can swallow",
    "pairs": "two effects at once: both found",
    "outside": "a law outside the vocabulary: said to be so, at its place",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--docs", type=Path, default=ROOT / "docs")
    print(write_paper(parser.parse_args().docs))


def write_paper(docs: Path) -> Path:
    """Write the draft; return its path."""
    text = paper()
    return write_whole(docs / "paper.md", lambda part: part.write_text(text, encoding="utf-8"))


def paper() -> str:
    """Return the draft as Markdown."""
    environment = Environment(
        loader=FileSystemLoader(ROOT / "experiments" / "templates"), undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True, autoescape=False,
    )  # fmt: skip
    return environment.get_template(TEMPLATE).render(**numbers())


def numbers() -> dict[str, Any]:
    """Return every number of the draft under the name that the template gives it."""
    from twin import __version__
    from twin.formats import FORMATS
    from twin.mechanisms import vocabulary

    kinds = [kind.on for kind in vocabulary().values()]
    channels = sum(on in ("channel", "channels") for on in kinds)
    return {
        "version": __version__,
        "formats": len(set(FORMATS.values())),
        "mechanisms": len(kinds) - channels,
        "instruments": channels,
        "concealed": _concealed(_results("concealed")),
        "accuracy": _accuracy(_benchmark("identification_accuracy")["tests"]["hammer"]),
        "step_us": f"{_benchmark('control_speed')['force_ground']['c_step_us']:.2g}",
        "silverbox": _silverbox(_results("real")["silverbox"]),
        "bouc_wen": _bouc_wen(_results("real")["bouc_wen"]),
    }


def cited() -> set[str]:
    """Return the keys of the references that the template cites."""
    text = (ROOT / "experiments" / "templates" / TEMPLATE).read_text(encoding="utf-8")
    return set(re.findall(r"@([a-z]+\d{4}\w*)", text))


def _results(name: str) -> Any:
    return json.loads((ROOT / "experiments" / "results" / f"{name}.json").read_text())


def _benchmark(name: str) -> Any:
    return json.loads((ROOT / "benchmarks" / "results" / f"{name}.json").read_text())


def _concealed(document: Mapping[str, Any]) -> dict[str, Any]:
    summary = summarise({row["case"]: row for row in document["rows"]})
    rows = []
    for name, asked in TABLES.items():
        right = summary["tables"][name]["right"]
        share, low, high = (f"{100 * right[k]:.1f}" for k in ("share", "low", "high"))
        rows.append((asked, right["of"], right["count"], f"{share} ({low} to {high})"))
    surest = summary["calibration"][-1]
    return {
        "cases": len(document["rows"]),
        "rows": rows,
        "stated": f"{surest['from']:.2f}",
        "kept": f"{100 * surest['right']['share']:.1f}",
        "of": surest["right"]["of"],
        "seconds": f"{summary['tables']['single']['seconds']:.0f}",
    }


def _accuracy(test: Mapping[str, Any]) -> dict[str, Any]:
    labels = {
        OURS: "`twin identify`", PAPER: "OKID/ERA, p = 20 [@juang1993; @juang1985]",
        CONTROL: "python-control, Markov parameters and ERA",
    }  # fmt: skip
    rows = [
        (label, *(f"{value:.2f}" for value in test["routes"][route]["rmse_over_bound"]))
        for route, label in labels.items()
    ]
    return {"draws": test["draws"], "rows": rows}


def _silverbox(result: Mapping[str, Any]) -> dict[str, Any]:
    errors = result["error_mV"]
    published = result["published_error_mV"]
    return {
        "first": result["findings"][0]["mechanism"].replace("_", " "),
        "before": f"{errors['calibrated']:.3g}",
        "after": f"{errors['explained']:.2g}",
        "linear": f"{published['best linear model']:.3g}",
        "best": f"{min(published.values()):.2g}",
    }


def _bouc_wen(result: Mapping[str, Any]) -> dict[str, Any]:
    errors = result["rms_error_m"]["test_multisine.csv"]
    published = result["published_rms_error_m"]
    return {
        "first": result["findings"][0]["mechanism"].replace("_", " "),
        "after": f"{1e6 * errors['explained']:.2g}",
        "best": f"{1e6 * min(published.values()):.2g}",
    }


if __name__ == "__main__":
    main()
