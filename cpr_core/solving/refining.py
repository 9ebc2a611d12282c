# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria from rough or from stored numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.loads import Loads
from ..errors import InvalidRequest
from ..kernels.square_problem import Configuration, Tolerances
from ..lie import ROTATION_TOLERANCE, nearest_rotation
from ..model.configurations import leg_units
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_records import record_of
from ..model.equilibrium_steps import corrected
from ..model.robot import Robot, checked_robot
from ..validation import checked_vector
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
        platform_rotation: R_p, (3, 3). A rounded one stands for the rotation nearest to it.
        platform_position: p_p, (3,) [m].

    Raises:
        InvalidRequest: Wrong lengths, no rotation, or the numbers are no equilibrium of this robot and
            these loads.
        NonFiniteInput: A NaN or an infinity.
    """
    checked_robot(robot)
    state = np.zeros(len(robot.kernel_arrays.unit))
    state[robot.motor_indices] = motor_vector(robot, "motors", motors)
    for name, indices, values in (
        ("leg_coordinates", robot.elastic_indices, leg_coordinates),
        ("multipliers", robot.multiplier_indices, multipliers),
    ):
        state[indices] = checked_vector(name, values, len(indices))
    # A sheared platform would stay so in whatever is solved from here: solvers only turn it further.
    rotation = nearest_rotation("platform_rotation", platform_rotation)
    position = np.array(checked_vector("platform_position", platform_position, 3))
    _check_freedom(robot, rotation, position)
    place = Configuration(state, rotation, position)
    found = refine(robot, loads, place, iterations=6, contraction=0.5)
    if not found.converged or not _near(found, place):
        raise InvalidRequest(
            "start",
            f"expected an equilibrium of {robot.description.name} under its loads; these numbers "
            "belong to another robot, other loads or another number of modes, or are rounded too far",
        )
    return found


def _near(found: Equilibrium, place: Configuration) -> bool:
    """Whether an equilibrium is where it was looked for, up to rounding.

    Multipliers do not count: they are found in one step wherever that begins.
    """
    robot = found.robot
    first = np.concatenate([place.state, place.platform_rotation.ravel(), place.platform_position])
    last, units, near = found.configuration, leg_units(robot), ROTATION_TOLERANCE
    same = np.allclose(last / units, first / units, rtol=near, atol=near)
    return same and robot.rods_exist(found.state)


def _check_freedom(robot: Robot, rotation: Floats, position: Floats) -> None:
    """Whether a planar platform is in its plane, and a point without orientation."""
    if not robot.planar:
        return
    if abs(position[2]) > 1e-9 or abs(rotation[2, 2] - 1.0) > 1e-9:
        raise InvalidRequest("platform", "expected z = 0 and a rotation about z for a planar robot")
    if robot.description.point_platform and np.abs(rotation - np.eye(3)).max() > 1e-9:
        raise InvalidRequest("platform", "expected no rotation: the platform is a point")


def refine(
    robot: Robot, loads: Loads, place: Configuration, *, iterations: int, contraction: float
) -> Equilibrium:
    """Newton from a rough configuration at its motor positions.

    Returns:
        The result, converged or not: the caller has to look.
    """
    rough = record_of(robot, place)
    tolerances = Tolerances(iterations=iterations, contraction=contraction)
    return corrected(robot, loads, robot.load_arrays(loads), rough, tolerances)
