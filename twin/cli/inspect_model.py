"""The half of ``twin inspect`` that is about models."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from twin.cli.common import console, write_json
from twin.model.inspection import ModelInspection


def inspect_model(name: str, json: str | None) -> None:
    """Print what a model offers and write it as JSON.

    Raises:
        ModelError: there is no such model, or it has no rest.
    """
    from twin.mechanisms import places, vocabulary
    from twin.model import Twin
    from twin.model.inspection import inspect

    twin = Twin.load(name)
    found = inspect(twin)
    channels = dict(found.outputs)
    sites = {
        name: places(cls, twin.linear(tuple(found.inputs), tuple(channels)), channels)
        for name, cls in vocabulary().items()
    }
    _print(console(json), found, sites)
    write_json(found.as_json() | {"mechanisms": sites}, json)


def _print(terminal: Console, found: ModelInspection, sites: dict[str, list[str]]) -> None:
    terminal.print(f"[bold]{escape(found.source)}[/bold]")
    channels = _table("channel", "of", "kind")
    for name, kind in found.inputs.items():
        channels.add_row(escape(name), "input", kind)
    for name, kind in found.outputs.items():
        channels.add_row(escape(name), "sensor", kind)
    terminal.print(channels)
    for name, why in found.left_aside.items():
        terminal.print(f"no input: {escape(name)}: {escape(why)}")
    ports = _table("port", "kind", "unit", "element")
    for port in found.linear.ports.values():
        ports.add_row(escape(port.name), port.kind, port.unit, escape(port.element))
    for name, body in found.linear.bodies.items():
        ports.add_row(escape(name), "body", "kg", f"{body.mass:.4g}")
    for name in found.linear.places("base"):
        ports.add_row(name, "base", "m", "")
    terminal.print(ports)
    modes = _table("mode", "Hz", "damping", "moves most")
    for number, mode in enumerate(found.modes, start=1):
        movers = ", ".join(f"{escape(name)} {share:.2f}" for name, share in mode.movers.items())
        rigid = mode.frequency_hz == 0
        damping = "rigid" if rigid else f"{mode.damping_ratio:.5f}"
        modes.add_row(str(number), f"{mode.frequency_hz:.4f}", damping, movers)
    terminal.print(modes)
    for element in found.nonlinear:
        known = f" ({element.mechanism})" if element.mechanism else " (no mechanism for it)"
        terminal.print(f"not linear: {escape(str(element))}{known}")
    alike: dict[tuple[str, ...], list[str]] = {}
    for name, where in sites.items():
        if where:
            alike.setdefault(tuple(where), []).append(name)
    mechanisms = _table("mechanisms", "can sit at")
    for spots, names in alike.items():
        mechanisms.add_row(", ".join(names), escape(", ".join(spots)))
    terminal.print(mechanisms)


def _table(*headers: str) -> Table:
    table = Table(box=SIMPLE_HEAD, show_edge=False)
    for header in headers:
        table.add_column(header, overflow="fold")
    return table
