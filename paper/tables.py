# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Tables in the paper's layout: every number beside the paper's, with a verdict."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import published
from .accuracy import InverseErrors
from .timing import CONFIGURATIONS, Measurement

__all__ = [
    "Entry",
    "Part",
    "Table",
    "error_table",
    "number",
    "table_i",
    "table_iii",
    "table_v",
    "table_vi",
]

AGREES, SAME_SIZE, DIFFERS, OWN = "agrees", "same size", "differs", ""
MARKS = {AGREES: "✓", SAME_SIZE: "≈", DIFFERS: "✗", OWN: ""}


@dataclass(frozen=True)
class Entry:
    """A number of a table.

    Attributes:
        ours: Computed in this run; None where it was not.
        paper: As printed in the paper; empty where the paper has none.
        within: Relative deviation up to which it agrees.
    """

    ours: float | None
    paper: str = ""
    within: float = 0.1

    @property
    def deviation(self) -> float | None:
        """Relative deviation from the paper."""
        if self.ours is None or not self.paper:
            return None
        return self.ours / float(self.paper) - 1.0

    @property
    def least_deviation(self) -> float | None:
        """Relative deviation from the nearest number that rounds to the printed one."""
        if self.ours is None or not self.paper:
            return None
        paper, half = float(self.paper), self._half_digit
        nearest = min(max(self.ours, paper - half), paper + half)
        return self.ours / nearest - 1.0

    @property
    def verdict(self) -> str:
        """``agrees``: within the stated deviation of what the paper rounds; ``same size``: factor 2."""
        deviation, least = self.deviation, self.least_deviation
        if deviation is None or least is None:
            return OWN
        if abs(least) <= self.within:
            return AGREES
        return SAME_SIZE if 0.5 <= 1.0 + deviation <= 2.0 else DIFFERS

    @property
    def _half_digit(self) -> float:
        mantissa, _, exponent = self.paper.partition("e")
        decimals = len(mantissa.partition(".")[2])
        return 0.5 * 10.0 ** (int(exponent or 0) - decimals)

    def __str__(self) -> str:
        """Ours, the paper's in brackets, and the mark of the verdict."""
        ours = "–" if self.ours is None else number(self.ours)
        return f"{ours} ({self.paper}) {MARKS[self.verdict]}".strip() if self.paper else ours


def number(value: float) -> str:
    """Three significant digits, powers of ten where a decimal point is far."""
    if value == 0.0 or 0.01 <= abs(value) < 1e4:
        digits = 2 - int(np.floor(np.log10(abs(value)))) if value else 0
        return f"{value:.{max(0, digits)}f}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa}e{int(exponent)}"


