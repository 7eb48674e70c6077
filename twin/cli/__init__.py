"""The command ``twin``: one file a command, errors as one line, exit codes 0 and 2."""

from __future__ import annotations

import sys
from importlib import import_module

import click
import typer

from twin.errors import TwinError

COMMANDS = ("demo", "test", "identify", "paper", "convert", "view")
"""Modules of this package that hold one command each (or a group, as ``test`` does)."""


def build() -> typer.Typer:
    """Assemble the application from the command modules."""
    app = typer.Typer(
        name="twin",
        help="A digital twin of a laboratory frame: test it, identify it, look at it.",
        no_args_is_help=True,
        add_completion=False,
        rich_markup_mode="markdown",
        pretty_exceptions_enable=False,
    )
    for name in COMMANDS:
        import_module(f"twin.cli.{name}").register(app)
    return app


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; bad input ends with one line on standard error and exit code 2."""
    try:
        code = build()(args=arguments, standalone_mode=False)
    except (TwinError, click.ClickException) as error:
        text = error.format_message() if isinstance(error, click.ClickException) else str(error)
        sys.stderr.write(f"twin: {' '.join(text.split())}\n")
        sys.exit(2)
    except click.exceptions.Exit as stop:
        sys.exit(stop.exit_code)
    except (KeyboardInterrupt, click.Abort):
        sys.stderr.write("twin: interrupted\n")
        sys.exit(130)
    sys.exit(code if isinstance(code, int) else 0)
