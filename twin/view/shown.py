"""A Matplotlib figure that a notebook shows, whether or not pyplot was ever imported."""

from __future__ import annotations

import io

from matplotlib import figure

NOTEBOOK_DPI = 80


class Figure(figure.Figure):
    """A figure that knows its picture.

    A notebook knows Matplotlib's figures only once pyplot has been imported, which nothing here
    does: it would choose a window system.
    """

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, dpi=NOTEBOOK_DPI, format="png", bbox_inches="tight")
        return buffer.getvalue()
