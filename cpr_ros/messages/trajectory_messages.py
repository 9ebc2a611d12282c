# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Timed trajectories from messages, checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from builtin_interfaces.msg import Time
from cpr_msgs.msg import ErrorCode
from numpy.typing import NDArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from cpr_core import InvalidRequest, Robot
from cpr_core.description.doubted_requests import motors_doubt
from cpr_core.errors import distinct
from cpr_core.kernels.limit_kernel import ROUNDING
from cpr_core.solving.targets import check_rod_lengths
from cpr_core.validation import checked_vector

from ..error_codes import RequestError
from ..following.measured_range import BESIDE
from ..following.trajectory_order import TrajectoryOrder, TrajectoryRefused
from .motor_messages import check_names
from .trajectory_points import seconds_of

__all__ = ["AllowedErrors", "trajectory_order"]

Floats = NDArray[np.float64]

#: A velocity that is rounding where a trajectory ends at rest [rad/s, m/s].
_RESTING = 1e-6
#: More points than this are refused: looking at them would hold up the node.
_MOST_POINTS = 10_000


class AllowedErrors(NamedTuple):
    """What who orders a trajectory allows, in the order of its joint names; 0, or none at all: any.

    Attributes:
        path_tolerance: On the way, (n,) [rad or m].
        goal_tolerance: At the end, (n,) [rad or m].
        goal_time_tolerance: How much later the end may be reached [s].
    """

    path_tolerance: Sequence[float] = ()
    goal_tolerance: Sequence[float] = ()
    goal_time_tolerance: float = 0.0


_ANY = AllowedErrors()


def trajectory_order(
    robot: Robot,
    message: JointTrajectory,
    now: Time,
    allowed: AllowedErrors = _ANY,
) -> TrajectoryOrder:
    """What a trajectory asks for, in motor order. One without points asks to hold.

    Args:
        robot: The robot.
        message: The trajectory.
        now: ROS time; 0: there is none yet, as no /clock has come.
        allowed: By who orders it.

    Raises:
        InvalidRequest: Names wrong, missing or twice, or not as many numbers as names.
        NonFiniteInput: A NaN or an infinity.
        TrajectoryRefused: Points that cannot be followed by any robot, motors beyond their ranges, or a
            stamp while there is no ROS time.
    """
    names, points = list(message.joint_names), list(message.points)
    if not points:
        nothing, free = np.zeros((0, robot.motor_count)), np.full(robot.motor_count, np.inf)
        return TrajectoryOrder(
            times=np.zeros(0),
            positions=nothing,
            velocities=None,
            accelerations=None,
            start_in=None,
            path_tolerance=free,
            goal_tolerance=free,
            goal_time_tolerance=np.inf,
        )
    check_names(names, list(robot.motor_names), "joint_names", "expected every motor once")
    if len(points) > _MOST_POINTS:
        raise InvalidRequest(
            "points", f"expected no more than {_MOST_POINTS} points, got {len(points)}"
        )
    order = [names.index(name) for name in robot.motor_names]
    times = np.array([seconds_of(point.time_from_start) for point in points])
    _check_times(times)
    positions, velocities, accelerations = _columns(names, points, times)
    positions = _within_ranges(robot, times, positions[:, order])
    if not 0.0 <= allowed.goal_time_tolerance < np.inf:
        raise RequestError(
            ErrorCode.INVALID_ROBOT_STATE,
            f"goal_time_tolerance: expected at least 0, got {allowed.goal_time_tolerance}",
        )
    return TrajectoryOrder(
        times=times,
        positions=positions,
        velocities=None if velocities is None else velocities[:, order],
        accelerations=None if accelerations is None else accelerations[:, order],
        start_in=_start_in(message.header.stamp, now),
        path_tolerance=_tolerances("path_tolerance", allowed.path_tolerance, names)[order],
        goal_tolerance=_tolerances("goal_tolerance", allowed.goal_tolerance, names)[order],
        goal_time_tolerance=allowed.goal_time_tolerance or np.inf,
    )


def _start_in(begun: Time, now: Time) -> float | None:
    """When a trajectory starts, from now [s]; None: at once.

    Raises:
        TrajectoryRefused: There is no ROS time to compare with.
    """
    if not seconds_of(begun):
        return None
    if not seconds_of(now):
        raise TrajectoryRefused(
            0.0,
            "header.stamp",
            "header.stamp: expected 0 as long as no /clock has come, "
            f"got {seconds_of(begun):.10g} s",
        )
    return (begun.sec - now.sec) + 1e-9 * (begun.nanosec - now.nanosec)


