"""Writes docs/cli.md: every command of the command line and its options, from the parser itself.

Run ``python docs/make_cli_reference.py`` after a change of a command.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from scara_drake.cli.parser import make_parser

PAGE = Path(__file__).with_name("cli.md")
HEAD = """# Command line

Every command of `scara-drake` and its options, as `--help` after a command says them. This page is
made by `python docs/make_cli_reference.py` from the parser. What the exit statuses mean is in the
[README](../README.md#command-line).
"""


def actions(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Return the arguments of a parser, but for its help and its commands."""
    left_out = (argparse._HelpAction, argparse._SubParsersAction)
    return [each for each in parser._actions if not isinstance(each, left_out)]


def commands() -> Iterator[tuple[str, str, argparse.ArgumentParser]]:
    """Yield each command with its line of help and its parser."""
    (group,) = [
        each for each in make_parser()._actions if isinstance(each, argparse._SubParsersAction)
    ]
    for choice in group._choices_actions:
        yield choice.dest, choice.help or "", group.choices[choice.dest]


def row(action: argparse.Action, formatter: argparse.HelpFormatter) -> str:
    """Return the line of an argument: how it is written, and what it does."""
    value = "" if action.nargs == 0 else formatter._format_args(action, action.dest.upper())
    name = ", ".join(action.option_strings)
    written = " ".join(part for part in (name, value) if part)
    told = formatter._expand_help(action) if action.help else ""
    cells = [f"`{written}`", told]
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def table(parser: argparse.ArgumentParser) -> str:
    """Return the arguments of a parser as a table."""
    formatter = parser._get_formatter()
    rows = [row(each, formatter) for each in actions(parser)]
    return "\n".join(["| argument | what it does |", "|---|---|", *rows]) + "\n"


def section(name: str, told: str, parser: argparse.ArgumentParser) -> str:
    """Return what a command does, how it is called, and its arguments."""
    does = (parser.description or told).rstrip(".")
    parts = [f"## {name}\n", f"{does[0].upper()}{does[1:]}.\n"]
    if actions(parser):
        parts.append(table(parser))
    if parser.epilog:
        parts.append(f"```text\n{parser.epilog.strip()}\n```\n")
    return "\n".join(parts)


def page() -> str:
    """Return the whole page."""
    every = f"## Before every command\n\n{table(make_parser())}"
    return "\n".join([HEAD, every, *(section(*command) for command in commands())])


if __name__ == "__main__":
    PAGE.write_text(page())
