# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The geometrico-static problems of Section IV-B: forward, inverse, forward by effort."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .continuation import Walk, follow
from .equilibrium import Equilibrium, corrected, record_of
from .errors import (
    InvalidRequest,
    NoForwardSolution,
    NoInverseSolution,
    NotReached,
    TimeLimitExceeded,
    UnstableEquilibrium,
)
from .events import PathEvent
from .lie import roll_pitch_yaw, rotation_from_angles, rotation_from_quaternion
from .limits import check_limits, limit_error
from .loads import Loads
from .near_request import solve_near
from .robot import Robot
from .square_problem import Tolerances
from .targets import EffortTarget, MotorTarget, PlatformTarget, Target
from .validation import checked_matrix, checked_time, checked_vector

__all__ = [
    "checked_start",
    "pose_meaning",
    "refine",
    "restore_equilibrium",
    "solve_forward",
    "solve_forward_by_effort",
    "solve_inverse",
    "target_of",
]

Floats = NDArray[np.float64]

#: Time that a single step never takes, once it is compiled [s].
_ONE_STEP = 0.01


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
    return _followed(start, "motors", motors, loads, stable_only, time_limit)


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
    return _followed(start, "efforts", efforts, loads, stable_only, time_limit)


def solve_inverse(
    robot: Robot,
    pose: ArrayLike,
    *,
    start: Equilibrium | None = None,
    loads: Loads | None = None,
    stable_only: bool = False,
    time_limit: float | None = None,
) -> Equilibrium:
    """Inverse problem: the motors that hold the controlled platform coordinates at given values.

    Args:
        robot: The robot.
        pose: Controlled coordinates in the order of the description [m, rad]; ``orientation`` is a
            unit quaternion w x y z; ``roll``, ``pitch``, ``yaw`` are the angles of
            Rz(yaw) Ry(pitch) Rx(roll), where those not controlled are solved for; ``angle`` is the
            planar angle from the x axis.
        start: Equilibrium whose branch is followed; default the robot's home.
        loads: Loads; default those of the start.
        stable_only: Refuse to pass or reach an unstable equilibrium.
        time_limit: Give up after this time [s]; default never.

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
    return _followed(start, "pose", pose, loads, stable_only, time_limit)


def target_of(start: Equilibrium, what: str, values: ArrayLike) -> Target:
    """The target a request means.

    Args:
        start: Equilibrium to start from.
        what: ``motors``, ``pose`` or ``efforts``.
        values: Numbers of the request.

    Raises:
        InvalidRequest: Wrong number of values, or a robot without inverse problem.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
    """
    robot = start.robot
    if what == "motors":
        return MotorTarget(_motor_vector(robot, what, values))
    if what == "efforts":
        return EffortTarget(_motor_vector(robot, what, values))
    if not robot.description.controlled:
        raise InvalidRequest(
            "pose",
            f"the inverse problem of {robot.description.name} has no single solution: it has "
            f"{robot.motor_count} motors for {len(robot.platform_axes)} platform coordinates",
        )
    position, rotation = split_pose(start, values)
    return PlatformTarget(rotation, position)


def pose_meaning(robot: Robot) -> tuple[str, ...]:
    """Names of the numbers that make up a pose of the inverse problem."""
    parts = {"orientation": ("qw", "qx", "qy", "qz")}
    return tuple(
        number for name in robot.description.controlled for number in parts.get(name, (name,))
    )


def split_pose(start: Equilibrium, pose: ArrayLike) -> tuple[Floats, Floats]:
    """Position and rotation meant by controlled coordinates; the others as at the start."""
    names = pose_meaning(start.robot)
    values = dict(
        zip(names, checked_vector("pose", pose, len(names), " ".join(names)), strict=True)
    )
    position, rotation = start.platform_position.copy(), start.platform_rotation
    for axis, name in enumerate("xyz"):
        position[axis] = values.get(name, position[axis])
    if "qw" in values:
        rotation = rotation_from_quaternion([values[name] for name in ("qw", "qx", "qy", "qz")])
    angles = roll_pitch_yaw(rotation)
    for axis, name in enumerate(("roll", "pitch", "yaw")):
        angles[axis] = values.get(name, angles[axis])
    if start.robot.controls_angles:
        if abs(angles[1]) > 0.5 * np.pi:
            raise InvalidRequest("pose", f"expected a pitch of at most pi/2, got {angles[1]:g}")
        rotation = rotation_from_angles(*angles)
    if "angle" in values:
        cosine, sine = np.cos(values["angle"]), np.sin(values["angle"])
        rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return position, rotation


def restore_equilibrium(
    robot: Robot,
    loads: Loads,
    motors: ArrayLike,
    leg_coordinates: ArrayLike,
    multipliers: ArrayLike,
    platform_rotation: ArrayLike,
    platform_position: ArrayLike,
) -> Equilibrium:
    """An equilibrium from its stored numbers, rounded or not.

    Args:
        robot: The robot.
        loads: Loads it was found under.
        motors: Motor positions, (n,).
        leg_coordinates: ``Equilibrium.leg_coordinates``.
        multipliers: ``Equilibrium.multipliers``.
        platform_rotation: R_p, (3, 3).
        platform_position: p_p, (3,) [m].

    Raises:
        InvalidRequest: Wrong lengths, or the numbers are no equilibrium of this robot and these loads.
        NonFiniteInput: A NaN or an infinity.
    """
    state = np.zeros(len(robot.arrays.unit))
    state[robot.motor_indices] = _motor_vector(robot, "motors", motors)
    for name, indices, values in (
        ("leg_coordinates", robot.elastic_indices, leg_coordinates),
        ("multipliers", robot.multiplier_indices, multipliers),
    ):
        state[indices] = checked_vector(name, values, len(indices))
    rotation = checked_matrix("platform_rotation", platform_rotation, 3, 3)
    position = np.array(checked_vector("platform_position", platform_position, 3))
    _check_freedom(robot, rotation, position)
    given = state / robot.arrays.unit, rotation.copy(), position / robot.mean_length
    found = refine(robot, loads, state, rotation, position, iterations=6, contraction=0.5)
    result = state / robot.arrays.unit, rotation, position / robot.mean_length
    same = all(
        np.allclose(first, last, rtol=1e-3, atol=1e-3)
        for first, last in zip(given, result, strict=True)
    )
    if not same or not found.converged or np.any(found.state[robot.length_indices] <= 0.0):
        raise InvalidRequest(
            "start",
            f"expected an equilibrium of {robot.description.name} under its loads; these numbers "
            "belong to another robot, other loads or another number of modes",
        )
    return found


def _check_freedom(robot: Robot, rotation: Floats, position: Floats) -> None:
    """Whether a planar platform is in its plane, and a point without orientation."""
    if not robot.planar:
        return
    if abs(position[2]) > 1e-9 or abs(rotation[2, 2] - 1.0) > 1e-9:
        raise InvalidRequest("platform", "expected z = 0 and a rotation about z for a planar robot")
    if robot.description.point_platform and np.abs(rotation - np.eye(3)).max() > 1e-9:
        raise InvalidRequest("platform", "expected no rotation: the platform is a point")


def refine(
    robot: Robot,
    loads: Loads,
    state: Floats,
    rotation: Floats,
    position: Floats,
    *,
    iterations: int,
    contraction: float,
) -> Equilibrium:
    """Newton from a rough state at its motor positions.

    Returns:
        The result, converged or not: the caller has to look.
    """
    rough = record_of(robot, state, rotation, position)
    tolerances = Tolerances(iterations=iterations, contraction=contraction)
    return corrected(robot, loads, robot.load_arrays(loads), rough, tolerances)


def _motor_vector(robot: Robot, name: str, values: ArrayLike) -> Floats:
    return checked_vector(name, values, robot.motor_count, robot.motor_list)


def checked_start(robot: Robot, start: Equilibrium | None) -> Equilibrium:
    """The start of a request; home where none is given.

    Raises:
        InvalidRequest: A start of another robot.
    """
    if start is None:
        return robot.home
    if not isinstance(start, Equilibrium):
        raise InvalidRequest("start", f"expected an Equilibrium, got {start!r:.200}")
    if start.robot is not robot:
        raise InvalidRequest("start", "expected an equilibrium of the same robot object")
    return start


def _followed(
    start: Equilibrium,
    what: str,
    values: ArrayLike,
    loads: Loads | None,
    stable_only: bool,
    time_limit: float | None,
) -> Equilibrium:
    target = target_of(start, what, values)
    near = loads is None or loads is start.loads
    if near and (time_limit is None or checked_time(time_limit) > _ONE_STEP):
        found = solve_near(start, target, stable_only)
        if found is not None:
            return found
    walk = follow(
        start,
        target,
        start.loads if loads is None else loads,
        stable_only=stable_only,
        time_limit=time_limit,
    )
    if walk.stopped is not None:
        raise _not_reached(walk.stopped, walk, what, target, stable_only)
    check_limits(walk.last)
    return walk.last


def _not_reached(
    event: PathEvent, walk: Walk, what: str, target: Target, stable_only: bool
) -> NotReached:
    """The error of a walk that was stopped."""
    if walk.violation is not None:
        violation, beyond = walk.violation
        requested = target.motors if isinstance(target, MotorTarget) else None
        return limit_error(beyond, violation, event.fraction, event, requested)
    motors = ", ".join(f"{value:.4g}" for value in walk.last.motors)
    position = ", ".join(f"{value:.4g}" for value in walk.last.platform_position)
    text = (
        f"{what}: not reached from the start, {event.message}: its branch could be followed over "
        f"{100.0 * event.fraction:.2f} % of the way, to motors ({motors}) "
        f"and platform position ({position})"
    )
    if event.kind == "time_limit":
        return TimeLimitExceeded(text, event.fraction, walk.last, event)
    if stable_only and event.kind in ("stability", "bifurcation"):
        return UnstableEquilibrium(text, event.fraction, walk.last, event)
    failure = NoInverseSolution if what == "pose" else NoForwardSolution
    return failure(text, event.fraction, walk.last, event)
