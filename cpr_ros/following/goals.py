# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where setpoints send the robot: motor positions, or a pose of the platform."""

from __future__ import annotations

import math
from collections.abc import Hashable
from copy import copy
from typing import NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpr_core import Equilibrium, InvalidRequest, Loads, Robot, solve_forward, solve_inverse
from cpr_core.description.controlled_coordinates import no_inverse_problem
from cpr_core.description.doubted_requests import motors_doubt, position_doubt
from cpr_core.kernels.limit_kernel import ROUNDING
from cpr_core.model.assessment import Assessment
from cpr_core.solving.targets import check_rod_lengths
from cpr_core.validation import checked_vector

from .motor_ways import SLACK, largest_way
from .pose_coordinates import pose_coordinates

__all__ = [
    "Goal",
    "MotorGoal",
    "MotorSetpoint",
    "PoseGoal",
    "whole",
]

Floats = NDArray[np.float64]


class Goal(Protocol):
    """Where to go, and the straight way there."""

    @property
    def destination(self) -> Hashable | None:
        """What it asks for in this tick, equal where it is the same; None: nothing else is the same."""
        ...

    def remaining(self, start: Equilibrium) -> float:
        """Length of the way that is left, in radians and rod lengths; 0 at the goal."""
        ...

    def solve(
        self, start: Equilibrium, fraction: float, loads: Loads, time_limit: float | None = None
    ) -> Equilibrium:
        """The equilibrium at a fraction of the way that is left.

        Raises:
            CprError: There is none on the branch, or none was found in so many seconds.
        """
        ...


class MotorGoal:
    """Motor positions, approached straight in the motor positions.

    Attributes:
        asked: (n,) [rad or m], as they were asked for.
        motors: (n,) [rad or m], within the position limits.
        clipped: Names of the motors whose setpoint was beyond its limits, by more than the accuracy of a
            solution: a pose may leave a motor there.
    """

    def __init__(self, robot: Robot, motors: ArrayLike, where: str = "motors") -> None:
        """Take the nearest motor positions within the limits.

        Args:
            robot: The robot.
            motors: (n,) [rad or m].
            where: Name of the field in error messages.

        Raises:
            InvalidRequest: Not as many numbers as motors, or a rod length of zero or less.
            NonFiniteInput: A NaN or an infinity.
        """
        wanted = checked_vector(where, motors, robot.motor_count, " ".join(robot.motor_names))
        values, beyond = wanted.tolist(), []
        for number, motor in robot.limited_motors:  # numpy takes longer on so few numbers
            within = min(max(values[number], motor.limits.lower), motor.limits.upper)
            if within != values[number]:
                if abs(values[number] - within) > ROUNDING * robot.motor_units[number]:
                    beyond.append(robot.motor_names[number])
                values[number] = within
        self.asked, self.motors, self.clipped = wanted, np.array(values), tuple(beyond)
        check_rod_lengths(robot, self.motors)

    @property
    def destination(self) -> Hashable | None:
        """The motor positions."""
        return "motors", *self.motors.tolist()

    def remaining(self, start: Equilibrium) -> float:
        """Largest way of a motor."""
        return largest_way(start.motors, self.motors, start.robot.motor_units.tolist())

    def doubt(self, start: Equilibrium, before: Goal | None) -> str:
        """What looks like another unit, seen from where the robot is and was sent; empty: nothing."""
        near = [start.motors]
        if isinstance(before, MotorGoal):
            near.append(before.asked)
        return motors_doubt(start.robot.description, self.asked, near)

    def at(self, start: Equilibrium, fraction: float) -> Floats:
        """Motor positions at a fraction of the way that is left, (n,); to the last bit if none is."""
        if fraction == 1.0:
            return self.motors
        begin, end = start.motors, self.motors
        # Rounding moves no motor that stays, and none beyond a limit it is at.
        between = begin + fraction * (end - begin)
        return np.clip(between, np.minimum(begin, end), np.maximum(begin, end))

    def solve(
        self, start: Equilibrium, fraction: float, loads: Loads, time_limit: float | None = None
    ) -> Equilibrium:
        """Forward problem at the motor positions on the way."""
        motors = self.at(start, fraction)
        return solve_forward(start.robot, motors, start=start, loads=loads, time_limit=time_limit)


