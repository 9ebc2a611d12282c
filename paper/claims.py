# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the reproduction has to show, decided by the numbers of the run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import published
from .stability import Line
from .tables import Table
from .timing import Measurement

__all__ = ["Claim", "accuracy_claims", "stability_claims", "time_claims"]


@dataclass(frozen=True)
class Claim:
    """A requirement and whether this run meets it.

    Attributes:
        text: What is required.
        found: What was measured.
        met: Whether it is met.
    """

    text: str
    found: str
    met: bool


def accuracy_claims(tables: dict[str, Table], away_means: np.ndarray) -> list[Claim]:
    """Tables I, II, IV and V."""
    claims = []
    for name, column, limit in (
        ("Table I", "Position error [mm] Mean", 0.03),
        ("Table I", "Position error [mm] Max", 0.10),
        ("Table II", "Position error [mm] Mean", 0.05),
        ("Table IV", "Position error [mm] Mean", 0.05),
        ("Table IV", "Angular error [deg] Mean", 0.15),
    ):
        position = tables[name].columns.index(column)
        entries = [row[position] for _, row in tables[name].rows]
        found = []
        for entry in entries:
            text = f"{100 * (entry.deviation or 0.0):+.1f} %"
            if abs(entry.deviation or 0.0) > limit:
                least = 100 * (entry.least_deviation or 0.0)
                text += f" ({least:+.1f} % of the nearest number that prints as {entry.paper})"
            found.append(text)
        claims.append(
            Claim(
                f"{name}, {column}: within {100 * limit:.0f} % of the paper, to its last digit",
                ", ".join(found),
                all(abs(entry.least_deviation or 0.0) <= limit for entry in entries),
            )
        )
    ratios = away_means / np.array([float(value) for value in published.TABLE_V["Mean"]])
    claims.append(
        Claim(
            "Table V: means away from the singularity within a factor of 2 of the paper's",
            "ratios " + ", ".join(f"{ratio:.2f}" for ratio in ratios),
            bool(np.all((ratios > 0.5) & (ratios < 2.0))),
        )
    )
    return claims


def time_claims(
    planar: dict[tuple[str, int], Measurement | None],
    spatial: dict[tuple[str, int], Measurement | None],
    count: int,
) -> list[Claim]:
    """Tables III and VI, at one n_c."""

    def ratio(measured: dict[tuple[str, int], Measurement | None], model: str) -> float | None:
        slow, fast = measured.get((model, count)), measured.get(("#1", count))
        return slow.seconds / fast.seconds if slow is not None and fast is not None else None

    claims = []
    for table, measured, model, needed, rival in (
        ("III", planar, "#3", 100.0, "#3 with 1000 elements"),
        ("VI", spatial, "#0", 1000.0, "#0"),
        ("III", planar, "#2", 3.0, "#2, equally accurate"),
        ("III", planar, "#2 exact", 3.0, "#2 exact, the reference of all errors"),
        ("VI", spatial, "#2", 3.0, "#2, equally accurate"),
        ("VI", spatial, "#2 exact", 3.0, "#2 exact, the reference of all errors"),
    ):
        value = ratio(measured, model)
        text = f"Table {table}: #1 at least {needed:.0f} times faster than {rival}"
        found = "not measured" if value is None else f"{value:.3g} times (n_c = {count})"
        claims.append(Claim(text, found, value is not None and value >= needed))
    return claims


def stability_claims(figure: str, line: Line) -> list[Claim]:
    """Every zero crossing of an eigenvalue against the conjugate point that appears there."""
    claims = []
    for crossing in line.crossings:
        gap = abs(crossing.eigenvalue - crossing.conjugate)
        claims.append(
            Claim(
                f"{figure}: sigma_{crossing.order + 1} = 0 where a conjugate point appears, to 1e-4 m",
                f"{line.axis} = {crossing.eigenvalue:.6f} and {crossing.conjugate:.6f} m, "
                f"{gap:.1e} m apart; {crossing.before} conjugate points before, {crossing.after} after",
                gap < 1e-4 and crossing.after == crossing.before + 1 == crossing.order + 1,
            )
        )
    agree = sum(len(point.conjugate) == point.index for point in line.samples)
    claims.append(
        Claim(
            f"{figure}: as many conjugate points as negative eigenvalues at every point of the line",
            f"{agree} of {len(line.samples)} points",
            agree == len(line.samples) and bool(line.crossings),
        )
    )
    return claims
