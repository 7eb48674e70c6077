"""The table of the real recordings is printed of what is kept of them."""

import json

from rich.console import Console

from experiments.real_diagnosis import RESULTS, show


def test_what_was_kept_is_shown():
    kept = json.loads(RESULTS.read_text())
    console = Console(width=200, record=True)
    show(console, kept)
    shown = console.export_text()
    held = kept["bncs"]["LAC100"]
    (row,) = (line for line in shown.splitlines() if "BNCS, LAC100" in line)
    for cell in (held["found"], f"{held['calibrated linear twin']:.3g}",
                 f"{held['explained twin']:.3g}"):  # fmt: skip
        assert cell in row
