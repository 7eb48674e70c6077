"""Make the pictures of the README from a fresh demo.

    python experiments/readme_pictures.py docs

Needs a Vulkan driver for the headless viewer (Debian: mesa-vulkan-drivers); without one only the
figures are made, and that is said.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from twin.cli.demo import demo
from twin.errors import TwinError
from twin.files import write_whole
from twin.view.screenshot import screenshot

SHOWN_AT_S = 2.0
FIGURES = ("frequency_responses", "mode_shapes", "stabilisation")


def main() -> None:
    docs = Path(sys.argv[1] if len(sys.argv) > 1 else "docs")
    with tempfile.TemporaryDirectory() as name:
        made = Path(name)
        demo(out=made, seed=0, json=None)
        for figure in FIGURES:
            content = (made / f"{figure}.png").read_bytes()
            write_whole(docs / f"{figure}.png", lambda part, c=content: part.write_bytes(c))
        try:
            screenshot(made / "identification.rrd", docs / "viewer.png", SHOWN_AT_S)
        except TwinError as error:
            print(f"no picture of the viewer: {error}")


if __name__ == "__main__":
    main()
