# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From one equilibrium to a requested one, along a straight path in what the request imposes.

A way of up to half a radian or half a rod length is tried in one step, a longer one in several. A
step is accepted if every Newton correction contracts and the signs of the tangent (stability index,
determinant of the problem) are those of the point before. Where a sign changes, a limit is passed or no
step succeeds, the place is found by bisection, to 1e-9 of the way, and tells what it is: an event of the
branch, or a jump, which is not taken. Near a fold the branch is followed by its arc length.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ..blas_threads import on_one_blas_thread
from ..description.loads import Loads
from ..kernels.natural_units import LONGEST_STEP
from ..model.equilibrium import Equilibrium
from .bracketing import (
    SAME_PLACE,
    along,
    bracket_by_arc_length,
    bracket_by_fraction,
    distance,
    landing,
)
from .crossings import SINGULAR, VANISHED, crossing_ways, several_cross, several_meet
from .events import EventKind, PathEvent
from .hidden_changes import Hidden, hidden_between
from .limits import Limit
from .passed_events import differ, event_between, hidden_on_path, limit_passed
from .path import OutOfTime, Path, Point, Tangent
from .targets import Target
from .taut_rods import taut_legs

__all__ = ["Walk", "follow"]

#: Smallest path step before the branch is followed by arc length, as a fraction of a full step.
SMALLEST_STEP = 1e-3
#: Requests farther away than so many longest steps are refused at once.
MOST_STEPS = 1000
#: Steps in place of one where inverse singularities are located: these may come in pairs.
FINE = 4.0
#: Arc lengths of the dimensionless state: first, longest and smallest step.
FIRST_ARC, LONGEST_ARC, SMALLEST_ARC = 0.05, 0.5, 1e-7
SEVERAL = "several branches cross, none of them goes on alone"
#: Steps by arc length around one place, and past folds.
MOST_ARCS, MOST_ARCS_PAST_FOLDS = 300, 3000


@dataclass(frozen=True, eq=False)
class Walk:
    """How far a branch was followed.

    Attributes:
        last: Where it was followed to.
        events: What was passed, in order.
        arrived: Whether that is the target; else the last event stopped the walk.
        violation: The limit that stopped it, if it was one, and the equilibrium just beyond.
        points: The points that were kept.
    """

    last: Equilibrium
    events: tuple[PathEvent, ...] = ()
    arrived: bool = True
    violation: tuple[Limit, Equilibrium] | None = None
    points: tuple[Point, ...] = ()

    @property
    def stopped(self) -> PathEvent | None:
        """What stopped it short of the target."""
        return None if self.arrived else self.events[-1]


