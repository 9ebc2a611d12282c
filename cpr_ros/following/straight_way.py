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

from cpr_core import CprError, Equilibrium, solve_forward
from cpr_core.model.assessment import MEASURES, Assessment, Thresholds

from ..error_codes import RequestError
from .goals import largest_way
from .motor_path import MotorPath
from .steps import change_between
from .trajectory_order import TrajectoryRefused
from .trajectory_plan import TrajectoryPlan

__all__ = ["check_straight_way"]

Floats = NDArray[np.float64]

#: Measures are looked at this often on the way [rad, rod lengths].
_LOOK = 0.02
#: Equilibria that differ by less are the same, in natural units.
_SAME = 1e-5
_WATCHED = tuple(name for name in MEASURES if name != "inverse_singularity")


def check_straight_way(
    start: Assessment,
    commands: Floats,
    target: Equilibrium,
    thresholds: Thresholds,
    time_limit: float,
) -> None:
    """Whether the commands lead from where they are to an equilibrium, straight in the motors.

    The loads of the target act on all of the way.

    Args:
        start: Where the node has the robot, on the branch it is on.
        commands: Where the motors are commanded, (n,) [rad or m].
        target: Where they are to go.
        thresholds: Of every measure; none that gets worse may fall below its stop.
        time_limit: Longest time it may take to find out [s].

    Raises:
        RequestError: They do not, or that was not found out in time.
    """
    if np.array_equal(commands, target.motors):
        return
    path, first = _path([start.equilibrium.motors, commands, target.motors], start)
    try:
        plan = TrajectoryPlan(path, _under_loads_of(target, start), 1.0, thresholds, _WATCHED)
        plan.advance(time_limit)
    except CprError as error:
        raise _refused(f"where the robot is: {error}") from None
    if plan.refused is not None:
        raise _refused(_where(plan.refused, path, first))
    if not plan.done:
        why = f"apply: the way of the motors to it was not followed to its end in {time_limit:g} s"
        raise RequestError(ErrorCode.TIMED_OUT, why)
    if change_between(plan.last.equilibrium, target) > _SAME:
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


def _under_loads_of(target: Equilibrium, start: Assessment) -> Assessment:
    """Where the way begins: the loads of the target act there too."""
    found = start.equilibrium
    if target.loads is not found.loads:
        found = solve_forward(
            found.robot, found.motors, start=found, loads=target.loads, stable_only=True
        )
    return Assessment(found, start.characteristic_length)


def _refused(why: str) -> RequestError:
    text = f"apply: the motors would go straight to it, but {why}; go there by setpoints"
    return RequestError(ErrorCode.INVALID_MOTION_PLAN, text)


def _where(refused: TrajectoryRefused, path: MotorPath, first: float) -> str:
    """What stands against the way and after how much of it, from the commands on."""
    part = max(0.0, refused.time - first) / (path.end - first)
    return f"after {100.0 * part:.0f} % of the way: {refused.why}"