class MotorSetpoint(MotorGoal):
    """Motor positions of which some came in one message and some in another.

    Attributes:
        since: Steady times at which the positions came, (n,) [s]; -inf: nobody asked for any, the motor
            stays where it was then.
    """

    def __init__(
        self, robot: Robot, motors: ArrayLike, since: Floats, where: str = "motors"
    ) -> None:
        """Take them as :class:`MotorGoal` does, with the times at which they came."""
        super().__init__(robot, motors, where)
        self.since = since

    def expired(self, timeout: float, now: float) -> NDArray[np.bool_]:
        """Which motors have a position of their own that is too old to be followed, (n,).

        Args:
            timeout: [s]; 0: none is.
            now: Steady time [s].
        """
        old = now - self.since > timeout if timeout > 0.0 else np.zeros(len(self.since), bool)
        return old & np.isfinite(self.since)


class PoseGoal:
    """Controlled platform coordinates, approached straight in them.

    Attributes:
        pose: Numbers in the order of the description [m, rad, unit quaternion w x y z].
        driven: Whether something moves it on from tick to tick.
    """

    driven = False

    def __init__(self, robot: Robot, pose: ArrayLike) -> None:
        """Take a pose in the form of :func:`cpr_core.solve_inverse`.

        Raises:
            InvalidRequest: Not as many numbers, or the robot has no inverse problem.
            NonFiniteInput: A NaN or an infinity.
        """
        self._coordinates = pose_coordinates(robot)
        names = self._coordinates.names
        if not names:
            raise InvalidRequest("pose", no_inverse_problem(robot.description.name))
        self.pose = checked_vector("pose", pose, len(names), " ".join(names))
        self._asked: _Way | None = None

    @property
    def destination(self) -> Hashable | None:
        """The pose."""
        return "pose", *self.pose.tolist()

    def doubt(self, start: Equilibrium, before: Goal | None) -> str:
        """What looks like another unit, seen from where the robot is and was sent; empty: nothing."""
        near = [start.platform_position]
        if isinstance(before, PoseGoal):
            near.append(self._coordinates.position(before.pose, start.platform_position))
        position = self._coordinates.position(self.pose, start.platform_position)
        return position_doubt(start.robot.description, position, near)

    def at(self, pose: Floats) -> Self:
        """The same with another pose."""
        goal = copy(self)
        goal.pose = pose
        return goal

    def remaining(self, start: Equilibrium) -> float:
        """Larger one of distance (in rod lengths) and angle."""
        return self._way(start).length

    def solve(
        self, start: Equilibrium, fraction: float, loads: Loads, time_limit: float | None = None
    ) -> Equilibrium:
        """Inverse problem at the pose on the way."""
        pose = self.pose
        if fraction != 1.0:
            pose = self._coordinates.moved(start.pose, fraction * self._way(start).change)
        return solve_inverse(start.robot, pose, start=start, loads=loads, time_limit=time_limit)

    def motors_ahead(self, current: Assessment) -> Floats | None:
        """Way of the motors that what is left asks for, to first order, (n,) [rad or m].

        None: a pose does not say where motors go, or not here.
        """
        start = current.equilibrium
        if start.robot.redundancy:
            return None
        way = self._coordinates.by_axis(self._way(start).change)
        try:
            motors = current.kinemato_statics.motors_by_pose @ way
        except Exception:  # an inverse singularity, or no tangent: who solves for the way is told
            return None
        return motors if all(map(math.isfinite, motors.tolist())) else None

    def _way(self, start: Equilibrium) -> _Way:
        """The way that is left; it is asked for several times a tick."""
        way = self._asked
        if way is None or way.start is not start or way.pose is not self.pose:
            change = self._coordinates.way(start.pose, self.pose)
            way = self._asked = _Way(start, self.pose, change, self._coordinates.size(change))
        return way


class _Way(NamedTuple):
    """From an equilibrium to a pose, and its length [rod lengths, rad]."""

    start: Equilibrium
    pose: Floats
    change: Floats
    length: float


def whole(fraction: float) -> float:
    """A fraction of the way; the whole of it if what would be left is not worth a step of its own."""
    return 1.0 if fraction > 1.0 - 0.5 * SLACK else fraction
