# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether motors may go straight to another equilibrium, through which halts do not guard. No ROS here.

A solution that is applied may have been found from anywhere. The motors go to it from where they are
commanded, and what the robot does on that way has nothing to do with how the solution was found.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

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

from ..error_codes import RequestError
from .deadline import Deadline
from .goals import largest_way
from .motion_settings import ON_WAY_TO_MOTORS
from .motor_path import MotorPath
from .steps import change_between
from .trajectory_order import TrajectoryRefused
from .trajectory_plan import TrajectoryPlan

__all__ = ["check_straight_way"]

Floats = NDArray[np.float64]

#: Measures are looked at this often on the way [rad, rod lengths].
_LOOK = 0.02


def check_straight_way(
    start: Assessment,
    commands: Floats,
    target: Equilibrium,
    thresholds: Thresholds,
    deadline: Deadline,
) -> None:
    """Whether the commands lead from where they are to an equilibrium, straight in the motors.

    The loads of the target act on all of the way.

    Args:
        start: Where the node has the robot, on the branch it is on.
        commands: Where the motors are commanded, (n,) [rad or m].
        target: Where they are to go.
        thresholds: Of every measure; none that gets worse may fall below its stop.
        deadline: When it has to be found out.

    Raises:
        RequestError: They do not, or that was not found out in time.
    """
    if np.array_equal(commands, target.motors):
        return
    path, first = _path([start.equilibrium.motors, commands, target.motors], start)
    try:
        begin = _under_loads_of(target, start, deadline)
    except TimeLimitExceeded:
        raise _too_late("its loads acted where the motors are") from None
    except CprError as error:
        raise _refused(f"where the robot is: {error}") from None
    watched = ON_WAY_TO_MOTORS  # a stride ends with the deadline, too
    plan = TrajectoryPlan(path, begin, 1.0, thresholds, watched, lambda: deadline.left)
    plan.advance(deadline.left)
    if plan.refused is not None and plan.refused.measure != "time_limit":
        raise _refused(_where(plan.refused, path, first))
    if not plan.done:
        raise _too_late("the way of the motors to it was followed to its end")
    if change_between(plan.last.equilibrium, target) > SAME_EQUILIBRIUM:
        raise _refused("it leads to another equilibrium at these motors")


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


def _refused(why: str) -> RequestError:
    text = f"apply: the motors would go straight to it, but {why}; go there by setpoints"
    return RequestError(ErrorCode.INVALID_MOTION_PLAN, text)


def _too_late(what: str) -> RequestError:
    return RequestError(ErrorCode.TIMED_OUT, f"apply: time_limit was over before {what}")


def _where(refused: TrajectoryRefused, path: MotorPath, first: float) -> str:
    """What stands against the way and after how much of it, from the commands on."""
    part = max(0.0, refused.time - first) / (path.end - first)
    return f"after {100.0 * part:.0f} % of the way: {refused.why}"
