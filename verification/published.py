# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers in print beside what this library computes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from cpr_core import (
    Equilibrium,
    Robot,
    critical_load,
    critical_load_factor,
    solve_forward,
    solve_home,
)

from .single_rods import End, column, spatial_cantilever
from .stewart_gough import inverse_lengths

__all__ = ["FAMILIES", "Published", "published"]


@dataclass(frozen=True)
class Published:
    """A number in print.

    Attributes:
        name: What it is.
        source: Where it is printed.
        printed: As it is printed.
        ours: What this library computes.
        reach: How far ours may be from it: half a unit of the last digit in print, or what `why` says.
        why: Why it may be farther than that; empty where it may not.
    """

    name: str
    source: str
    printed: str
    ours: float
    reach: float
    why: str = ""

    @property
    def difference(self) -> float:
        """Ours against the printed number."""
        return self.ours - float(self.printed)

    @property
    def met(self) -> bool:
        """Whether ours is as near as it should be."""
        return abs(self.difference) <= self.reach


def as_printed(name: str, source: str, printed: str, ours: float) -> Published:
    """A number that is to agree to the last digit in print."""
    digits = len(printed.partition(".")[2])
    return Published(name, source, printed, ours, 0.5000001 * 10.0**-digits)


def published() -> tuple[Published, ...]:
    """All of them; takes seconds."""
    return tuple(number for family in FAMILIES.values() for number in family())


def buckling() -> Iterator[Published]:
    """Critical loads of straight rods, as factors of E J / l^2 or of their weight."""
    book = "Timoshenko, Gere, Theory of Elastic Stability, 2nd ed. 1961"
    ends: tuple[tuple[End, End, str], ...] = (
        ("clamped", "free", "2.4674"),
        ("hinged", "hinged", "9.8696"),
        ("clamped", "hinged", "20.19"),
        ("clamped", "clamped", "39.478"),
    )
    for base, tip, printed in ends:
        found = critical_load(solve_home(column(base, tip)), [-1.0, 0.0, 0.0])
        assert found is not None
        yield as_printed(f"column, {base} and {tip}, P l²/EJ", f"{book}, 2.1", printed, found.value)
    own = critical_load_factor(solve_home(column(weight=1.0)))
    assert own is not None
    source = f"Greenhill 1881; {book}, 2.12 (7.837)"
    yield as_printed("column under its own weight, q l³/EJ", source, "7.8373", own.value)
    # The books leave out the bending before buckling: that about d2 is made small by its rigidity.
    blade = spatial_cantilever(torsion=1.0, bending_2=1e6, bending_3=1.0)
    lateral = critical_load(solve_home(blade), [0.0, 0.0, -1.0])
    assert lateral is not None
    source = f"Prandtl 1899, Michell 1899; {book}, 6.3 (4.013)"
    yield as_printed("blade with a load at its tip, P l²/√(EJ GJ)", source, "4.0126", lateral.value)


#: P l^2 / E J: deflection along the load, way back, slope of the tip.
CANTILEVER = {
    1: ("0.30172", "0.05643", "0.46135"),
    2: ("0.49346", "0.16064", "0.78175"),
    5: ("0.71379", "0.38763", "1.21537"),
    10: ("0.81061", "0.55500", "1.43029"),
}


def large_deflection() -> Iterator[Published]:
    """A cantilever with a dead load across it: the problem of Bisshopp and Drucker, tabulated."""
    source = "K. Mattiasson, Int. J. Numer. Meth. Eng. 17, 1981, of Bisshopp, Drucker 1945"
    robot = column()
    for load, (deflection, back, slope) in CANTILEVER.items():
        tip = _loaded(robot, [0, 0, 0, 0, float(load), 0])
        found = (tip.platform_position[1], 1.0 - tip.platform_position[0], _slope(tip))
        printed = (deflection, back, slope)
        names = ("across, w/l", "back, u/l", "slope of the tip")
        for name, text, ours in zip(names, printed, found, strict=True):
            yield as_printed(f"cantilever, P l²/EJ = {load}, {name}", source, text, float(ours))


