# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A whole trajectory solved before its first step, a little at a time. No rclpy here."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Equilibrium, Trace, trace_through
from cpr_core.errors import distinct
from cpr_core.model.assessment import MEASURES, Assessment, Thresholds

from .motor_path import MotorPath
from .steps import falls
from .supervision import FIELDS
from .trajectory_order import TrajectoryRefused

__all__ = ["TrajectoryPlan"]

Floats = NDArray[np.float64]

#: Ticks that are solved in one go at most: 0.3 s at 200 Hz, in about two milliseconds.
_STRIDE = 60
#: Ticks that are solved first: they tell how long one takes.
_FIRST_STRIDE = 10
#: Longest time for a stride [s]: half of what the stability stream may be silent.
_LONGEST = 0.05
#: Part of it that a stride is expected to take at most; robots with many modes are slow.
_EXPECTED = 0.5
#: How many times in a row a stride may be over without a tick solved: a busy machine takes time away,
#: too.
_FRUITLESS = 10
#: A motor turns back if it moves back by more than this [rad, rod lengths]: one that rests may be
#: noisy.
_NOISE = 1e-5
#: Measures that are looked at in every tick, of all ticks at once.
_OF_MOTORS = ("motor_range", "effort_reserve")
#: Reasons of what stops a walk: the measure of which nothing is left, if it is one.
_EVENTS = {measure.event: name for name, measure in MEASURES.items() if measure.event} | {
    "time_limit": "time_limit"
}


