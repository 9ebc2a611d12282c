# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A run as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from .comparison import Comparison, Requirement
from .published import Published

__all__ = ["comparison_table", "published_table", "requirement_table", "text_of"]

HEADER = (
    "robot",
    "program, setting",
    "its start",
    "position, rods as they stretch; finest pieces [m]",
    "position, no stretch [m]",
    "efforts",
    "its time",
    "ours",
    "ratio",
    "what remains",
)


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a table."""
    lines = [f"| {' | '.join(header)} |", "|---" * len(header) + "|"]
    return lines + [f"| {' | '.join(row)} |" for row in rows]


def comparison_table(comparisons: Sequence[Comparison]) -> list[str]:
    """Programs beside ours."""
    return table(
        HEADER,
        (
            (
                found.case.name,
                f"{found.program}: {found.setting}",
                found.start,
                f"{found.distance_as_is:.1e}",
                f"{found.distance:.1e}",
                f"{found.efforts:.1e}",
                f"{found.seconds:.2g} s",
                f"{found.ours.seconds:.2g} s, {found.ours.modes} modes, {found.ours.distance:.0e} m",
                f"{found.ratio:.0f}",
                found.why,
            )
            for found in comparisons
        ),
    )


def published_table(numbers: Sequence[Published]) -> list[str]:
    """Numbers in print beside ours."""
    header = ("number", "in print", "ours", "source", "what remains")
    return table(
        header,
        (
            (number.name, number.printed, f"{number.ours:.7g}", number.source, number.why)
            for number in numbers
        ),
    )


def requirement_table(requirements: Sequence[Requirement]) -> list[str]:
    """What is demanded, and whether it is met."""
    return table(
        ("requirement", "measured", "bound", "met"),
        (
            (
                requirement.name,
                f"{requirement.measured:.1e} {requirement.unit}",
                f"{requirement.bound:.0e} {requirement.unit}",
                "yes" if requirement.met else "**no**",
            )
            for requirement in requirements
        ),
    )


def text_of(
    about: str,
    comparisons: Sequence[Comparison],
    impossible: Sequence[str],
    numbers: Sequence[Published],
    requirements: Sequence[Requirement],
) -> str:
    """All tables of a run."""
    lines = [about, "", "### Programs", "", *comparison_table(comparisons), ""]
    if impossible:
        lines += [
            "### What they cannot do, or was not built",
            "",
            *(f"- {line}" for line in impossible),
            "",
        ]
    lines += ["### Numbers in print", "", *published_table(numbers), ""]
    lines += ["### What is demanded", "", *requirement_table(requirements)]
    return "\n".join(lines) + "\n"
