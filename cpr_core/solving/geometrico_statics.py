# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The geometrico-static problems of Section IV-B: forward, inverse, forward by effort."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, checked_robot
from .home import solve_home
from .solve_from import solve_from

__all__ = ["checked_start", "solve_forward", "solve_forward_by_effort", "solve_inverse"]


def solve_forward(
    robot: Robot,
    motors: ArrayLike,
    *,
    start: Equilibrium | None = None,
    loads: Loads | None = None,
    stable_only: bool = False,
    time_limit: float | None = None,
) -> Equilibrium:
    """Forward problem: the equilibrium at given motor positions.

    Args:
        robot: The robot.
        motors: Motor positions q_a in motor order, (n,) [rad or m].
        start: Equilibrium whose branch is followed; default the robot's home.
        loads: Loads; default those of the start.
        stable_only: Refuse to pass or reach an unstable equilibrium.
        time_limit: Give up after this time [s]; default never.

    Raises:
        InvalidRequest: Wrong number of motors, or loads that do not fit the robot.
        NonFiniteInput: A NaN or an infinity.
        NoForwardSolution: The branch of the start does not reach that far.
        MotorLimitExceeded: A motor would be beyond its position range or effort on the way.
        StrainLimitExceeded: A rod would yield on the way.
        UnstableEquilibrium: Stability ends on the way, and only stable equilibria were asked for.
        TimeLimitExceeded: The time allowed was over.
    """
    start = checked_start(robot, start)
    return solve_from(
        start, "motors", motors, loads=loads, stable_only=stable_only, time_limit=time_limit
    )


def solve_forward_by_effort(
    robot: Robot,
    efforts: ArrayLike,
    *,
    start: Equilibrium | None = None,
    loads: Loads | None = None,
    stable_only: bool = False,
    time_limit: float | None = None,
) -> Equilibrium:
    """Forward problem by effort: the equilibrium under given motor efforts.

    Args:
        robot: The robot.
        efforts: Motor efforts tau_a in motor order, (n,) [N m or N].
        start: Equilibrium whose branch is followed; default the robot's home.
        loads: Loads; default those of the start.
        stable_only: Refuse to pass or reach an unstable equilibrium.
        time_limit: Give up after this time [s]; default never.

    Raises:
        InvalidRequest: Wrong number of efforts, or loads that do not fit the robot.
        NonFiniteInput: A NaN or an infinity.
        NoForwardSolution: The branch of the start does not reach that far.
        MotorLimitExceeded: A motor would be beyond its position range or effort on the way.
        StrainLimitExceeded: A rod would yield on the way.
        UnstableEquilibrium: Stability ends on the way, and only stable equilibria were asked for.
        TimeLimitExceeded: The time allowed was over.
    """
    start = checked_start(robot, start)
    return solve_from(
        start, "efforts", efforts, loads=loads, stable_only=stable_only, time_limit=time_limit
    )


def solve_inverse(
    robot: Robot,
    pose: ArrayLike,
    *,
    start: Equilibrium | None = None,
    loads: Loads | None = None,
    stable_only: bool = False,
    time_limit: float | None = None,
    objective: str | None = None,
) -> Equilibrium:
    """Inverse problem: the motors that hold the controlled platform coordinates at given values.

    Args:
        robot: The robot.
        pose: Controlled coordinates in the order of the description [m, rad]; ``orientation`` is a
            unit quaternion w x y z; ``roll``, ``pitch``, ``yaw`` are the angles of
            Rz(yaw) Ry(pitch) Rx(roll), where those not controlled are solved for; ``angle`` is the
            planar angle from the x axis. Angles are within a whole turn, others left out: more looks
            like degrees.
        start: Equilibrium whose branch is followed; default the robot's home.
        loads: Loads; default those of the start.
        stable_only: Refuse to pass or reach an unstable equilibrium.
        time_limit: Give up after this time [s]; default never.
        objective: For robots with more motors than controlled coordinates: what the freedom is used for.
            ``least_motion``, the default: the motors move as little as possible from the start, by the
            sum of squares in radians and rod lengths; ``least_effort``: the sum of squares of the
            efforts is least, torques in E J / l, forces in E J / l^2; ``greatest_margin`` of stability.
            What is found is the optimum next to the least motion, along the null space; where a limit or
            a fold is in the way, the best before it. ``equilibrium.objective`` names it.

    Raises:
        InvalidRequest: Wrong number of coordinates, or loads that do not fit the robot.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
        NoInverseSolution: The pose is not reached from the start.
        MotorLimitExceeded: A motor would be beyond its position range or effort on the way.
        StrainLimitExceeded: A rod would yield on the way.
        UnstableEquilibrium: Stability ends on the way, and only stable equilibria were asked for.
        TimeLimitExceeded: The time allowed was over.
    """
    start = checked_start(robot, start)
    return solve_from(
        start,
        "pose",
        pose,
        loads=loads,
        stable_only=stable_only,
        time_limit=time_limit,
        objective=objective,
    )


def checked_start(robot: Robot, start: Equilibrium | None) -> Equilibrium:
    """The start of a request; home where none is given.

    Raises:
        InvalidRequest: No robot, or a start of another one.
    """
    checked_robot(robot)
    if start is None:
        return solve_home(robot)
    if not isinstance(start, Equilibrium):
        raise InvalidRequest("start", f"expected an Equilibrium, got {start!r:.200}")
    if start.robot is not robot:
        raise InvalidRequest(
            "start",
            "expected an equilibrium of the same robot object: ask its own, start.robot, or bring it to "
            "this one where they differ in nothing but numbers, continued(start, robot)",
        )
    return start