@dataclass(frozen=True)
class Table:
    """A table.

    Attributes:
        name: Such as ``Table I``.
        title: What it shows.
        corner: Heading of the first column.
        columns: Headings of the others.
        rows: Name and entries of every row.
        notes: Lines below the table.
    """

    name: str
    title: str
    corner: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Entry, ...]], ...]
    notes: tuple[str, ...] = ()

    def markdown(self) -> str:
        """The table in Markdown."""
        lines = [
            f"**{self.name}.** {self.title}",
            "",
            f"| {self.corner} | " + " | ".join(self.columns) + " |",
            "|---" * (len(self.columns) + 1) + "|",
        ]
        lines += [
            f"| {name} | " + " | ".join(str(entry) for entry in entries) + " |"
            for name, entries in self.rows
        ]
        return "\n".join([*lines, "", *self.notes]).rstrip() + "\n"

    def text(self) -> str:
        """The table for a terminal."""
        cells = [[self.corner, *self.columns]]
        cells += [[name, *map(str, entries)] for name, entries in self.rows]
        widths = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))]
        lines = [f"{self.name}. {self.title}"]
        lines += [
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
            for row in cells
        ]
        return "\n".join(lines) + "\n"

    def write(self, folder: Path) -> None:
        """Write ``<name>.md`` and ``<name>.csv`` (a line per number)."""
        stem = self.name.lower().replace(" ", "_").replace(",", "")
        (folder / f"{stem}.md").write_text(self.markdown())
        with (folder / f"{stem}.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["table", "row", "column", "ours", "paper", "deviation", "verdict"])
            for name, entries in self.rows:
                for column, entry in zip(self.columns, entries, strict=True):
                    ours = "" if entry.ours is None else f"{entry.ours:.6e}"
                    deviation = "" if entry.deviation is None else f"{entry.deviation:.4f}"
                    row = [self.name, name, column, ours, entry.paper, deviation, entry.verdict]
                    writer.writerow(row)


#: Columns of the error tables, in the paper's order.
STATISTICS = ("Min", "Max", "Mean")


class Part(NamedTuple):
    """Errors of an error table, and what the paper prints of them.

    Attributes:
        errors: By row, any number of each.
        printed: By row, in the order of ``STATISTICS``.
        mean_within: Deviation up to which a mean agrees.
        end_within: Deviation up to which a minimum or a maximum agrees.
    """

    errors: Mapping[int, NDArray[np.float64]]
    printed: Mapping[int, tuple[str, ...]]
    mean_within: float = 0.1
    end_within: float = 0.1


def statistics(values: np.ndarray) -> tuple[float, float, float]:
    """Smallest, largest, mean."""
    return float(values.min()), float(values.max()), float(values.mean())


def error_table(
    name: str,
    title: str,
    corner: str,
    parts: Mapping[str, Part],
    notes: tuple[str, ...] = (),
) -> Table:
    """A table of smallest, largest and mean errors.

    Args:
        name: Name.
        title: Title.
        corner: Heading of the first column.
        parts: Errors by heading.
        notes: Lines below the table.
    """
    columns = tuple(f"{heading} {which}" for heading in parts for which in STATISTICS)
    rows: dict[int, list[Entry]] = {}
    for errors, printed, mean_within, end_within in parts.values():
        for key, values in errors.items():
            ours = statistics(values)
            for value, text, within in zip(
                ours, printed[key], (end_within, end_within, mean_within), strict=True
            ):
                rows.setdefault(key, []).append(Entry(value, text, within))
    body = tuple((str(key), tuple(entries)) for key, entries in rows.items())
    return Table(name, title, corner, columns, body, notes)


def table_i(position: dict[int, np.ndarray], motors: dict[int, InverseErrors]) -> Table:
    """Forward errors on the path of Eq. (53), inverse errors on that of Eq. (54)."""
    stable = {modes: found.indices.count(0) for modes, found in motors.items()}
    note = (
        "Motor angles: poses of Eq. (54) that are reached and stable, "
        + ", ".join(f"{stable[modes]} with {modes} modes" for modes in motors)
        + "; reached are "
        + ", ".join(str(len(found.errors)) for found in motors.values())
        + " of 51. See *Where the paper cannot be matched*."
    )
    inverse = {modes: found.errors[: stable[modes]] for modes, found in motors.items()}
    return error_table(
        "Table I",
        "Errors against Mod. #2, RFRFR.",
        "Nb. of modes",
        {
            "Position error [mm]": Part(position, published.TABLE_I_POSITION, 0.03),
            "Motor angle error [mdeg]": Part(inverse, published.TABLE_I_MOTORS),
        },
        (note,),
    )


def table_v(errors: InverseErrors, away: np.ndarray, criterion: str) -> Table:
    """Table V over all poses, and over those away from the inverse singularity."""
    columns = tuple(f"Mot#{motor + 1}" for motor in range(6))
    reductions: dict[str, Callable] = {"Min": np.min, "Max": np.max, "Mean": np.mean}
    rows = []
    for label, poses in (("all poses", np.ones(len(away), bool)), ("away", away)):
        for statistic, reduce in reductions.items():
            ours = reduce(errors.errors[poses], axis=0)
            entries = tuple(
                Entry(float(value), text, 0.1)
                for value, text in zip(ours, published.TABLE_V[statistic], strict=True)
            )
            rows.append((f"{statistic}, {label}", entries))
    note = (
        f"Away: {int(away.sum())} poses, {criterion}. The paper's numbers, repeated there in brackets, "
        "are those of all its poses."
    )
    return Table(
        "Table V",
        "Motor angle error [mdeg] at the poses of Mod. #2, 6-RFS, 5 modes.",
        "",
        columns,
        tuple(rows),
        (note,),
    )


def _time_table(
    name: str,
    title: str,
    measured: dict[tuple[str, int], Measurement | None],
    models: tuple[str, ...],
    printed: Mapping[int, tuple[str, ...]],
    paper_models: tuple[str, ...],
    notes: tuple[str, ...],
) -> Table:
    columns = [f"Mod. {model} [ms]" for model in models]
    columns += [f"{model} / #1" for model in models[1:]]
    rows = []
    for count in CONFIGURATIONS:
        found = {model: measured.get((model, count)) for model in models}
        times = {model: value.seconds for model, value in found.items() if value is not None}
        entries = [Entry(1e3 * times[m] if m in times else None) for m in models]
        for model in models[1:]:
            ratio = times[model] / times["#1"] if model in times and "#1" in times else None
            paper = ""
            if model in paper_models:
                numbers = dict(zip(paper_models, printed[count], strict=True))
                paper = f"{float(numbers[model]) / float(numbers['#1']):.2g}"
            entries.append(Entry(ratio, paper, 0.25))
        rows.append((str(count), tuple(entries)))
    printed_text = "The paper's times [s]: " + "; ".join(
        f"n_c = {count}: "
        + ", ".join(f"{m} {t}" for m, t in zip(paper_models, printed[count], strict=True))
        for count in CONFIGURATIONS
    )
    return Table(name, title, "n_c", tuple(columns), tuple(rows), (*notes, "", printed_text + "."))


def table_iii(measured: dict[tuple[str, int], Measurement | None], notes: tuple[str, ...]) -> Table:
    """Times on the RFRFR path."""
    return _time_table(
        "Table III",
        "Time for n_c + 1 configurations of the RFRFR path, and ratios (the paper's in brackets).",
        measured,
        ("#1", "#2", "#2 exact", "#3", "#0"),
        published.TABLE_III,
        ("#1", "#2", "#3"),
        notes,
    )


def table_vi(measured: dict[tuple[str, int], Measurement | None], notes: tuple[str, ...]) -> Table:
    """Times on the 6-RFS path."""
    return _time_table(
        "Table VI",
        "Time for n_c + 1 configurations of the 6-RFS path, and ratios (the paper's in brackets).",
        measured,
        ("#1", "#2", "#2 exact", "#0"),
        published.TABLE_VI,
        ("#1", "#2"),
        notes,
    )
