#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Writes the parameters into docs/node.md from their declarations; `--check`: are they current?"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs/node.md"
FIRST = "<!-- parameters: written by tools/parameter_section.py, do not edit -->"
LAST = "<!-- end of parameters -->"

sys.path.insert(0, str(ROOT))
from cpr_ros.parameter_table import PARAMETERS  # noqa: E402  this tree's, installed or not


def section() -> str:
    """The table of all parameters."""
    lines = [
        FIRST,
        "| name | type | unit | values | default | changes | |",
        "|---|---|---|---|---|---|---|",
    ]
    for parameter in PARAMETERS:
        cells = (
            f"`{parameter.name}`",
            parameter.kind,
            parameter.unit,
            parameter.values,
            f"`{parameter.default_text}`",
            "live" if parameter.live else "read-only",
            parameter.meaning.replace("|", r"\|"),
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, LAST])


def page() -> str:
    """The page with the table put in."""
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(FIRST)
    _, found, tail = rest.partition(LAST)
    if not found:
        raise SystemExit(f"docs/node.md has no place for the parameters: {FIRST} ... {LAST}")
    return f"{head}{section()}{tail}"


def main() -> int:
    """Write the table, or check it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    wanted = page()
    if not options.check:
        PAGE.write_text(wanted, encoding="utf-8")
        return 0
    current = PAGE.read_text(encoding="utf-8") == wanted
    if not current:
        print("docs/node.md is not current: run tools/parameter_section.py", file=sys.stderr)
    return 0 if current else 1


if __name__ == "__main__":
    sys.exit(main())
