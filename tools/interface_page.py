#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Writes docs/interface.md from the .msg, .srv and .action files; `--check`: is it current?"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs/interface.md"
SECTIONS = {"msg": ("",), "srv": ("Request", "Answer"), "action": ("Goal", "Result", "Feedback")}
HEAD = """# Interfaces

Generated from [msg_defs](../msg_defs) by `tools/interface_page.py`; do not edit. What the node does with
them: [node.md](node.md). A field without a default is 0, false or empty in a new message.
"""


@dataclass
class Part:
    """One part of an interface: a message, or the request of a service."""

    lines: list[str] = field(default_factory=list)
    fields: list[list[str]] = field(default_factory=list)
    constants: list[list[str]] = field(default_factory=list)


def parsed(text: str, parts: int) -> tuple[str, list[Part]]:
    """What a file says about itself, and its parts."""
    about: list[str] = []
    found = [Part() for _ in range(parts)]
    part, last = 0, None
    for line in text.splitlines():
        if line.strip() == "---":
            part, last = part + 1, None
            continue
        content, _, comment = (text.strip() for text in line.partition("#"))
        if not content:
            if comment and last is not None:
                last[-1] = f"{last[-1]} {comment}"  # a comment that goes on
            elif comment and not found[part].fields and not part:
                about.append(comment)
            else:
                last = None
            continue
        kind, rest = content.split(maxsplit=1)
        constant = re.fullmatch(r"([A-Z]\w*)\s*=\s*(.+)", rest)
        if constant:
            last = [constant[1], constant[2], comment]
            found[part].constants.append(last)
        else:
            name, _, default = rest.partition(" ")
            last = [name, kind, default, comment]
            found[part].fields.append(last)
    return " ".join(about), found


def table(head: tuple[str, ...], rows: list[list[str]]) -> list[str]:
    """Rows as a table; all columns are code but the last, and those that nobody fills are left out."""
    kept = [column for column in range(len(head)) if any(row[column] for row in rows)]
    lines = ["", f"| {' | '.join(head[column] for column in kept)} |", "|---" * len(kept) + "|"]
    for row in rows:
        *codes, comment = (row[column] for column in kept)
        shown = [f"`{code}`" if code else "" for code in codes] + [comment.replace("|", r"\|")]
        lines.append(f"| {' | '.join(shown)} |")
    return lines


def page() -> str:
    """The whole page."""
    lines = [HEAD.rstrip()]
    for kind, parts in SECTIONS.items():
        for path in sorted((ROOT / "msg_defs" / kind).glob(f"*.{kind}")):
            about, found = parsed(path.read_text(encoding="utf-8"), len(parts))
            lines += ["", f"## cpr_msgs/{kind}/{path.stem}", "", about]
            for name, part in zip(parts, found, strict=True):
                if name:
                    lines += ["", f"### {name}"]
                if part.fields:
                    lines += table(("field", "type", "default", "meaning"), part.fields)
                elif name:
                    lines += ["", "Empty."]
                if part.constants:
                    lines += table(("constant", "value", "meaning"), part.constants)
    return "\n".join(lines) + "\n"


def main() -> int:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    wanted = page()
    if options.check:
        current = PAGE.is_file() and PAGE.read_text(encoding="utf-8") == wanted
        if not current:
            print("docs/interface.md is not current: run tools/interface_page.py", file=sys.stderr)
        return 0 if current else 1
    PAGE.write_text(wanted, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
