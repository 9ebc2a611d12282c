# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The part of docs/verification.md that a run writes, between two marks."""

from __future__ import annotations

from pathlib import Path

__all__ = ["FIRST", "LAST", "publish"]

FIRST = "<!-- tables: written by make verify PUBLISH=1, do not edit -->"
LAST = "<!-- end of tables -->"


def publish(page: Path, text: str) -> None:
    """Write tables into a page.

    Args:
        page: The page.
        text: What belongs between the marks.

    Raises:
        SystemExit: The page has no place for it.
    """
    head, _, rest = page.read_text(encoding="utf-8").partition(FIRST)
    _, found, tail = rest.partition(LAST)
    if not found:
        raise SystemExit(f"{page} has no place for the tables: {FIRST} ... {LAST}")
    page.write_text(f"{head}{FIRST}\n{text.strip()}\n{LAST}{tail}", encoding="utf-8")
