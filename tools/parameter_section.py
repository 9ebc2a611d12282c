#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Writes the parameters into docs/node.md from their declarations; `--check`: are they current?"""

from __future__ import annotations

import sys

from marked_section import ROOT, keep_current, row

sys.path.insert(0, str(ROOT))
from cpr_ros.settings.parameter_table import PARAMETERS


def section() -> str:
    """The table of all parameters."""
    lines = [
        row("name", "type", "unit", "values", "default", "changes", ""),
        "|---|---|---|---|---|---|---|",
    ]
    for parameter in PARAMETERS:
        lines.append(
            row(
                f"`{parameter.name}`",
                parameter.kind,
                parameter.unit,
                parameter.values,
                f"`{parameter.default_text}`",
                "live" if parameter.live else "read-only",
                parameter.meaning,
            )
        )
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(keep_current("parameter_section.py", "docs/node.md", "parameters", section))
