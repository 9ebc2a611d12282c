# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A part of a page that a tool writes, between two marks; `--check`: is it current?"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

__all__ = ["ROOT", "keep_current", "row"]

ROOT = Path(__file__).parents[1]


def row(*cells: str) -> str:
    """A row of a table."""
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def keep_current(tool: str, page: str, name: str, section: Callable[[], str]) -> int:
    """Write a section into its page, or check it; returns the exit status.

    Args:
        tool: File of the tool, in tools/.
        page: The page, from the root of the project.
        name: What the marks call the section.
        section: Makes its text.
    """
    parser = argparse.ArgumentParser(description=f"Writes the {name} into {page}.")
    parser.add_argument("--check", action="store_true", help="only tell whether they are current")
    options = parser.parse_args()
    first = f"<!-- {name}: written by tools/{tool}, do not edit -->"
    last = f"<!-- end of {name} -->"
    path = ROOT / page
    text = path.read_text(encoding="utf-8")
    head, _, rest = text.partition(first)
    _, found, tail = rest.partition(last)
    if not found:
        raise SystemExit(f"{page} has no place for the {name}: {first} ... {last}")
    wanted = f"{head}{first}\n{section().strip()}\n{last}{tail}"
    if not options.check:
        path.write_text(wanted, encoding="utf-8")
    elif wanted != text:
        print(f"{page} is not current: run tools/{tool}", file=sys.stderr)
        return 1
    return 0
