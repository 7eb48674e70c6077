"""The command line as a shell hands it over: options that take several files at once."""

from __future__ import annotations

from collections.abc import Sequence
from glob import glob
from pathlib import Path

from twin.errors import TwinError

SEVERAL = {"diagnose": ("--train", "--test"), "identify": ("--test",)}
"""Options, by command, that take every value up to the next option."""

PATTERN = "*?["


def expanded(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with "--train a b" as "--train a --train b", patterns spelt out.

    The model of ``twin diagnose`` may stand before the options or last of all; the recordings of
    ``twin identify`` stand before ``--test`` or behind its one value, as ever.

    Raises:
        TwinError: a pattern that no file matches.
    """
    arguments = list(arguments)
    options = SEVERAL.get(arguments[0], ()) if arguments else ()
    if not options:
        return arguments
    out, position, placed = arguments[:1], 1, False
    while position < len(arguments):
        argument = arguments[position]
        if argument not in options:
            if not argument.startswith("-"):
                placed = True
            elif "=" not in argument and _valued(argument) and position + 1 < len(arguments):
                out.append(argument)
                position += 1
                argument = arguments[position]
            out += _files(argument) if arguments[0] == "identify" else [argument]
            position += 1
            continue
        end = position + 1
        while end < len(arguments) and not arguments[end].startswith("-"):
            end += 1
        values = arguments[position + 1 : end]
        rest: list[str] = []
        last = not _more(arguments[end:], options)
        if not placed and arguments[0] == "identify":
            values, rest = values[:1], values[1:]
        elif not placed and last and len(values) > 1:
            values, rest = values[:-1], values[-1:]
        files = [file for value in values for file in _files(value)]
        out += [part for file in files for part in (argument, file)] or [argument]
        out += rest
        placed = placed or bool(rest)
        position = end
    return out


def _more(arguments: Sequence[str], options: Sequence[str]) -> bool:
    """Return whether another option of files, or a value of none, follows."""
    position = 0
    while position < len(arguments):
        argument = arguments[position]
        if argument in options or not argument.startswith("-"):
            return True
        position += 2 if "=" not in argument and _valued(argument) else 1
    return False


def _valued(option: str) -> bool:
    """Return whether an option is followed by a value that is no recording."""
    return option not in ("--unknown-parameters", "--help", "-h", "--rerun", "--band")


def _files(value: str) -> list[str]:
    """Return the files that a pattern names, where the shell has not spelt it out."""
    if not any(mark in value for mark in PATTERN) or Path(value).exists() or value.startswith("-"):
        return [value]
    found = sorted(glob(value, recursive=True))
    if not found and not any(mark in value for mark in "=["):
        raise TwinError(f"{value}: no file matches this pattern")
    return found or [value]
