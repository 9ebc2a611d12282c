# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A run as Markdown."""

from __future__ import annotations

from typing import Any

from .measure import Figure
from .requirements import requirements
from .results import Change

__all__ = ["report"]

#: Busy cores above which the wall clock tells more of other processes than of this one.
BUSY = 0.5


def report(
    about: dict[str, Any],
    figures: dict[str, Figure],
    changed: dict[str, Change],
    baseline: dict[str, Any] | None = None,
) -> str:
    """All of a run: where it was made, its figures, and what is demanded of them.

    Args:
        about: `results.surroundings` with `facts`.
        figures: What was measured.
        changed: Against an earlier run, by case.
        baseline: About that run.
    """
    versions = ", ".join(f"{name} {version}" for name, version in about["versions"].items())
    lines = [
        "# Benchmark",
        "",
        f"{about['date']}, commit {about['commit']}"
        + (" with uncommitted changes" if about["uncommitted changes"] else "")
        + f"; {about['machine']}; Python {about['python']}, {versions}. One BLAS thread.",
        "",
    ]
    if about["busy cores before"] > BUSY:
        lines += [
            f"Other processes kept {about['busy cores before']:.1f} cores busy before the run: times by "
            "the wall clock (batches, new processes) are those of a shared machine.",
            "",
        ]
    for name, text in about.get("facts", {}).items():
        lines.append(f"- {name}: {text}")
    lines += ["", *_figures(figures, changed, about.get("steps", {}), baseline)]
    lines += ["", "## Requirements", "", "| requirement | measured | met |", "|---|---|---|"]
    for requirement in requirements(figures):
        met = "yes" if requirement.met else "**no**"
        lines.append(f"| {requirement.name} | {requirement.measured} | {met} |")
    return "\n".join(lines) + "\n"


def _figures(
    figures: dict[str, Figure],
    changed: dict[str, Change],
    steps: dict[str, float],
    baseline: dict[str, Any] | None,
) -> list[str]:
    header = "| case | median | middle half | smallest | samples | clock | Newton steps |"
    lines = []
    if baseline is not None:
        lines += [
            f"*ratio*: against {baseline['date']}, commit {baseline['commit']}; in bold where the "
            "middle halves of the samples do not overlap.",
            "",
        ]
        header += " ratio |"
    lines += [header, "|---" * (header.count("|") - 1) + "|"]
    for key, figure in figures.items():
        cells = [
            key.replace("/", ", "),
            _quantity(figure.median, figure.unit),
            f"{_quantity(figure.first_quartile, figure.unit)} to "
            f"{_quantity(figure.third_quartile, figure.unit)}",
            _quantity(figure.smallest, figure.unit),
            str(figure.samples),
            figure.clock,
            f"{steps[key]:.2f}" if key in steps else "",
        ]
        if baseline is not None:
            change = changed.get(key)
            text = "" if change is None else f"{change.ratio:.2f}"
            cells.append(f"**{text}**" if change is not None and change.beyond_spread else text)
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _quantity(value: float, unit: str) -> str:
    if unit != "s":
        return f"{value:.0f} {unit}"
    for factor, name in ((1.0, "s"), (1e3, "ms")):
        if value * factor >= 0.5:
            return f"{value * factor:.3g} {name}"
    return f"{1e6 * value:.3g} µs"