class TrajectoryPlan:
    """Equilibria at every tick of a path, and whether the robot may be moved through them.

    Branch, stability index and limits are looked at in every tick, other measures at the ends of every
    stride, where a motor turns back, and in the middle between these; where they could fall below their
    stop threshold in between, down to every tick.

    Attributes:
        path: The path.
        done: Whether all of it is solved.
        refused: Why the robot must not follow it, if so.
        work: Processor time it has taken so far [s].
        begun: How many ticks are solved, or being solved.
        last: The last equilibrium that was judged.
    """

    def __init__(
        self,
        path: MotorPath,
        start: Assessment,
        period: float,
        thresholds: Thresholds,
        watched: Collection[str],
        longest_stride: Callable[[], float] = lambda: _LONGEST,
    ) -> None:
        """Begin, without solving anything.

        Args:
            path: The path.
            start: Equilibrium at its beginning.
            period: Time of a tick [s].
            thresholds: Of the measures.
            watched: Measures that count.
            longest_stride: How long the next stride may take [s].
        """
        self._longest_stride = longest_stride
        self.path, self.done, self.work, self.begun = path, False, 0.0, 0
        self.refused: TrajectoryRefused | None = None
        self._start, self._thresholds, self.last = start, thresholds, start
        limited = _OF_MOTORS if start.equilibrium.robot.limited_motors else ()
        self._of_motors = tuple(name for name in watched if name in limited)
        self._others = tuple(name for name in watched if name not in _OF_MOTORS)
        self._times = _ticks(path, period)
        self._strides = self._solved()

    @property
    def ticks(self) -> int:
        """How many equilibria are needed."""
        return len(self._times)

    def advance(self, seconds: float = math.inf) -> None:
        """Go on for some time, and at least a little: solve a stride, or judge some of it."""
        begin, work = time.perf_counter(), time.thread_time()
        while not self.done and self.refused is None:
            try:
                self.done = next(self._strides, None) is None
            except TrajectoryRefused as refused:
                self.refused = refused
            except CprError as error:
                self.refused = TrajectoryRefused(self.path.begin, "not_converged", str(error))
            if time.perf_counter() - begin >= seconds:
                break
        self.work += time.thread_time() - work

    def _solved(self) -> Iterator[bool]:
        """Solve and judge stride after stride.

        Raises:
            TrajectoryRefused: The robot must not follow it.
        """
        last, begin, first, fruitless = self._start, self.path.begin, 0, 0
        stride = _FIRST_STRIDE
        while first < len(self._times):
            times = self._times[first : first + stride]
            self.begun = first + len(times)
            since = time.perf_counter()
            found = self._traced(last.equilibrium, times)
            tick_work = (time.perf_counter() - since) / max(1, len(found.equilibria))
            stride = max(1, min(_STRIDE, int(_EXPECTED * _LONGEST / tick_work)))
            yield True
            stopped, equilibria = found.stopped, list(found.equilibria)
            if equilibria:
                self._check_indices(equilibria, times)
                if self._of_motors:
                    self._check_motors(last, equilibria, times)
                assessed = [last, *map(self._assessed, equilibria)]
                ticks = np.concatenate([[begin], times[: len(equilibria)]])
                ways = self.path.positions(ticks) / last.equilibrium.robot.motor_units
                for start, end in itertools.pairwise(_turns(ways)):
                    yield from self._checked_between(assessed, ticks, start, end)
                last, begin = assessed[-1], float(ticks[-1])
                self.last = last
            first += len(equilibria)
            fruitless = 0 if equilibria else fruitless + 1
            goes_on = stopped is None or (stopped.kind == "time_limit" and fruitless < _FRUITLESS)
            if stopped is not None and not goes_on:
                measure = _EVENTS.get(stopped.kind, "not_converged")
                raise _refused(float(self._times[first]), measure, stopped.message)
            yield True

    def _assessed(self, equilibrium: Equilibrium) -> Assessment:
        return Assessment(equilibrium, self._start.characteristic_length)

    def _traced(self, start: Equilibrium, times: Floats) -> Trace:
        return trace_through(
            start.robot,
            motors=self.path.positions(times),
            start=start,
            singularities=False,
            time_limit=self._longest_stride(),
        )

    def _check_indices(self, found: Sequence[Equilibrium], times: Floats) -> None:
        unstable = np.flatnonzero([equilibrium.index_locked > 0 for equilibrium in found])
        if unstable.size:
            why = "the robot would be unstable with the motors held"
            raise _refused(float(times[unstable[0]]), "margin", why)

    def _check_motors(self, last: Assessment, found: Sequence[Equilibrium], times: Floats) -> None:
        limits = last.equilibrium.robot.motor_limits
        motors = np.array([equilibrium.motors for equilibrium in found])
        left = limits.left(motors, np.array([equilibrium.efforts for equilibrium in found]))
        values = {
            "motor_range": left[:, ~limits.of_effort].min(axis=1, initial=np.inf),
            "effort_reserve": left[:, limits.of_effort].min(axis=1, initial=np.inf),
        }
        for name in self._of_motors:
            before = np.concatenate([[last.value(name)], values[name][:-1]])
            for number in np.flatnonzero(~(values[name] >= self._thresholds[name].stop)):
                first, value = float(before[number]), float(values[name][number])
                self._check_fall(name, first, value, float(times[number]))

    def _checked_between(
        self, stride: list[Assessment], times: Floats, first: int, last: int
    ) -> Iterator[bool]:
        """What costs more, at the ends and in the middle of a part of a stride; in all of it if needed.

        No motor turns back within the part.
        """
        yield True
        middle = (first + last) // 2
        looks = [stride[first], stride[middle], stride[last]]
        if middle > first and any(self._may_fall(name, looks) for name in self._others):
            yield from self._checked_between(stride, times, first, middle)
            yield from self._checked_between(stride, times, middle, last)
        else:
            for name in self._others:
                before, after = stride[first].value(name), stride[last].value(name)
                self._check_fall(name, before, after, float(times[last]))

    def _may_fall(self, name: str, looks: Sequence[Assessment]) -> bool:
        """Whether a measure may be below its stop threshold between: as far below as it changes."""
        values = [look.value(name) for look in looks]
        if any(map(math.isnan, values)):
            return True
        lowest, highest = min(values), max(values)
        return not 2.0 * lowest - highest >= self._thresholds[name].stop and lowest != highest

    def _check_fall(self, name: str, before: float, after: float, at: float) -> None:
        stop = self._thresholds[name].stop
        if math.isnan(after) or (after < stop and falls(before, after)):
            value, limit = distinct(after, stop)
            why = f"{FIELDS[name]} would be {value}, below {name}_stop {limit}"
            if math.isnan(after):
                why = f"{FIELDS[name]} would not be defined"
            raise _refused(at, name, why)


def _refused(at: float, measure: str, why: str) -> TrajectoryRefused:
    """The refusal of a trajectory for what a measure would be at a time [s]."""
    return TrajectoryRefused(at, measure, f"at {at:.3f} s: {why}", why)


def _turns(motors: Floats) -> list[int]:
    """Rows of motors, (T, n) [rad, rod lengths], at which one turns back; the first and last row too."""
    turns = {0, len(motors) - 1}
    for places in motors.T.tolist():
        farthest, direction = 0, 0.0  # row until which the motor went on in this direction
        for row, place in enumerate(places):
            way = place - places[farthest]
            if way * direction > 0.0:
                farthest = row
            elif abs(way) > _NOISE:
                turns.add(farthest)
                farthest, direction = row, way
    return sorted(turns)


def _ticks(path: MotorPath, period: float) -> Floats:
    """Times of the ticks of a path, its end among them."""
    count = max(1, math.ceil((path.end - path.begin) / period - 1e-6))
    return np.minimum(path.begin + period * np.arange(1, count + 1), path.end)
