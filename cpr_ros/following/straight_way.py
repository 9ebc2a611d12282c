# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether motors may go straight to another equilibrium: halts do not guard it. No rclpy here.

A solution that is applied may have been found from anywhere. The motors go to it from where they are
commanded, and what the robot does on that way has nothing to do with how the solution was found. So it
is with the way home of a node that was started again.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from cpr_msgs.msg import ErrorCode
from numpy.typing import NDArray

from cpr_core import (
    CprError,
    Equilibrium,
    TimeLimitExceeded,
    solve_forward,
)
from cpr_core.model.assessment import Assessment, Thresholds
from cpr_core.model.configurations import SAME_EQUILIBRIUM
from cpr_core.solving.deadline import Deadline

from ..error_codes import RequestError
from .motion_settings import ON_WAY_TO_MOTORS
from .motor_path import MotorPath
from .motor_ways import largest_way
from .steps import change_between
from .trajectory_order import TrajectoryRefused
from .trajectory_plan import TrajectoryPlan

__all__ = ["Hindrance", "check_straight_way", "hindrance_on_straight_way"]

Floats = NDArray[np.float64]

#: Way between two looks at the measures [rad, rod lengths].
_LOOK = 0.02


@dataclass(frozen=True)
class Hindrance:
    """Why motors may not go straight to an equilibrium.

    Attributes:
        why: What stands against it, and where; what time was over before, if it was.
        too_late: Whether that was not found out in time.
    """

    why: str
    too_late: bool = False


def check_straight_way(
    start: Assessment,
    commands: Floats,
    target: Equilibrium,
    thresholds: Thresholds,
    deadline: Deadline,
) -> None:
    """Whether the commands may go to a solution that is applied.

    Arguments as in :func:`hindrance_on_straight_way`.

    Raises:
        RequestError: They may not, or that was not found out in time.
    """
    hindrance = hindrance_on_straight_way(start, commands, target, thresholds, deadline)
    if hindrance is None:
        return
    if hindrance.too_late:
        text = f"apply: time_limit was over before {hindrance.why}"
        raise RequestError(ErrorCode.TIMED_OUT, text)
    text = f"the motors would go straight to it, but {hindrance.why}; go there by setpoints"
    raise RequestError(ErrorCode.INVALID_MOTION_PLAN, f"apply: {text}")


def hindrance_on_straight_way(
    start: Assessment,
    commands: Floats,
    target: Equilibrium,
    thresholds: Thresholds,
    deadline: Deadline,
) -> Hindrance | None:
    """Why the commands do not lead from where they are to an equilibrium, straight in the motors.

    The loads of the target act on all of the way.

    Args:
        start: Where the node has the robot, on the branch it is on.
        commands: Where the motors are commanded, (n,) [rad or m].
        target: Where they are to go.
        thresholds: Of every measure; none that gets worse may fall below its stop.
        deadline: When it has to be found out.
    """
    if np.array_equal(commands, target.motors):
        return None
    path, first = _path([start.equilibrium.motors, commands, target.motors], start)
    try:
        begin = _under_loads_of(target, start, deadline)
    except TimeLimitExceeded:
        return Hindrance("its loads acted where the motors are", too_late=True)
    except CprError as error:
        return Hindrance(f"where the robot is: {error}")
    watched = ON_WAY_TO_MOTORS  # a stride ends with the deadline, too
    plan = TrajectoryPlan(path, begin, 1.0, thresholds, watched, lambda: deadline.left)
    plan.advance(deadline.left)
    if plan.refused is not None and plan.refused.measure != "time_limit":
        return Hindrance(_where(plan.refused, path, first))
    if not plan.done:
        return Hindrance("the way of the motors to it was followed to its end", too_late=True)
    if change_between(plan.last.equilibrium, target) > SAME_EQUILIBRIUM:
        return Hindrance("it leads to another equilibrium at these motors")
    return None


def _path(corners: Sequence[Floats], start: Assessment) -> tuple[MotorPath, float]:
    """Straight from corner to corner, in whole looks; and when the second one is reached."""
    units = start.equilibrium.robot.motor_units.tolist()
    looks = [
        float(math.ceil(largest_way(before, after, units) / _LOOK))
        for before, after in itertools.pairwise(corners)
    ]
    times = np.cumsum([0.0, *looks])
    kept = [0, *(number for number, count in enumerate(looks, 1) if count)]
    return MotorPath.through(times[kept], np.array(corners)[kept]), looks[0]


def _under_loads_of(target: Equilibrium, start: Assessment, deadline: Deadline) -> Assessment:
    """Where the way begins: the loads of the target act there too."""
    found = start.equilibrium
    if target.loads is not found.loads:
        found = solve_forward(
            found.robot,
            found.motors,
            start=found,
            loads=target.loads,
            stable_only=True,
            time_limit=deadline.left,
        )
    return Assessment(found, start.characteristic_length)


def _where(refused: TrajectoryRefused, path: MotorPath, first: float) -> str:
    """What stands against the way and after how much of it, from the commands on."""
    part = max(0.0, refused.time - first) / (path.end - first)
    return f"after {100.0 * part:.0f} % of the way: {refused.why}"