def follow(
    start: Equilibrium,
    target: Target,
    loads: Loads,
    *,
    stable_only: bool = False,
    past_folds: bool = False,
    singularities: bool = False,
    keep: tuple[float, ...] = (),
    time_limit: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Walk:
    """Follow the branch of an equilibrium until a target is met or an event stops the way.

    The parameters after the loads are independent options, given by name.

    Args:
        start: Equilibrium to start from.
        target: What to impose.
        loads: Loads to arrive with; they change along the way as well.
        stable_only: Stop where the stability index grows above zero.
        past_folds: Follow the branch around folds, by arc length all along, until it leaves the
            interval of fractions from 0 to 1; all points are kept.
        singularities: Miss no event: locate inverse singularities on the way of motors or efforts too,
            and stretches without stability on the way of a pose that are shorter than a step.
        keep: Fractions, increasing, whose points are kept.
        time_limit: Give up after this time [s].
        progress: Called with the fraction reached.

    Returns:
        How far the branch was followed; an end on the way is no error here.

    Raises:
        InvalidRequest: A time limit that is negative or no number.
    """
    path = Path(
        start,
        target,
        loads,
        stability=stable_only or singularities,
        singularities=singularities,
        time_limit=time_limit,
    )
    return _Walker(path, target, stable_only, past_folds, keep, progress).walk()


class _Ended(Exception):
    """The last event stopped the walk."""


class _Walker:
    """One walk: what was passed so far, and what to do next."""

    def __init__(
        self,
        path: Path,
        target: Target,
        stable_only: bool,
        past_folds: bool,
        keep: tuple[float, ...],
        progress: Callable[[float], None] | None,
    ) -> None:
        self.path = path
        self.steps = max(target.distance(path.start), path.load_distance) / LONGEST_STEP
        self.longest = 1.0 / max(1.0, (FINE if path.looks_closely else 1.0) * self.steps)
        self.stable_only, self.past_folds = stable_only, past_folds
        self.keep, self.progress = list(keep), progress
        self.events: list[PathEvent] = []
        self.points: list[Point] = []
        self.violation: tuple[Limit, Equilibrium] | None = None

    def walk(self) -> Walk:
        """Go until the end."""
        arrived = True
        try:
            last = self._to_the_end().equilibrium
            if last.iterations != self.path.iterations:
                last = last.with_iterations(self.path.iterations)
        except _Ended:
            arrived, last = False, self.events[-1].equilibrium
        return Walk(last, tuple(self.events), arrived, self.violation, tuple(self.points))

    def _to_the_end(self) -> Point:
        """To the end of the way, or to where a branch that is followed past folds leaves it."""
        start = self.path.begin()
        self._keep(start)
        if not self.steps <= MOST_STEPS:
            raise self._ended(start, "lost", "it is too far away to be followed there")
        if self.stable_only and start.index > 0:
            raise self._ended(start, "stability", f"the start is unstable, index {start.index}")
        if self.stable_only and not self.path.conservative:
            text = "stability is not decided by energy under these loads"
            raise self._ended(start, "stability", text)
        try:
            return self._by_arc_length(start) if self.past_folds else self._by_fraction(start)
        except OutOfTime:
            raise self._ended(self.reached, "time_limit", "the time allowed was over") from None

    def _by_fraction(self, point: Point) -> Point:
        """Steps at given fractions to the end of the way; by arc length where they fail."""
        longest = self.longest
        step, before = longest, None
        while point.fraction < 1.0:
            stop = self.keep[0] if self.keep else 1.0
            ahead = min(1.0, stop, point.fraction + step)
            next_point = self.path.at(point, ahead)
            # A changed sign may be a fold's other arm, very near.
            if next_point is None or next_point.sign != point.sign:
                step = 0.5 * (ahead - point.fraction)
                if step >= SMALLEST_STEP * longest:
                    continue
                point, before = self._by_arc_length(point), None
                step = 10.0 * SMALLEST_STEP * longest
            elif differ(point, next_point):
                low, high = bracket_by_fraction(self.path, point, ahead, next_point)
                regular = self.path.problem == "pose" or high is None or low.index == high.index
                if high is None or not regular or distance(low, high) > SAME_PLACE:
                    if several_cross(self.path, low):
                        raise self._ended_at_crossing(low, point, SEVERAL)
                    point = self._by_arc_length(point)  # the step had jumped over something
                else:
                    if low.index != high.index and several_cross(self.path, low, VANISHED):
                        raise self._ended_at_crossing(low, point, SEVERAL)
                    self._note(low, high)
                    point = high
                step = min(step, 10.0 * max(point.fraction - low.fraction, SMALLEST_STEP * longest))
                before = None
            else:
                half = 0.5 * (ahead - point.fraction)
                hidden = hidden_on_path(self.path, before, point, next_point)
                if hidden:
                    if half >= SMALLEST_STEP * longest:
                        step = half
                        continue
                    if Hidden.SINGULARITY in hidden and several_meet(self.path, point, next_point):
                        raise self._ended(point, "bifurcation", SEVERAL)
                step = min(longest, 2.0 * max(2.0 * half, step))
                before, point = point, next_point
            self._keep(point)
        return point

    @on_one_blas_thread
    def _by_arc_length(self, point: Point) -> Point:
        """Steps by arc length, from a point beyond which no step at a fraction succeeds.

        Long, as whatever a step may come to is told apart in order.

        Returns:
            The point from where steps at fractions can go on; past folds the last one on the way.
        """
        path, first = self.path, point
        tangent = path.tangent(point)
        arc, before, length_before = FIRST_ARC, None, 0.0
        most = MOST_ARCS_PAST_FOLDS if self.past_folds else MOST_ARCS
        for _ in range(most):
            next_point, end, length = along(path, point, tangent, arc), None, arc
            if next_point is not None and not 0.0 <= next_point.fraction < 1.0:
                end = 1.0 if next_point.fraction >= 1.0 else 0.0
                onto = landing(path, point, tangent, arc, end)
                length = 0.0 if onto is None else onto
                next_point = None if onto is None else along(path, point, tangent, length)
            if next_point is None:
                arc *= 0.5
                if arc < SMALLEST_ARC:
                    raise self._lost(first, point)
                continue
            if differ(point, next_point):
                bracket = bracket_by_arc_length(path, point, tangent, arc, next_point)
                if bracket is None:  # the step had jumped to another branch
                    arc *= 0.25
                    if arc < SMALLEST_ARC:
                        raise self._lost(first, point)
                    continue
                low, high, beyond = bracket
                if low.fraction > 1.0 and arc > SMALLEST_ARC:
                    arc *= 0.5  # it happens beyond the end, which was stepped over
                    continue
                if low.index != high.index or low.sign != high.sign:
                    bound = VANISHED if low.index == high.index else SINGULAR
                    if several_cross(self.path, low, bound):
                        raise self._ended_at_crossing(low, point, SEVERAL)
                self._note(low, high)
                if differ(high, next_point):  # something more happens within the step
                    next_point, end = beyond, None
                before = None
            elif (
                before is not None
                and length > FIRST_ARC * SMALLEST_STEP
                and hidden_between(
                    (-length_before, 0.0, length),
                    (before.watched, point.watched, next_point.watched),
                )
            ):
                arc = 0.5 * length
                continue
            else:
                before, length_before = point, length
            if not self.past_folds:
                self._keep_between(point, next_point)
            point, tangent = next_point, next_point.tangent or path.tangent(next_point, tangent)
            self._keep(point, every=self.past_folds)
            arc = min(LONGEST_ARC, 1.5 * arc)
            if end is not None:
                point = path.at(point, end) or point
                if end == 0.0:
                    raise self._ended(point, "fold", "the branch leads back to where the way began")
                if self.past_folds:
                    self.points[-1] = point
                return point
            if (
                not self.past_folds
                and point.fraction > first.fraction
                and self._regular(point, tangent)
            ):
                return point
        farther = f"it is farther than {most} steps along the branch"
        taut = taut_legs(point.equilibrium)
        raise self._ended(point, "lost", f"{farther} ({taut})" if taut else farther)

    def _regular(self, point: Point, tangent: Tangent) -> bool:
        """Whether a step at a fraction is possible again, as long as the one that had failed."""
        ahead = min(1.0, point.fraction + 10.0 * SMALLEST_STEP * self.longest)
        next_point = self.path.at(point, ahead) if tangent.fraction > 0.0 else None
        if next_point is None or differ(point, next_point):
            return False
        # Near a fold the same step may have led to the other arm of the branch.
        back = self.path.at(next_point, point.fraction)
        return back is not None and distance(point, back) < SAME_PLACE

    def _note(self, low: Point, high: Point) -> None:
        """Note what happens between two neighbours; a limit, a fold or instability may end the walk."""
        event = event_between(self.path, low, high)
        if event is None:
            return
        self.events.append(event)
        limit = limit_passed(low, high)
        if limit is not None:
            self.violation = limit, high.equilibrium
        unstable = self.stable_only and high.index > 0
        if limit is not None or unstable or (event.kind == "fold" and not self.past_folds):
            raise _Ended

    def _keep_between(self, point: Point, next_point: Point) -> None:
        """Keep the points asked for that a step by arc length passes."""
        while self.keep and point.fraction < self.keep[0] < next_point.fraction:
            between = self.path.at(point, self.keep[0])
            if between is None or differ(point, between):
                between = self.path.at(next_point, self.keep[0])
                if between is None or differ(between, next_point):
                    return  # next to where something happens: the next one is kept in its place
            self._keep(between)

    def _keep(self, point: Point, every: bool = False) -> None:
        """Keep a point that was asked for, and tell how far it is."""
        self.reached = point
        if every or (self.keep and point.fraction >= self.keep[0] - 1e-15):
            self.points.append(point)
            while self.keep and self.keep[0] <= point.fraction + 1e-15:
                self.keep.pop(0)
        if self.progress is not None:
            self.progress(point.fraction)

    def _lost(self, first: Point, last: Point) -> _Ended:
        """The end where no step succeeds."""
        drawn_in = last.equilibrium.robot.fed_rods.drawn_in(last.equilibrium.motors)
        if drawn_in:
            return self._ended(last, "lost", drawn_in)
        if not crossing_ways(self.path, last):
            return self._ended(last, "lost", "no equilibrium is near the last one on the way")
        return self._ended_at_crossing(last, first, "branches cross, none of them goes straight on")

    def _ended_at_crossing(self, crossing: Point, known: Point, text: str) -> _Ended:
        """The end where branches cross, with the last equilibrium that is well told from others."""
        return self._ended(replace(crossing, equilibrium=known.equilibrium), "bifurcation", text)

    def _ended(self, last: Point, kind: EventKind, text: str) -> _Ended:
        """The end at a point, for what happens there."""
        index = last.index
        self.events.append(PathEvent(kind, last.fraction, last.equilibrium, index, index, text))
        return _Ended()
