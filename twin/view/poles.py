"""The stabilisation diagram drawn, and chosen from with the mouse."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twin.errors import TwinError
from twin.identification.pole_diagram import PoleDiagram
from twin.identification.stabilisation import FREQUENCY_TOLERANCE, StablePole
from twin.view.colours import FORCE, FRAME, IDENTIFIED, LOCATED, MEASURED, REJECTED, TRUE

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

REACH_PX = 12.0
"""How far from a pole a click may fall [pixel]: half a finger's or a large pointer's width."""

KINDS = (
    ("new in this order", frozenset[str](), REJECTED, "x"),
    ("frequency stable", frozenset(("frequency",)), FORCE, "v"),
    ("frequency and shape stable", frozenset(("frequency", "shape")), LOCATED, "^"),
    ("frequency and damping stable", frozenset(("frequency", "damping")), MEASURED, "s"),
    ("all stable", frozenset(("frequency", "damping", "shape")), TRUE, "o"),
)
"""What a pole shares with the order before: name, what is stable, colour, marker."""

REFUSED = ("stable, but no mode by evidence", "#5C6670", "d")
"""Of poles that stay although nothing of what was measured needs them: name, colour, marker."""

SAME_COLUMN = 2 * FREQUENCY_TOLERANCE
"""How far the poles of one column lie apart, as a share of their frequency."""


def of_modes(poles: Sequence[StablePole], modes: Sequence[float] | Array) -> list[bool]:
    """Return which poles are stable in all and lie in the column of an identified mode.

    Noise has poles that stay, too, once the order is high enough: the evidence refuses them.
    """
    known = np.asarray(modes, float)
    return [
        p.stable and bool(np.any(np.abs(known / p.frequency_hz - 1) < SAME_COLUMN)) for p in poles
    ]


def kinds(
    poles: Sequence[StablePole], modes: Sequence[float] | Array = ()
) -> list[tuple[str, str, str, Array, Array]]:
    """Return name, colour, marker, frequencies [Hz] and orders of the kinds that are there.

    Args:
        poles: of all orders.
        modes: natural frequencies that were identified [Hz]; where there are some, what is stable
            elsewhere is a kind of its own.
    """
    near = of_modes(poles, modes) if len(modes) else [True] * len(poles)
    groups = [
        (name, colour, marker, [p for p, k in zip(poles, near, strict=True)
                                if p.steady == steady and (k or not p.stable)])
        for name, steady, colour, marker in KINDS
    ]  # fmt: skip
    groups.append((*REFUSED, [p for p, k in zip(poles, near, strict=True) if p.stable and not k]))
    found = []
    for name, colour, marker, mine in groups:
        if mine:
            freq = np.array([p.frequency_hz for p in mine])
            order = np.array([p.order for p in mine], float)
            found.append((name, colour, marker, freq, order))
    return found


def draw_poles(
    figure: Figure, diagram: PoleDiagram, modes: Sequence[float] | Array, top_hz: float
) -> Axes:
    """Draw the diagram into a figure: singular values behind, then poles, then modes.

    Args:
        figure: empty.
        diagram: what is drawn.
        modes: natural frequencies that a line marks [Hz].
        top_hz: end of the frequency axis [Hz].

    Returns:
        The axes of the poles.
    """
    behind = figure.subplots()
    for number, curve in enumerate(diagram.curves.T):
        positive = np.where(curve > 0, curve, np.nan)
        behind.semilogy(diagram.frequency_hz, positive, color=FRAME, lw=1.1 if not number else 0.6)
    behind.set_ylabel(f"singular values of the {diagram.of}", color="#6B7480")
    ax = behind.twinx()
    behind.yaxis.tick_right()
    behind.yaxis.set_label_position("right")
    ax.yaxis.tick_left()
    ax.yaxis.set_label_position("left")
    for name, colour, marker, freq, order in kinds(diagram.poles, modes):
        ax.plot(freq, order, marker, color=colour, ms=4, mew=0.9, label=name, ls="none")
    for r, f in enumerate(modes):
        label = "identified mode" if r == 0 else None
        ax.axvline(float(f), color=IDENTIFIED, lw=1.2, zorder=0, label=label)
    ax.set_xlim(0, 1.05 * top_hz)
    behind.set_xlabel("natural frequency [Hz]")
    ax.set_xlabel("natural frequency [Hz]")
    ax.set_ylabel("order of the model")
    ax.grid(alpha=0.3)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.13), ncols=4, frameon=False, fontsize=8)
    return ax


class PoleChoice:
    """Poles chosen by clicks in a stabilisation diagram; a second click takes one back.

    Args:
        figure: an empty figure that has a canvas.
        diagram: what is chosen from.
    """

    def __init__(self, figure: Figure, diagram: PoleDiagram) -> None:
        self.diagram = diagram
        self.figure = figure
        top = max((p.frequency_hz for p in diagram.poles), default=1.0)
        self.axes = draw_poles(figure, diagram, (), top / 1.05)
        self.axes.set_title("click on poles to choose them, close the window when done", pad=28)
        self.chosen: list[int] = []
        self._rings = self.axes.plot(
            [], [], "o", ms=11, mew=2, mfc="none", mec=IDENTIFIED, ls="none", zorder=5
        )[0]
        figure.canvas.mpl_connect("button_press_event", self.clicked)

    @property
    def poles(self) -> ComplexArray:
        """The chosen poles [rad/s], by frequency."""
        chosen = [self.diagram.poles[i].pole for i in self.chosen]
        return np.array(sorted(chosen, key=abs), complex)

    def clicked(self, event: Any) -> None:
        """Take the nearest pole, or give it back; not while the toolbar zooms or pans."""
        toolbar = getattr(self.figure.canvas, "toolbar", None)
        if event.inaxes is None or (toolbar is not None and str(getattr(toolbar, "mode", ""))):
            return
        at = np.array([(p.frequency_hz, p.order) for p in self.diagram.poles], float)
        if not len(at):
            return
        off = np.hypot(*(self.axes.transData.transform(at) - (event.x, event.y)).T)
        nearest = int(np.argmin(off))
        if off[nearest] > REACH_PX:
            return
        if nearest in self.chosen:
            self.chosen.remove(nearest)
        else:
            self.chosen.append(nearest)
        self._rings.set_data(at[self.chosen, 0], at[self.chosen, 1])
        self.figure.canvas.draw_idle()


def pick_by_hand(diagram: PoleDiagram) -> ComplexArray:
    """Open a window to choose poles in, and return them when it is closed [rad/s].

    Raises:
        TwinError: there is no screen to open a window on.
    """
    import matplotlib
    from matplotlib import pyplot

    name = str(matplotlib.get_backend()).lower()
    if name not in {b.lower() for b in interactive_backends()}:
        raise TwinError(
            f"--pick opens a window, and here is no screen (matplotlib draws with '{name}'): "
            "choose in the stabilisation diagram of identification.html, and give --poles"
        )
    figure = pyplot.figure(figsize=(12, 7), layout="constrained")
    choice = PoleChoice(figure, diagram)
    pyplot.show(block=True)
    return choice.poles


def interactive_backends() -> list[str]:
    """Return the names of matplotlib's backends that open windows."""
    from matplotlib.backends.registry import BackendFilter, backend_registry

    return backend_registry.list_builtin(BackendFilter.INTERACTIVE)
