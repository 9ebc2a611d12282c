# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Answers about one equilibrium: kinemato-statics, prediction, stability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from cpr_msgs.msg import ErrorCode
from cpr_msgs.msg import Singularity as SingularityMessage
from cpr_msgs.srv import CheckStability, GetKinematoStatics, Predict
from geometry_msgs.msg import Twist
from numpy.typing import NDArray

from cpr_core import Equilibrium, Robot, kinemato_statics, spectrum
from cpr_core.errors import InvalidRequest
from cpr_core.model.kinemato_statics import KinematoStatics
from cpr_core.model.linear_problems import LinearProblem, Singularity
from cpr_core.model.platform_coordinates import six_components
from cpr_core.validation import checked_vector

from ..error_codes import RequestError
from .geometry import LINEAR_FIRST, twist_message, twist_of, wrench_of

__all__ = [
    "fill_kinemato_statics",
    "fill_prediction",
    "fill_stability",
    "message_matrix",
    "singularity_message",
    "stiffness_message",
]

Floats = NDArray[np.float64]


def fill_kinemato_statics(
    equilibrium: Equilibrium,
    request: GetKinematoStatics.Request,
    response: GetKinematoStatics.Response,
) -> None:
    """Answer ``~/get_kinemato_statics``.

    Raises:
        CprError: A length or a stiffness that cannot be.
    """
    robot, model = equilibrium.robot, kinemato_statics(equilibrium)
    length = request.characteristic_length
    if not 0.0 <= length < np.inf:
        raise RequestError(
            ErrorCode.NON_FINITE_INPUT
            if not np.isfinite(length)
            else ErrorCode.INVALID_ROBOT_STATE,
            f"characteristic_length: expected a positive length or 0 for the default, got {length}",
        )
    stiffness = list(request.motor_stiffness) or None
    compliance = model.compliance(stiffness)
    response.motor_names = list(robot.motor_names)
    response.jacobian = _rows(robot, model.jacobian).ravel().tolist()
    response.efforts_by_motors = model.efforts_by_motors.ravel().tolist()
    response.efforts_by_wrench = _rows(robot, model.efforts_by_wrench.T).T.ravel().tolist()
    response.compliance = message_matrix(robot, compliance).ravel().tolist()
    response.stiffness = stiffness_message(model, stiffness).tolist()
    response.forward = _singularity(model, "forward", length)
    if "inverse" in model.problems:
        response.inverse = _singularity(model, "inverse", length)
    else:
        response.inverse.smallest_singular_value = np.nan
        response.inverse.inverse_condition_number = np.nan
    response.inverse_by_effort = _singularity(model, "inverse_by_effort", length)


def stiffness_message(
    model: KinematoStatics, motor_stiffness: Sequence[float] | None = None
) -> Floats:
    """Stiffness of the platform, (36,); NaN where it cannot move in some direction of its own.

    Raises:
        InvalidRequest: No stiffness of motors.
    """
    try:
        stiffness = model.stiffness(motor_stiffness)
    except InvalidRequest as error:
        if error.argument != "stiffness":
            raise
        return np.full(36, np.nan)
    return message_matrix(model.equilibrium.robot, stiffness).ravel()


def fill_prediction(
    equilibrium: Equilibrium, request: Predict.Request, response: Predict.Response
) -> None:
    """Answer ``~/predict``.

    Raises:
        CprError: Increments of the wrong length, not finite, or an inverse singularity.
    """
    robot, model = equilibrium.robot, kinemato_statics(equilibrium)
    axes = robot.platform_axes
    wrench = checked_vector("wrench_increment", wrench_of(request.wrench_increment), 6)[axes]
    if request.problem == Predict.Request.FORWARD:
        found = model.predict_forward(request.motor_increments, wrench)
    elif request.problem == Predict.Request.INVERSE:
        platform = checked_vector("platform_increment", twist_of(request.platform_increment), 6)
        found = model.predict_inverse(platform[axes], wrench)
    else:
        raise RequestError(
            ErrorCode.INVALID_ROBOT_STATE,
            f"problem: expected FORWARD 0 or INVERSE 1, got {request.problem}",
        )
    parts = (found.motors, found.efforts, found.platform)
    if not all(np.all(np.isfinite(part)) for part in parts):
        raise RequestError(
            ErrorCode.INVALID_ROBOT_STATE,
            "increments: expected small ones, these are beyond numbers",
        )
    response.motor_increments = found.motors.tolist()
    response.effort_increments = found.efforts.tolist()
    response.platform_increment = _twist(robot, found.platform)


def fill_stability(
    equilibrium: Equilibrium, request: CheckStability.Request, response: CheckStability.Response
) -> None:
    """Answer ``~/check_stability``.

    Raises:
        RequestError: An unknown reading of the motors.
    """
    robot = equilibrium.robot
    if request.motors_are not in (CheckStability.Request.LOCKED, CheckStability.Request.FREE):
        raise RequestError(
            ErrorCode.INVALID_ROBOT_STATE,
            f"motors_are: expected LOCKED 0 or FREE 1, got {request.motors_are}",
        )
    free = request.motors_are == CheckStability.Request.FREE
    found = spectrum(equilibrium, "free" if free else "locked")
    motion = found.softest_motion
    response.stable = found.index == 0 and found.energy_criterion_applies
    response.energy_criterion_applies = found.energy_criterion_applies
    response.index = found.index
    response.eigenvalues = found.eigenvalues[:6].tolist()
    response.margin = found.margin
    response.inverse_condition_number = found.inverse_condition_number
    response.softest_motors = motion[robot.motor_indices].tolist()
    response.softest_platform = _twist(robot, motion[robot.platform_indices])


def _singularity(
    model: KinematoStatics, problem: LinearProblem, length: float
) -> SingularityMessage:
    return singularity_message(model.equilibrium.robot, model.singularity(problem, length or None))


def singularity_message(robot: Robot, found: Singularity) -> SingularityMessage:
    """Distance from a singularity as a message."""
    return SingularityMessage(
        smallest_singular_value=found.smallest,
        inverse_condition_number=found.inverse_condition_number,
        sign=found.sign,
        null_motors=found.motors.tolist(),
        null_platform=_twist(robot, found.platform),
    )


def _twist(robot: Robot, platform: Floats) -> Twist:
    """A motion of the platform, (b,), as a message."""
    return twist_message(six_components(robot.platform_axes, platform))


def _rows(robot: Robot, matrix: Floats) -> Floats:
    """A matrix with platform rows, made whole and put in the order of messages, (6, ...)."""
    return six_components(robot.platform_axes, matrix)[LINEAR_FIRST]


def message_matrix(robot: Robot, matrix: Floats) -> Floats:
    """A matrix of platform rows and columns, whole and in the order of messages, (6, 6)."""
    return _rows(robot, _rows(robot, matrix).T).T