def _columns(
    names: list[str], points: list[JointTrajectoryPoint], times: Floats
) -> tuple[Floats, Floats | None, Floats | None]:
    """Positions, and velocities and accelerations if there are any, (P, n), in the order of the names.

    Raises:
        InvalidRequest: Efforts, accelerations without velocities, or not as many numbers as names.
        NonFiniteInput: A NaN or an infinity.
        TrajectoryRefused: The end is not at rest.
    """
    positions = _column(names, points, "positions", needed=True)
    velocities = _column(names, points, "velocities")
    accelerations = _column(names, points, "accelerations")
    for number, point in enumerate(points):
        if len(point.effort):
            raise InvalidRequest(
                f"points[{number}].effort", "expected none: motors are moved by position"
            )
    assert positions is not None
    if accelerations is not None and velocities is None:
        raise InvalidRequest("points[0].velocities", "expected some where accelerations are given")
    if velocities is not None:
        velocities = _ending_at_rest(names, times, velocities)
    return positions, velocities, accelerations


def _ending_at_rest(names: list[str], times: Floats, velocities: Floats) -> Floats:
    """The same velocities, (P, n), without what sines and cosines leave of the zeros at the end.

    Raises:
        TrajectoryRefused: There a motor still moves.
    """
    fastest = int(np.argmax(np.abs(velocities[-1])))
    speed = float(velocities[-1, fastest])
    if abs(speed) > _RESTING:
        raise TrajectoryRefused(
            float(times[-1]),
            "points",
            "expected a trajectory that ends at rest, at its last point "
            f"{names[fastest]} has a velocity of {speed:.6g}",
        )
    return np.vstack([velocities[:-1], np.zeros(len(names))])


def _tolerances(field: str, values: Sequence[float], names: Sequence[str]) -> Floats:
    """Tolerances in the order of the names, (n,), infinite where any is allowed.

    Raises:
        InvalidRequest: Not as many as names, or a negative one.
        NonFiniteInput: A NaN or an infinity.
    """
    if not len(values):
        return np.full(len(names), np.inf)
    found = checked_vector(field, values, len(names), " ".join(names))
    if np.any(found < 0.0):
        raise InvalidRequest(field, f"expected numbers of at least 0, got {found.tolist()}")
    return np.where(found == 0.0, np.inf, found)


def _check_times(times: Floats) -> None:
    if times[0] < 0.0:
        raise TrajectoryRefused(
            float(times[0]),
            "points",
            f"points[0].time_from_start: expected at least 0, got {times[0]:g} s",
        )
    for number in np.flatnonzero(np.diff(times) <= 0.0) + 1:
        before, time = distinct(float(times[number - 1]), float(times[number]), fewest=6)
        raise TrajectoryRefused(
            float(times[number]),
            "points",
            f"points[{number}].time_from_start: expected more than the {before} s of the "
            f"point before, got {time} s",
        )


def _within_ranges(robot: Robot, times: Floats, positions: Floats) -> Floats:
    """Positions, (P, n), those that are hardly beyond a range at its end.

    A pose may leave a motor beyond it by the accuracy of a solution, and joint states say so. Where the
    first point is due at the beginning it says where the robot is, as encoders may see it.

    Raises:
        TrajectoryRefused: A point is farther beyond.
    """
    found, hardly = positions.copy(), np.full(len(times), ROUNDING)
    hardly[times == 0.0] = BESIDE
    for number, motor in robot.limited_motors:
        lower, upper = motor.limits.lower, motor.limits.upper
        found[:, number] = np.clip(positions[:, number], lower, upper)
        beyond = np.abs(positions[:, number] - found[:, number])
        for row in np.flatnonzero(beyond > hardly * robot.motor_units[number]):
            told = distinct(float(positions[row, number]), lower, upper, fewest=6)
            doubt = motors_doubt(robot.description, positions[row], [])
            raise TrajectoryRefused(
                float(times[row]),
                "motor_range",
                f"points[{row}].positions: expected {motor.name} within [{told[1]}, {told[2]}] "
                f"{motor.unit}, got {told[0]}" + (f"; {doubt}" if doubt else ""),
            )
    check_rod_lengths(robot, found)
    return found


def _column(
    names: list[str], points: list[Any], field: str, *, needed: bool = False
) -> Floats | None:
    """One kind of numbers of all points, (P, n), in the order of the names; None: not given."""
    given = [getattr(point, field) for point in points]
    counts = set(map(len, given))
    if not needed and counts == {0}:
        return None
    if counts == {len(names)}:  # all at once: one by one ten thousand take 0.03 s
        rows = np.frombuffer(b"".join(given)).reshape(len(points), len(names))
        if np.isfinite(rows).all():
            return rows
    return np.array(
        [
            checked_vector(f"points[{number}].{field}", values, len(names), " ".join(names))
            for number, values in enumerate(given)
        ]
    )