#: Slope of the tip in degrees: P over the critical load, place of the tip along and across.
POSTBUCKLING = {
    20: ("1.015", "0.970", "0.220"),
    40: ("1.063", "0.881", "0.422"),
    60: ("1.152", "0.741", "0.593"),
    80: ("1.293", "0.560", "0.719"),
    100: ("1.518", "0.349", "0.792"),
    120: ("1.884", "0.123", "0.803"),
}


def elastica() -> Iterator[Published]:
    """A column loaded beyond its critical load: the elastica."""
    source = "Timoshenko, Gere, Theory of Elastic Stability, table 2-4"
    why = "the table cuts its digits off: by elliptic integrals 40° are at 1.06366"
    robot, critical = column(), np.pi**2 / 4.0
    last = _loaded(robot, [0, 0, 0, -1.01 * critical, 0.1, 0])
    for angle, (load, along, across) in POSTBUCKLING.items():

        def gap(factor: float, angle: int = angle) -> float:
            nonlocal last
            last = _loaded(robot, [0, 0, 0, -factor * critical, 0, 0], last)
            return _slope(last) - np.radians(angle)

        factor = brentq(gap, 1.005, 2.1, xtol=1e-10)
        gap(factor)
        tip = last.platform_position
        found = (("P/P_cr", load, factor), ("x/l", along, tip[0]), ("y/l", across, tip[1]))
        for name, printed, ours in found:
            yield Published(f"elastica, {angle}°, {name}", source, printed, float(ours), 1e-3, why)


#: Load: place of the tip across the plane of the arc, and in it, by Simo and Vu-Quoc.
ARC = {300: ("40.08", "22.33", "58.84"), 600: ("53.37", "15.79", "47.23")}


def arc_of_45_degrees() -> Iterator[Published]:
    """A clamped arc with a load out of its plane, bending and torsion: Bathe and Bolourchi's problem."""
    source = "J. C. Simo, L. Vu-Quoc, Comput. Meth. Appl. Mech. Eng. 58, 1986 (8 elements)"
    why = "their 8 straight elements, which stretch and shear"
    # A radius of 100, an eighth of a circle, E = 1e7 and a square section of side 1, G = E / 2: in
    # lengths of the arc. The torsion constant of the papers is twice the second moment.
    length, bending = 100.0 * np.pi / 4.0, 1e7 / 12.0
    rigidity = bending / length**2
    robot = spatial_cantilever(rigidity, rigidity, rigidity, np.pi / 4.0)
    for load, printed in ARC.items():
        tip = length * _loaded(robot, [0, 0, 0, 0, 0, float(load)]).platform_position
        # Their x is across the rod at the clamp, their y along it.
        found = (tip[2], tip[1], tip[0])
        for name, text, ours in zip(("up", "across", "along"), printed, found, strict=True):
            yield Published(
                f"arc of 45°, load {load}, {name}", source, text, float(ours), 0.15, why
            )


#: In the order of his holes, with the platform at (0, 0, 0.4) m, turned by ten degrees about y.
LENGTHS = ("0.3973", "0.3973", "0.3997", "0.4216", "0.4216", "0.3997")


def stewart_gough() -> Iterator[Published]:
    """Leg lengths of the continuum Stewart-Gough robot of J. Till's examples."""
    source = "J. Till, ContinuumRobotExamples, 01_Statics/02: what its data lead to"
    for number, (printed, ours) in enumerate(zip(LENGTHS, inverse_lengths(), strict=True), 1):
        yield as_printed(f"Stewart-Gough, length of leg {number} [m]", source, printed, float(ours))


FAMILIES: dict[str, Callable[[], Iterator[Published]]] = {
    "buckling": buckling,
    "large deflection": large_deflection,
    "elastica": elastica,
    "arc": arc_of_45_degrees,
    "Stewart-Gough": stewart_gough,
}


def _loaded(robot: Robot, wrench: list[float], start: Equilibrium | None = None) -> Equilibrium:
    loads = robot.default_loads.with_(wrench_world=wrench)
    return solve_forward(robot, [], loads=loads, start=start)


def _slope(tip: Equilibrium) -> float:
    return float(np.arctan2(tip.platform_rotation[1, 0], tip.platform_rotation[0, 0]))
