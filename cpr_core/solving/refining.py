# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria from rough or from stored numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.square_problem import Tolerances
from ..model.equilibrium import Equilibrium, corrected, record_of
from ..model.robot import Robot, checked_robot
from ..validation import checked_matrix, checked_vector
from .requests import motor_vector

__all__ = ["refine", "restore_equilibrium"]

Floats = NDArray[np.float64]


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
    checked_robot(robot)
    state = np.zeros(len(robot.arrays.unit))
    state[robot.motor_indices] = motor_vector(robot, "motors", motors)
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
