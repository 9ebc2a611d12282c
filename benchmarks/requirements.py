# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is demanded of the times and ratios of a run, and whether they meet it."""

from __future__ import annotations

from dataclasses import dataclass

from .measure import Figure
from .scaling import exponents

__all__ = ["Requirement", "requirements"]

#: An exponent within this of the demanded one counts as it: it is fitted to measured times.
EXPONENT_TOLERANCE = 0.1


@dataclass(frozen=True)
class Requirement:
    """One line of the summary.

    Attributes:
        name: What is demanded, in words.
        measured: What was found, in words.
        met: Whether it is enough.
    """

    name: str
    measured: str
    met: bool


def requirements(figures: dict[str, Figure]) -> tuple[Requirement, ...]:
    """All requirements whose cases were measured."""
    found: list[Requirement] = []

    def time_below(key: str, limit: float, name: str) -> None:
        if key in figures:
            seconds = figures[key].median
            found.append(
                Requirement(f"{name}: below {_time(limit)}", _time(seconds), seconds < limit)
            )

    def ratio(
        over: str, under: str, name: str, at_most: float = 0.0, at_least: float = 0.0
    ) -> None:
        if over not in figures or under not in figures:
            return
        value = figures[over].median / figures[under].median
        words = f"at most {at_most:g}" if at_most else f"at least {at_least:g}"
        met = value <= at_most if at_most else value >= at_least
        found.append(Requirement(f"{name}: {words} times", f"{value:.2f} times", met))

    forward = "forward/six_rfs/5"
    time_below(forward, 1e-4, "warm forward solve, 6-RFS, 5 modes")
    for library in ("scipy", "LAPACK"):
        ratio(
            forward,
            f"dense LU, {library}/six_rfs/5",
            f"the same against one dense LU of its matrix (84 x 84, {library})",
            at_most=2.0,
        )
    time_below("forward/rfrfr/5", 2e-5, "warm forward solve, planar RFRFR, 5 modes")
    time_below("path of 51 points/six_rfs/5", 6e-3, "path of 51 points, 6-RFS")
    ratio(
        "at 1e-6 m, continuous shooting/six_rfs",
        "at 1e-6 m, this library/six_rfs",
        "compiled continuous shooting over this library, 6-RFS, both with errors up to 1e-6 m",
        at_least=5.0,
    )
    ratio(
        "forward/six_rus/8",
        "forward/six_rfs/8",
        "warm forward solve with 8 modes, 6-RUS under gravity over 6-RFS",
        at_most=3.0,
    )
    _index_is_free(figures, found)
    ratio(
        "forward and everything/six_rfs/5",
        forward,
        "solve, stability (both readings, eigenvalues) and kinemato-statics over the solve alone",
        at_most=2.5,
    )
    time_below("inverse/gough_stewart/5", 3e-4, "inverse, six extensible legs, 1.4 mm pose steps")
    _batches(figures, found)
    _growth(figures, found)
    for key, limit, name in (
        ("import cpr_core", 0.5, "import cpr_core"),
        ("first solve, warm cache", 1.5, "first solve in a new process, warm cache"),
    ):
        time_below(key, limit, name)
    return tuple(found)


def _index_is_free(figures: dict[str, Figure], found: list[Requirement]) -> None:
    with_index, alone = (
        figures.get("forward and locked index/six_rfs/5"),
        figures.get("forward/six_rfs/5"),
    )
    if with_index is None or alone is None:
        return
    text = f"{100.0 * (with_index.median / alone.median - 1.0):+.1f} %"
    met = with_index.first_quartile <= alone.third_quartile
    name = "stability index, motors locked, with the solve: nothing beyond the spread"
    found.append(Requirement(name, text, met))


def _batches(figures: dict[str, Figure], found: list[Requirement]) -> None:
    cores = [[key for key in figures if f", {number}/" in key] for number in ("1 core", "2 cores")]
    if not all(cores):
        return
    one_core, two_cores = (figures[keys[0]].median for keys in cores)
    gain, rate = one_core / two_cores, 1.0 / two_cores
    name = "batch, two cores over one: at least 1.8 times"
    found.append(Requirement(name, f"{gain:.2f} times", gain >= 1.8))
    name = "batch, 6-RFS, two cores: at least 15000 solves a second"
    found.append(Requirement(name, f"{rate:.0f}", rate >= 15000))


def _growth(figures: dict[str, Figure], found: list[Requirement]) -> None:
    if not any(key.startswith("scaling") for key in figures):
        return
    slopes = exponents(figures)
    for axis, power, words in (
        ("legs", 1, "linear"),
        ("nodes", 1, "linear"),
        ("modes", 2, "at most quadratic"),
    ):
        slope = slopes[f"{axis}/forward solve"]
        name = f"cost of a solve in {axis} {words}: exponent at most {power}"
        found.append(Requirement(name, f"{slope:.2f}", slope <= power + EXPONENT_TOLERANCE))


def _time(seconds: float) -> str:
    for factor, unit in ((1.0, "s"), (1e3, "ms")):
        if seconds * factor >= 0.1:
            return f"{seconds * factor:.3g} {unit}"
    return f"{1e6 * seconds:.3g} µs"
