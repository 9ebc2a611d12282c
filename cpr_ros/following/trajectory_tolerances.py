# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether motors are as near to a trajectory as its order wants, sent and measured. No rclpy here.

Commands show how much slower it has been than ordered. Motors that are measured may lag behind their
commands, or not follow them at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpr_core.errors import distinct

from .measured_motors import SeenMotors
from .motor_path import MotorPath
from .moved_by_others import SETTLING
from .trajectory_order import TrajectoryOrder

__all__ = ["BrokenTolerance", "TrajectoryTolerances"]

Floats = NDArray[np.float64]

#: How late a command may come [ticks].
_LATE_TICKS = 2.0


class BrokenTolerance(NamedTuple):
    """A tolerance that does not hold.

    Attributes:
        name: Field of the order.
        text: Why, for a person.
    """

    name: str
    text: str


@dataclass(frozen=True, eq=False)
class TrajectoryTolerances:
    """What a trajectory allows its motors.

    Attributes:
        motor_names: Of the robot.
        order: What was ordered.
        path: The path that is followed.
        period: Time of a tick [s].
    """

    motor_names: tuple[str, ...]
    order: TrajectoryOrder
    path: MotorPath
    period: float

    def arrived(self, seen: SeenMotors) -> bool:
        """Whether motors that are measured are as near to the end as the order wants."""
        tolerance = self.order.goal_tolerance
        if seen.measured is None:
            return not seen.missing or not np.any(np.isfinite(tolerance))
        return not np.any(np.abs(self.path.last - seen.measured.motors) > tolerance)

    def broken(self, due: float, commands: Floats, seen: SeenMotors) -> BrokenTolerance | None:
        """Which tolerance does not hold; None: all hold.

        Args:
            due: Time of the trajectory, had it never been slowed down [s].
            commands: Where the motors are sent, (n,) [rad or m].
            seen: Where they are measured.
        """
        allowed = self.order.goal_time_tolerance
        found = self._broken_by(
            commands, due, longest=max(allowed, _LATE_TICKS * self.period), measured=False
        )
        if found is not None:
            return found
        longest = max(allowed if math.isfinite(allowed) else 0.0, SETTLING)
        if seen.measured is None:
            return self._unknown(due, seen.missing, longest) if seen.missing else None
        motors, age = seen.measured  # before it began they have to be where it begins
        return self._broken_by(motors, max(due - age, 0.0), longest=longest, measured=True)

    def _unknown(self, due: float, missing: str, longest: float) -> BrokenTolerance | None:
        """Which tolerance nobody can vouch for, as the motors are not measured any more."""
        order = self.order
        if due <= order.duration:
            name, tolerance = "path_tolerance", order.path_tolerance
        else:
            name, tolerance = self._name_at_end, order.goal_tolerance
            if due - order.duration <= longest:
                return None
        if not np.any(np.isfinite(tolerance)):
            return None
        text = f"at {due:.3f} s nobody knows how near the motors are: {missing}"
        return BrokenTolerance(name, text)

    def _broken_by(
        self, motors: Floats, due: float, *, longest: float, measured: bool
    ) -> BrokenTolerance | None:
        """Which tolerance motors do not hold.

        Args:
            motors: Where they are, or are sent, (n,) [rad or m].
            due: At which time of the trajectory [s].
            longest: How late they may be at its end [s].
            measured: Whether they are measured there.
        """
        order, told = self.order, "measured " if measured else ""
        if due <= order.duration:
            error = np.abs(self.path.at(due).positions - motors)
            for number in np.flatnonzero(error > order.path_tolerance):
                away, allowed = distinct(float(error[number]), float(order.path_tolerance[number]))
                text = (
                    f"at {due:.3f} s {self.motor_names[number]} is {told}{away} from where the "
                    f"trajectory has it, its tolerance is {allowed}"
                )
                return BrokenTolerance("path_tolerance", text)
            return None
        late = due - order.duration
        if late <= longest:
            return None
        tolerance = order.goal_tolerance
        if not measured:  # who wants the end in time wants the motors sent exactly there
            tolerance = np.where(np.isfinite(tolerance), tolerance, 0.0)
        error = np.abs(self.path.last - motors)
        for number in np.flatnonzero(error > tolerance):
            away, allowed = distinct(float(error[number]), float(tolerance[number]))
            after, time = distinct(late, longest)
            text = (
                f"{self.motor_names[number]} is {told}{away} from the end {after} s after it was due: "
                f"its tolerance is {allowed}, and allowed are {time} s"
            )
            return BrokenTolerance(self._name_at_end, text)
        return None

    @property
    def _name_at_end(self) -> str:
        """The tolerance that does not hold where the end is not reached."""
        in_time = math.isfinite(self.order.goal_time_tolerance)
        return "goal_time_tolerance" if in_time else "goal_tolerance"
