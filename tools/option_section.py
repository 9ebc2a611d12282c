#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Writes the options of all commands into docs/command_line.md from their parsers; `--check`: current?

A help text ends with its default: ``; default %(default)s``, or ``; else ...`` what is done without it.
"""

from __future__ import annotations

import argparse
import sys

from marked_section import ROOT, keep_current, row

sys.path.insert(0, str(ROOT))
from cpr_core.command_line.command import command_parser

_DEFAULT = "; default %(default)s"
#: Commands that have a row, its meaning and its default.
Shared = dict[tuple[str, str, str], list[str]]


def section() -> str:
    """What most commands have, then every command with what is its own."""
    subparsers = next(
        action for action in command_parser()._actions if isinstance(action.choices, dict)
    )
    commands: dict[str, argparse.ArgumentParser] = dict(subparsers.choices or {})
    shared: Shared = {}
    for name, parser in commands.items():
        for action in _arguments(parser):
            shared.setdefault(_cells(action), []).append(name)
    common = {cells: names for cells, names in shared.items() if 2 * len(names) > len(commands)}
    lines = ["### Most commands", "", row("option", "meaning", "default", "not of")]
    lines.append("|---|---|---|---|")
    for cells, names in common.items():
        lines.append(row(*cells, ", ".join(f"`{name}`" for name in commands if name not in names)))
    for name, parser in commands.items():
        own = [cells for cells in map(_cells, _arguments(parser)) if cells not in common]
        lines += ["", f"### `cpr {name}`", "", parser.description or ""]
        if own:
            lines += ["", row("option", "meaning", "default"), "|---|---|---|"]
            lines += [row(*cells) for cells in own]
    return "\n".join(lines)


def _arguments(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """Positional arguments and options, but for help."""
    return [action for action in parser._actions if action.dest != "help"]


def _cells(action: argparse.Action) -> tuple[str, str, str]:
    """How an argument is given, what it means, and what is done without it.

    Raises:
        ValueError: The help text does not tell of the default there is.
    """
    meaning = action.help or ""
    if action.required:
        default = "required"
    elif action.default is not None and action.default is not False and action.default != []:
        meaning, told, rest = meaning.partition(_DEFAULT)
        if not told or rest:
            raise ValueError(f"{action.option_strings}: the help does not end with {_DEFAULT!r}")
        default = f"`{action.default}`"
    else:
        meaning, _, default = meaning.partition("; else ")
    return f"`{_given(action)}`", meaning, default


def _given(action: argparse.Action) -> str:
    """An argument as it is written on the command line."""
    values = action.metavar or ("|".join(action.choices) if action.choices else "")
    shown = " ".join(values) if isinstance(values, tuple) else values
    shown += " ..." if action.nargs == "+" else ""
    return " ".join([*action.option_strings, *([shown] if shown else [])])


if __name__ == "__main__":
    sys.exit(keep_current("option_section.py", "docs/command_line.md", "options", section))
