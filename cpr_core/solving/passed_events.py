# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What happens between two neighbouring points of a path: whether anything does, and what it is."""

from __future__ import annotations

from .events import EventKind, PathEvent
from .hidden_changes import Hidden, hidden_between, hidden_in_halves
from .limits import Limit, first_of, grazes, limit_error
from .path import Path, Point

__all__ = ["differ", "event_between", "hidden_on_path", "limit_passed"]

#: A point before a step tells how values change if it is at least so far away, in lengths of the step.
_NEAREST = 1e-3


def differ(low: Point, high: Point) -> bool:
    """Whether something happens between two points of a path."""
    return (
        low.index != high.index
        or low.sign != high.sign
        or low.forward != high.forward
        or not high.violated <= low.violated
        or low.inverse_sign != high.inverse_sign
    )


def hidden_on_path(path: Path, before: Point | None, point: Point, next_point: Point) -> Hidden:
    """What may have happened, and been undone, between two points.

    Args:
        path: The path.
        before: The point before them; None: there is none, a point in the middle tells instead.
        point: A point.
        next_point: The next one.
    """
    if grazes(point.margins, next_point.margins):
        return Hidden.MARGIN
    if not any(point.watched):
        return Hidden.NOTHING
    step = next_point.fraction - point.fraction
    if before is not None and point.fraction - before.fraction > _NEAREST * step:
        places = before.fraction, point.fraction, next_point.fraction
        return hidden_between(places, (before.watched, point.watched, next_point.watched))
    middle = path.at(point, point.fraction + 0.5 * step)
    if middle is None or differ(point, middle):
        return Hidden.MARGIN | Hidden.SINGULARITY
    return hidden_in_halves(point.watched, middle.watched, next_point.watched)


def limit_passed(low: Point, high: Point) -> Limit | None:
    """The limit that holds at the first of two points and not at the second."""
    return first_of(high.violated - low.violated)


def event_between(path: Path, low: Point, high: Point) -> PathEvent | None:
    """What happens between two neighbours; None: nothing."""
    kind, text = _kind(path, low, high)
    if kind is None:
        return None
    return PathEvent(
        kind=kind,
        fraction=low.fraction,
        equilibrium=low.equilibrium,
        index_before=low.index,
        index_after=high.index,
        message=text,
    )


def _kind(path: Path, low: Point, high: Point) -> tuple[EventKind | None, str]:
    """Kind of the event between two neighbours, and what it is in words."""
    limit = limit_passed(low, high)
    if limit is not None:
        return limit.kind, str(limit_error(high.equilibrium, limit))
    change = f"index {low.index}" + (f" -> {high.index}" if high.index != low.index else "")
    if low.forward != high.forward:
        return "fold", f"the branch turns back ({change})"
    if low.side != high.side:
        return "bifurcation", f"another branch crosses ({change})"
    # Without a potential the index has no meaning; that the branch goes on was to be seen.
    index_changes = path.conservative and low.index != high.index
    if index_changes and path.problem != "pose":
        return "bifurcation", f"several branches cross ({change})"
    if index_changes:
        gained = "lost" if high.index > low.index else "gained"
        return "stability", f"stability is {gained} ({change})"
    if low.inverse_sign != high.inverse_sign:
        return "singularity", "an inverse singularity is passed"
    return None, ""
