# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where on a path something happens: the two points next to a change.

Brent's method narrows down what has a sign (the direction of the branch, the margin of a limit),
bisection what only changes, and whatever else happens there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from ..kernels.limit_kernel import ROUNDING
from ..model.configurations import configuration_distance
from .passed_events import differ
from .path import Path, Point, Tangent

__all__ = [
    "LOCATION",
    "SAME_PLACE",
    "along",
    "bracket_by_arc_length",
    "bracket_by_fraction",
    "distance",
    "landing",
]

#: Events are located to this fraction of the way.
LOCATION = 1e-9
#: How far before and behind an event found by Brent's method its neighbours are.
_BESIDE = 0.49 * LOCATION
#: Two solutions found by bisection are neighbours on a branch if the state moves less than this between
#: them, dimensionless. Branches that come nearer to each other are taken to cross.
SAME_PLACE = 1e-5
#: Cosine of the largest turn of the branch within a step by arc length.
STRAIGHT = 0.95
#: Part of the smaller rate of the fraction at the ends of a step that it has on average at least; and
#: how well fractions are known.
_STEADY, _ROUNDED = 0.5, 1e-12
#: Arc length before and after an event at which its kind is told: at a fold itself both the direction
#: and the determinant vanish to rounding.
ASIDE = 1e-3


class _Bracket(NamedTuple):
    """Two points around a change, and where they are: fractions, or arc lengths."""

    low: Point
    high: Point
    first: float
    last: float


def along(path: Path, point: Point, tangent: Tangent, arc: float) -> Point | None:
    """The point at an arc length, with its tangent; None where the branch turns too much.

    Also where it turns back and forth in between: then it comes less far than at the rate of either end.
    """
    reached = path.along(point, tangent, arc)
    if reached is None:
        return None
    onward = path.tangent(reached, tangent)
    if tangent.cosine(onward) < STRAIGHT:
        return None
    least = arc * min(tangent.fraction, onward.fraction, key=abs)
    moved = math.copysign(1.0, least) * (reached.fraction - point.fraction)
    if tangent.fraction * onward.fraction > 0.0 and moved < _STEADY * abs(least) - _ROUNDED:
        return None
    return replace(reached, tangent=onward)


def landing(path: Path, point: Point, tangent: Tangent, arc: float, end: float) -> float | None:
    """Arc length, up to the given one, at which the branch is at a fraction; None if it is not found."""

    def beyond(arc_length: float) -> float:
        ahead = path.along(point, tangent, arc_length) if arc_length > 0.0 else point
        return np.nan if ahead is None else ahead.fraction - end

    try:
        return float(scipy.optimize.brentq(beyond, 0.0, arc, xtol=1e-13))
    except (ValueError, RuntimeError):  # the branch is there at the start already, or lost between
        return None


def bracket_by_fraction(
    path: Path, low: Point, last: float, high: Point
) -> tuple[Point, Point | None]:
    """The two points around the first change before a fraction, next to each other.

    Args:
        path: The path.
        low: Point before the change.
        last: Fraction behind it.
        high: The point there.

    Returns:
        The point before it and the one behind it; None in its place if no solution is near there.
    """
    found: Point | None
    low, found, _, last = _narrowed(path.at, _Bracket(low, high, low.fraction, last))
    while last - low.fraction > LOCATION:
        middle = 0.5 * (low.fraction + last)
        point = path.at(low, middle)
        if point is None or differ(low, point):
            last, found = middle, point
        else:
            low = point
    behind = path.at(low, last)
    hidden = behind is not None and not differ(low, behind)
    if hidden and found is not None and not found.violated <= low.violated:
        return low, found  # rounding decides there on which side of a limit a point is
    return low, behind


def bracket_by_arc_length(
    path: Path, point: Point, tangent: Tangent, last: float, high: Point
) -> tuple[Point, Point, Point] | None:
    """The same along the tangent of a point, with the direction of the branch on both sides.

    Args:
        path: The path.
        point: Point before the change.
        tangent: Its tangent.
        last: Arc length from there of a point behind the change.
        high: That point.

    Returns:
        The two points, and one a little farther on, where tangents can be trusted again; None if they
        are not on one branch.
    """

    def ahead(near: Point, arc: float) -> Point | None:
        return along(path, point, tangent, arc)

    start = replace(point, tangent=tangent)
    low, high, first, last = _narrowed(ahead, _Bracket(start, high, 0.0, last))
    while last - first > LOCATION:
        middle = 0.5 * (first + last)
        between = along(path, point, tangent, middle)
        if between is None or distance(low, between) > 2.0 * (middle - first):
            break  # next to a crossing of branches the solution is not known any better
        if differ(low, between):
            high, last = between, middle
        else:
            low, first = between, middle
    if last - first > SAME_PLACE or distance(low, high) > max(SAME_PLACE, 2.0 * (last - first)):
        return None
    if low.sign != high.sign:
        low = replace(low, fraction=path.crossing(low, high))
    before = start
    if first > ASIDE:
        before = along(path, point, tangent, first - ASIDE) or low
    if differ(start, before):
        return None  # the change is one of another branch, to which the step had led before it
    beyond = along(path, point, tangent, last + ASIDE) or high
    low = replace(low, tangent=before.tangent, sign=before.sign, index=before.index)
    return low, replace(high, tangent=beyond.tangent, sign=beyond.sign, index=beyond.index), beyond


def _narrowed(find: Callable[[Point, float], Point | None], wide: _Bracket) -> _Bracket:
    """The points around the first change that is found in a bracket, which may be as wide as it was.

    Args:
        find: The point at a place, found from one before; None if there is none.
        wide: Around a change.
    """
    low, high, first, last = wide
    value = _signed(low, high)
    if value is None:
        return wide
    known = {first: low, last: high}

    def at(place: float) -> float:
        if place not in known:
            near = max(
                before for before in known if before < place and not differ(low, known[before])
            )
            point = find(known[near], place)
            if point is None:
                raise _Lost
            known[place] = point
        return value(known[place])

    # Other things may happen on the way, or the value jump: what is known is looked at in order.
    with suppress(_Lost, RuntimeError):
        root = scipy.optimize.brentq(at, first, last, xtol=0.1 * LOCATION)
        # The way back begins before the event: not where rounding decides on which side of it.
        for place in (root - _BESIDE, root + _BESIDE):
            at(min(last, max(first, place)))
        for place in [each for each in known if abs(each - root) < 0.9 * _BESIDE]:
            if place not in (first, last):
                del known[place]
    places = sorted(known)
    number = next(k for k, place in enumerate(places) if differ(low, known[place]))
    first, last = places[number - 1], places[number]
    return _Bracket(known[first], known[last], first, last)


class _Lost(Exception):
    """There is no solution where one was looked for."""


def _signed(low: Point, high: Point) -> Callable[[Point], float] | None:
    """What changes its sign continuously between two points, if there is such a quantity."""
    if low.forward != high.forward:
        return lambda point: 1.0 if point.tangent is None else point.tangent.fraction
    limits = (low.margins >= -ROUNDING) & (high.margins < -ROUNDING)
    if limits.any():
        return lambda point: float(point.margins[limits].min()) + ROUNDING
    return None


def distance(low: Point, high: Point) -> float:
    """Largest dimensionless change of the state between two points."""
    first, second = low.equilibrium, high.equilibrium
    return float(configuration_distance(first.robot, first.configuration, second.configuration))
