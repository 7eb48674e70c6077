"""The examples of the help: options that there are, and files that another example makes."""

import re
import shlex
from pathlib import Path

import pytest
import typer

from twin.cli import build, main

MADE_BY_DEMO = "twin-demo/identification.rrd"


def commands(group, path=()):
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, (*path, name))
        else:
            yield (*path, name), command


APP = typer.main.get_command(build())
COMMANDS = dict(commands(APP))


def examples(command):
    text = f"{command.help or ''}\n\n{command.epilog or ''}"
    found = re.findall(r"Example:\s+`?(twin .*?)`?(?:\n\n|\Z)", text, re.S)
    return [shlex.split(example.split("|")[0]) for example in found]


def test_every_command_has_an_example():
    assert {"identify", "diagnose", "control", "view"} <= {path[0] for path in COMMANDS}
    assert all(examples(command) for command in COMMANDS.values())


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_every_example_is_understood(path):
    from twin.cli.arguments import expanded

    for _, *words in examples(COMMANDS[path]):
        assert tuple(words[: len(path)]) == path
        words = [word.replace("*", "hammer_floor1_01") for word in words]
        rest = expanded(words)[len(path) :]
        COMMANDS[path].make_context(" ".join(path), rest)


def test_a_pattern_of_an_example_is_shown_as_it_is(capsys):
    with pytest.raises(SystemExit):
        main(["identify", "--help"])
    assert "hits/*.csv" in capsys.readouterr().out


def test_every_file_of_an_example_is_made_by_another(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = examples(COMMANDS["test", "hammer"])[0]
    with pytest.raises(SystemExit) as stop:
        main(made[1:])
    assert stop.value.code == 0
    for path, command in COMMANDS.items():
        for _, *words in examples(command):
            for word in words:
                if Path(word).suffix in (".csv", ".rrd") and word != MADE_BY_DEMO:
                    assert list(tmp_path.glob(word)), f"{' '.join(path)}: {word}"
    (convert,) = examples(COMMANDS["convert",])
    with pytest.raises(SystemExit) as stop:
        main(convert[1:])
    assert stop.value.code == 0
