# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A trajectory as it was ordered, and the path it makes of where the robot is. No rclpy here."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from cpr_msgs.msg import ErrorCode
from numpy.typing import NDArray

from cpr_core import Robot
from cpr_core.description.doubted_requests import motors_doubt
from cpr_core.errors import distinct, rounded_seconds

from ..error_codes import RequestError
from .motor_path import MotorPath
from .motor_ways import SLACK, motor_steps

__all__ = ["TrajectoryOrder", "TrajectoryRefused", "ordered_path"]

Floats = NDArray[np.float64]

#: How far a first point that is due at once may be from the commands [rad, rod lengths].
NEAR = 0.01
#: How many pieces are searched for their largest speeds at a time: the first one that is too fast
#: ends the search.
_AT_ONCE = 100


class TrajectoryRefused(RequestError):
    """A trajectory that cannot be followed.

    Attributes:
        time: When not, since its start [s].
        measure: Measure that stands against it.
        why: What does, in words without a time.
    """

    def __init__(self, time: float, measure: str, text: str, why: str = "") -> None:
        """Say when and why; where the text has the time in it, also without."""
        self.time, self.measure, self.why = time, measure, why or text
        super().__init__(ErrorCode.INVALID_MOTION_PLAN, text)

    def doubted(self, doubt: str) -> TrajectoryRefused:
        """The same, and what looks like another unit in the trajectory; empty: nothing."""
        if not doubt:
            return self
        return TrajectoryRefused(
            self.time, self.measure, f"{self}; {doubt}", f"{self.why}; {doubt}"
        )


@dataclass(frozen=True, eq=False)
class TrajectoryOrder:
    """A trajectory in motor order, with P points.

    Attributes:
        times: Of the points, since its start, (P,) [s].
        positions: (P, n) [rad or m].
        velocities: (P, n); None: not given.
        accelerations: (P, n); None: not given.
        start_in: When it starts, from now [s]; negative: under way already; None: at once.
        path_tolerance: Largest error on the way, (n,); infinite: any.
        goal_tolerance: Largest error at the end, (n,); infinite: any.
        goal_time_tolerance: How much later than its last point it may end [s]; infinite: any.
    """

    times: Floats
    positions: Floats
    velocities: Floats | None
    accelerations: Floats | None
    start_in: float | None
    path_tolerance: Floats
    goal_tolerance: Floats
    goal_time_tolerance: float

    @property
    def duration(self) -> float:
        """Time of the last point since its start [s]; 0 without points."""
        return float(self.times[-1]) if len(self.times) else 0.0

    def doubt(self, robot: Robot, motors: Floats) -> str:
        """What looks like another unit in its points, seen from motors, (n,); empty: nothing."""
        farthest = np.abs(self.positions - motors).argmax(axis=0)
        points = self.positions[farthest, np.arange(len(motors))]
        return motors_doubt(robot.description, points, [motors])


@np.errstate(over="ignore", invalid="ignore")  # what is no number is too fast
def ordered_path(
    robot: Robot, order: TrajectoryOrder, before: MotorPath, max_speed: float
) -> MotorPath:
    """The path of an order, which begins as another one ends and goes on without a jump.

    The way to the next point has the motors' velocities (and accelerations) at both of its ends, also
    where points are positions only.

    Args:
        robot: The robot.
        order: The order.
        before: What the motors do until then, in time since the start of the order.
        max_speed: Speed no motor exceeds [rad/s, rod lengths/s].

    Raises:
        TrajectoryRefused: It is over by then, begins elsewhere, or is too fast.
    """
    join, (motors, velocity, acceleration) = before.end, before.at_end()
    ahead = order.times > join + 1e-9
    if not ahead.any():
        last = round(order.duration, 9)  # what is due within a nanosecond is due now
        due, now = distinct(last, max(round(join, 9), last), fewest=6)
        raise TrajectoryRefused(
            order.duration,
            "header.stamp" if order.start_in is not None else "points",
            f"expected a point still to come, the last one is due at {due} s and now it "
            f"is {now} s since the start of the trajectory",
        )
    limits = motor_steps(robot, max_speed, 1.0)
    _check_beginning(robot, order, join, motors, limits)
    times = np.concatenate([[join], order.times[ahead]])
    positions = np.vstack([motors, order.positions[ahead]])
    if order.velocities is None:
        path = MotorPath.through(times, positions)
        if np.any(velocity):
            later = path.pieces[1, 1] if len(path.pieces) > 1 else np.zeros_like(velocity)
            bend = MotorPath.through(times[:2], positions[:2], np.vstack([velocity, later]))
            path.pieces[0] = bend.pieces[0]
    else:
        velocities = np.vstack([velocity, order.velocities[ahead]])
        accelerations = (
            None
            if order.accelerations is None
            else np.vstack([acceleration, order.accelerations[ahead]])
        )
        path = MotorPath.through(times, positions, velocities, accelerations)
    _check_speeds(robot, path, limits)
    return before.then(path)


def _check_beginning(
    robot: Robot, order: TrajectoryOrder, join: float, motors: Floats, limits: Floats
) -> None:
    """Whether it is under way near the motors, if it is under way."""
    if order.times[0] > join:
        return
    path = (
        MotorPath.through(order.times, order.positions, order.velocities, order.accelerations)
        if len(order.times) > 1
        else MotorPath.rest(0.0, 1.0, order.positions[0])
    )
    at = path.at(join).positions
    allowed = NEAR * robot.motor_units + limits * (join - order.times[0])
    for number in np.flatnonzero(~(np.abs(at - motors) <= allowed)):
        position, command = distinct(float(at[number]), float(motors[number]), fewest=6)
        raise TrajectoryRefused(
            join,
            "points",
            "expected a trajectory that begins where the motors are commanded to: at "
            f"{rounded_seconds(join)} s {robot.motor_names[number]} would be at {position}, "
            f"its command is {command}",
        )


def _check_speeds(robot: Robot, path: MotorPath, limits: Floats) -> None:
    allowed, bounds = limits * (1.0 + SLACK), path.speed_bounds()
    suspects = np.flatnonzero(~(bounds <= allowed).all(axis=1))
    for some in np.array_split(suspects, math.ceil(len(suspects) / _AT_ONCE) or 1):
        speeds = np.where(np.isfinite(bounds[some]), 0.0, np.inf)
        numbers = np.isfinite(speeds).all(axis=1)
        speeds[numbers] = path.largest_speeds(some[numbers])
        for row, number in np.argwhere(speeds > allowed)[:1]:
            piece = int(some[row])
            motor = robot.description.motors[number]
            limit, speed = distinct(float(limits[number]), float(speeds[row, number]), fewest=6)
            begin, end = (rounded_seconds(float(path.breaks[row])) for row in (piece, piece + 1))
            raise TrajectoryRefused(
                float(path.breaks[piece]),
                "speed",
                f"expected {motor.name} at no more than {limit} {motor.unit}/s, between "
                f"{begin} and {end} s it would have {speed}",
            )
