# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether motors are as near to a trajectory as its order wants, sent and measured. No rclpy here.

Commands show how much slower it has been than ordered. Motors that are measured may lag behind their
commands, or not follow them at all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cpr_core.errors import distinct

from .measured_motors import MotorMeasurement
from .motor_path import MotorPath
from .moved_by_others import SETTLING
from .trajectory_order import TrajectoryOrder

__all__ = ["arrived", "broken_tolerance"]

Floats = NDArray[np.float64]

#: Ticks that a command may come late.
_LATE_TICKS = 2.0


def arrived(
    order: TrajectoryOrder, path: MotorPath, measured: MotorMeasurement | None, missing: str
) -> bool:
    """Whether motors that are measured are as near to the end as the order wants.

    Args:
        order: What was ordered.
        path: The path that is followed.
        measured: Where the motors were measured; None: nobody knows.
        missing: Why nobody knows, though they are measured; empty: nobody measures.
    """
    if measured is None:
        return not missing or not np.any(np.isfinite(order.goal_tolerance))
    return not np.any(np.abs(path.last - measured.motors) > order.goal_tolerance)


def broken_tolerance(
    names: Sequence[str],
    order: TrajectoryOrder,
    path: MotorPath,
    due: float,
    commands: Floats,
    measured: MotorMeasurement | None,
    missing: str,
    period: float,
) -> tuple[str, str] | None:
    """Which tolerance does not hold, and why in words; None: all hold.

    Args:
        names: Of the motors.
        order: What was ordered.
        path: The path that is followed.
        due: Its time, had it never been slowed down [s].
        commands: Where the motors are sent, (n,) [rad or m].
        measured: Where they were measured; None: nobody knows.
        missing: Why nobody knows, though they are measured; empty: nobody measures.
        period: Time of a tick [s].
    """
    longest = max(order.goal_time_tolerance, _LATE_TICKS * period)
    found = _broken(names, order, path, due, commands, "", longest)
    if found is not None:
        return found
    own = order.goal_time_tolerance if math.isfinite(order.goal_time_tolerance) else 0.0
    longest = max(own, SETTLING)
    if measured is None:
        return _unknown(order, due, missing, longest) if missing else None
    told = "measured "
    return _broken(names, order, path, due - measured.age, measured.motors, told, longest)


def _unknown(
    order: TrajectoryOrder, due: float, missing: str, longest: float
) -> tuple[str, str] | None:
    """Which tolerance nobody can vouch for, as the motors are not measured any more."""
    if due <= order.duration:
        measure, tolerance = "path_tolerance", order.path_tolerance
    else:
        measure, tolerance = _of_the_end(order), order.goal_tolerance
        if due - order.duration <= longest:
            return None
    if not np.any(np.isfinite(tolerance)):
        return None
    return measure, f"at {due:.3f} s nobody knows how near the motors are: {missing}"


def _broken(
    names: Sequence[str],
    order: TrajectoryOrder,
    path: MotorPath,
    due: float,
    motors: Floats,
    told: str,
    longest: float,
) -> tuple[str, str] | None:
    """The same of motors, (n,), at a time; ``longest`` is how late they may be at the end [s]."""
    if due <= order.duration:
        error = np.abs(path.at(due)[0] - motors)
        for number in np.flatnonzero(error > order.path_tolerance):
            away, allowed = distinct(float(error[number]), float(order.path_tolerance[number]))
            return "path_tolerance", (
                f"at {due:.3f} s {names[number]} is {told}{away} from where the trajectory has it, "
                f"its tolerance is {allowed}"
            )
        return None
    late = due - order.duration
    if late <= longest:
        return None
    exact = np.where(np.isfinite(order.goal_tolerance), order.goal_tolerance, 0.0)
    tolerance = order.goal_tolerance if told else exact  # who wants it in time wants it sent there
    error = np.abs(path.last - motors)
    for number in np.flatnonzero(error > tolerance):
        away, allowed = distinct(float(error[number]), float(tolerance[number]))
        after, time = distinct(late, longest)
        return _of_the_end(order), (
            f"{names[number]} is {told}{away} from the end {after} s after it was due: its tolerance is "
            f"{allowed}, and allowed are {time} s"
        )
    return None


def _of_the_end(order: TrajectoryOrder) -> str:
    """The tolerance that does not hold where the end is not reached."""
    return "goal_time_tolerance" if math.isfinite(order.goal_time_tolerance) else "goal_tolerance"
