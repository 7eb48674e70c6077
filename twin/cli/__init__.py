"""The command ``twin``: one file a command, errors as one line, exit codes 0 and 2."""

from __future__ import annotations

import signal
import sys
import warnings
from importlib import import_module
from typing import Annotated, NoReturn

import typer

from twin.cli.arguments import expanded
from twin.cli.common import remember
from twin.errors import TwinError
from twin.files import forget, replaced

COMMANDS = (
    "demo",
    "test",
    "identify",
    "concealed",
    "rehearse",
    "paper",
    "control",
    "tune",
    "diagnose",
    "convert",
    "fetch",
    "inspect",
    "view",
)
"""Modules of this package that hold one command each (or a group, as ``test`` does)."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""

# typer stands on click or carries a copy of its own: catch what it raises itself
_USAGE_ERROR: type[Exception] = next(
    kind
    for kind in typer.BadParameter.__mro__
    if kind.__name__ == "ClickException" and issubclass(kind, Exception)
)


def build() -> typer.Typer:
    """Assemble the application from the command modules."""
    app = typer.Typer(
        name="twin",
        help="A digital twin of a laboratory structure: test, identify, diagnose, control.",
        no_args_is_help=True,
        rich_markup_mode="markdown",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_about)
    for name in COMMANDS:
        import_module(f"twin.cli.{name}").register(app)
    return app


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; bad input ends with one line on standard error and exit code 2."""
    # A number that overflows ends in an error of ours or not at all; NumPy's remark is noise.
    warnings.filterwarnings("ignore", category=RuntimeWarning)
    signal.signal(signal.SIGTERM, _stopped)
    forget()
    try:
        given = expanded(sys.argv[1:] if arguments is None else arguments)
        remember(given)
        code = build()(args=given, prog_name="twin", standalone_mode=False)
    except TwinError as error:
        _refuse(str(error))
    except typer.Exit as stop:
        # typer makes an Exit of an interruption
        _interrupted() if stop.exit_code == INTERRUPTED else sys.exit(stop.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        _interrupted()
    except _USAGE_ERROR as error:
        # without arguments the help has been shown and there is no message
        message = getattr(error, "format_message", error.__str__)()
        if message.strip():
            _refuse(message)
        sys.exit(0)
    if code == INTERRUPTED:
        _interrupted()
    if replaced():
        sys.stderr.write(f"twin: replaced {', '.join(replaced())}\n")
    sys.exit(code if isinstance(code, int) else 0)


def _version(wanted: bool) -> None:
    if wanted:
        from twin import __version__

        typer.echo(f"twin {__version__}")
        raise typer.Exit


def _about(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """A digital twin of a laboratory structure: test, identify, diagnose, control."""
    del version  # its callback has printed it


def _interrupted() -> NoReturn:
    sys.stderr.write("twin: interrupted\n")
    sys.exit(INTERRUPTED)


def _stopped(*_: object) -> NoReturn:
    """End as by an exception, so that no part of a file is left behind."""
    sys.exit(143)


def _refuse(message: str) -> NoReturn:
    sys.stderr.write(f"twin: {' '.join(message.split())}\n")
    sys.exit(2)
