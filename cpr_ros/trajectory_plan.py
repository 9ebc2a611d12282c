# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A whole trajectory solved before its first step, a little at a time. No ROS here."""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from cpr_core import CprError, Equilibrium, trace_through

from .assessment import Assessment, Thresholds
from .motor_path import MotorPath
from .steps import falls
from .trajectory_order import TrajectoryRefused

__all__ = ["TrajectoryPlan"]

Floats = NDArray[np.float64]

#: Ticks that are solved in one go: a tenth of a second at 200 Hz, in about a millisecond.
_STRIDE = 20
#: Longest time for them [s].
_LONGEST = 0.5
#: Measures that cost little: they are looked at in every tick, where the robot has such limits.
_CHEAP = ("motor_range", "effort_reserve", "strain_reserve")
#: Measures of what stops a walk.
_EVENTS = {
    "motor_limit": "motor_range",
    "effort_limit": "effort_reserve",
    "strain_limit": "strain_reserve",
    "stability": "margin",
    "time_limit": "time_limit",
}


class TrajectoryPlan:
    """Equilibria at every tick of a path, and whether the robot may be moved through them.

    Branch, stability index and limits are looked at in every tick, other measures at the end of every
    stride and, where they could fall below their stop threshold within one, between its ends.

    Attributes:
        path: The path.
        done: Whether all of it is solved.
        refused: Why the robot must not follow it, if so.
        work: Processor time it has taken so far [s].
    """

    def __init__(
        self,
        path: MotorPath,
        start: Assessment,
        period: float,
        thresholds: Thresholds,
        watched: Collection[str],
    ) -> None:
        """Begin, without solving anything.

        Args:
            path: The path.
            start: Equilibrium at its beginning.
            period: Time of a tick [s].
            thresholds: Of the measures.
            watched: Measures that count.
        """
        self.path, self.done, self.work = path, False, 0.0
        self.refused: TrajectoryRefused | None = None
        self._start, self._thresholds = start, thresholds
        limited = _CHEAP if start.equilibrium.robot.limited else ()
        self._cheap = tuple(name for name in watched if name in limited)
        self._dear = tuple(name for name in watched if name not in _CHEAP)
        self._times = _ticks(path, period)
        self._strides = self._solved()

    @property
    def ticks(self) -> int:
        """How many equilibria are needed."""
        return len(self._times)

    def advance(self, seconds: float = math.inf) -> None:
        """Go on for some time, by one stride at least."""
        begin = time.perf_counter()
        while not self.done and self.refused is None:
            try:
                self.done = next(self._strides, None) is None
            except TrajectoryRefused as refused:
                self.refused = refused
            except CprError as error:
                self.refused = TrajectoryRefused(self.path.begin, "not_converged", str(error))
            if time.perf_counter() - begin >= seconds:
                break
        self.work += time.perf_counter() - begin

    def _solved(self) -> Iterator[bool]:
        """Solve and judge stride after stride.

        Raises:
            TrajectoryRefused: The robot must not follow it.
        """
        last, begin = self._start, self.path.begin
        for first in range(0, len(self._times), _STRIDE):
            times = self._times[first : first + _STRIDE]
            found = self._traced(last.equilibrium, times)
            self._check_every(last, found, times)
            stride = [last, *(self._assessed(equilibrium) for equilibrium in found)]
            self._check_between(stride, np.concatenate([[begin], times]), 0, len(stride) - 1)
            last, begin = stride[-1], float(times[-1])
            yield True

    def _assessed(self, equilibrium: Equilibrium) -> Assessment:
        return Assessment(equilibrium, self._start.characteristic_length)

    def _traced(self, start: Equilibrium, times: Floats) -> list[Equilibrium]:
        found = trace_through(
            start.robot,
            motors=self.path.positions(times),
            start=start,
            singularities=False,
            time_limit=_LONGEST,
        )
        if found.stopped is not None:
            at = float(times[min(len(found.equilibria), len(times) - 1)])
            text = f"at {at:.3f} s: {found.stopped.message}"
            raise TrajectoryRefused(at, _EVENTS.get(found.stopped.kind, "not_converged"), text)
        return list(found.equilibria)

    def _check_every(self, last: Assessment, found: list[Equilibrium], times: Floats) -> None:
        """What costs little, in every tick."""
        before, index = last, last.index
        for at, equilibrium in zip(times.tolist(), found, strict=True):
            if equilibrium.index_locked > index:
                text = f"at {at:.3f} s the robot would be unstable with the motors held"
                raise TrajectoryRefused(at, "margin", text)
            index = equilibrium.index_locked
            if self._cheap:
                after = self._assessed(equilibrium)
                self._check_fall(self._cheap, before, after, at)
                before = after

    def _check_between(
        self, stride: list[Assessment], times: Floats, first: int, last: int
    ) -> None:
        """What costs more, at both ends of a part of a stride and, where it is needed, between."""
        open_question = any(
            self._may_fall(name, stride[first], stride[last]) for name in self._dear
        )
        if open_question and last - first > 1:
            middle = (first + last) // 2
            self._check_between(stride, times, first, middle)
            self._check_between(stride, times, middle, last)
        else:
            self._check_fall(self._dear, stride[first], stride[last], float(times[last]))

    def _may_fall(self, name: str, first: Assessment, last: Assessment) -> bool:
        """Whether a measure may be below its stop threshold between: as far below as it changes."""
        one, other = first.value(name), last.value(name)
        lowest = min(one, other) - abs(other - one)
        return not lowest >= self._thresholds[name].stop and one != other

    def _check_fall(
        self, names: Collection[str], before: Assessment, after: Assessment, at: float
    ) -> None:
        for name in names:
            first, last, stop = before.value(name), after.value(name), self._thresholds[name].stop
            if math.isnan(last) or (last < stop and falls(first, last)):
                raise TrajectoryRefused(
                    at,
                    name,
                    f"at {at:.3f} s the {name.replace('_', ' ')} would be {last:.4g}, below its stop "
                    f"threshold {stop:g}",
                )


def _ticks(path: MotorPath, period: float) -> Floats:
    """Times of the ticks of a path, its end among them."""
    count = max(1, math.ceil((path.end - path.begin) / period - 1e-6))
    return np.minimum(path.begin + period * np.arange(1, count + 1), path.end)
