"""A report as the text of one HTML file, plotly's script inside."""

from __future__ import annotations

import base64
import gzip
import json
from functools import lru_cache
from importlib import resources
from pathlib import Path

import jinja2

from twin.files import write_whole
from twin.view.page.blocks import Page, Plot


def write_page(page: Page, path: Path) -> Path:
    """Write a report whole or not at all."""
    html = render(page)
    return write_whole(path, lambda part: part.write_text(html, encoding="utf-8"))


def render(page: Page) -> str:
    """Return a report as HTML that fetches nothing from a network."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("twin.view", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["figure"] = figure_text
    drawn = any(isinstance(block, Plot) for section in page.sections for block in section.blocks)
    return environment.get_template("report.html").render(
        page=page, style=_file("report.css"), behaviour=_file("report.js"),
        library=packed_library() if drawn else "",
    )  # fmt: skip


def figure_text(plot: Plot) -> str:
    """Return a figure as JSON that cannot end the script element it stands in."""
    text = json.dumps(plot.figure, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


@lru_cache(maxsize=1)
def packed_library() -> str:
    """Return plotly's script, compressed to a third, as base64; the page unpacks it."""
    script = resources.files("plotly").joinpath("package_data/plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(script, 9, mtime=0)).decode()


def _file(name: str) -> str:
    return resources.files("twin.view").joinpath(f"templates/{name}").read_text(encoding="utf-8")
