# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Results of a run on disk, and two of them compared."""

from __future__ import annotations

import datetime
import importlib.metadata
import json
import os
import platform
import subprocess
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from paper.timing import machine

from .measure import Figure

__all__ = ["Change", "changes", "read", "surroundings", "write"]

PACKAGES = ("numpy", "scipy", "numba", "llvmlite")


@dataclass(frozen=True)
class Change:
    """A case in two runs.

    Attributes:
        ratio: New median over the old one.
        beyond_spread: Whether the middle halves of the samples do not overlap.
    """

    ratio: float
    beyond_spread: bool


def surroundings() -> dict[str, Any]:
    """Machine, versions, commit and date of a run."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "commit": _git("rev-parse", "--short", "HEAD"),
        "uncommitted changes": bool(_git("status", "--porcelain", "--untracked-files=no")),
        "machine": machine(),
        "busy cores before": os.getloadavg()[0],
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": {name: importlib.metadata.version(name) for name in PACKAGES},
    }


def write(file: Path, about: dict[str, Any], figures: dict[str, Figure]) -> None:
    """Write a run as JSON."""
    content = about | {"figures": {key: asdict(figure) for key, figure in figures.items()}}
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def read(file: Path) -> tuple[dict[str, Any], dict[str, Figure]]:
    """A run: what is known about it, and its figures."""
    content = json.loads(file.read_text(encoding="utf-8"))
    figures = {key: Figure(**values) for key, values in content.pop("figures").items()}
    return content, figures


def changes(old: dict[str, Figure], new: dict[str, Figure]) -> dict[str, Change]:
    """What became of the cases that both runs have."""
    found = {}
    for key, now in new.items():
        if key not in old:
            continue
        before = old[key]
        apart = (
            now.first_quartile > before.third_quartile or now.third_quartile < before.first_quartile
        )
        found[key] = Change(now.median / before.median, apart)
    return found


def _git(*arguments: str) -> str:
    done = subprocess.run(["git", *arguments], capture_output=True, text=True, check=False)
    return done.stdout.strip()
