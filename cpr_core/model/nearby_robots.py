# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots beside one in numbers of its description, for differences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..description.changed_description import shifted_together
from ..description.parameters import Parameter
from ..errors import DescriptionError, InvalidRequest
from .robot import Robot, kept_with_robot

__all__ = ["Nearby", "change_of", "nearby", "nearby_ahead", "robot_beside"]

#: Changes by which rates are found, of the size of a number: their square is lost in rounding.
_CHANGE = 1e-5


class Nearby(NamedTuple):
    """Robots beside one in a parameter.

    Attributes:
        robots: The robots.
        weights: What adds up to the rate of anything: its values there times these.
    """

    robots: tuple[Robot, ...]
    weights: tuple[float, ...]


def change_of(parameter: Parameter) -> float:
    """By how much a parameter is changed.

    Raises:
        InvalidRequest: The number is not finite.
    """
    change = _CHANGE * (parameter.size or 1.0)
    if not np.isfinite(change):
        problem = (
            f"{parameter.path} is not given: expected a number to vary, got {parameter.values[0]}"
        )
        raise InvalidRequest("parameters", problem)
    return change


def robot_beside(robot: Robot, changes: Sequence[tuple[Parameter, float]]) -> Robot:
    """The robot with some numbers changed.

    Raises:
        DescriptionError: There is none.
    """
    try:
        return Robot(shifted_together(robot.description, changes), robot.held_motors)
    except InvalidRequest as error:  # of loads, which requests have too
        source = robot.description.source
        raise DescriptionError(source, f"loads.{error.argument}", error.problem) from None


def nearby_ahead(robot: Robot, parameter: Parameter) -> Nearby:
    """The robot on the one side, the other where there is none on the first, and this one.

    Raises:
        InvalidRequest: The number is not finite.
        DescriptionError: There is none.
    """
    change, ahead = _ahead(robot, parameter)
    return Nearby((ahead, robot), (1.0 / change, -1.0 / change))


@kept_with_robot
def nearby(robot: Robot, parameter: Parameter) -> Nearby:
    """Robots on both sides, or on one where there are none on the other.

    Raises:
        InvalidRequest: The number is not finite.
        DescriptionError: There are none.
    """
    change, ahead = _ahead(robot, parameter)
    try:
        behind = robot_beside(robot, ((parameter, -change),))
    except DescriptionError:
        further = robot_beside(robot, ((parameter, 2.0 * change),))
        return Nearby((ahead, further, robot), (2.0 / change, -0.5 / change, -1.5 / change))
    return Nearby((ahead, behind), (0.5 / change, -0.5 / change))


@kept_with_robot
def _ahead(robot: Robot, parameter: Parameter) -> tuple[float, Robot]:
    """A change of a parameter, a smaller number where it cannot be larger, and the robot there."""
    change = change_of(parameter)
    try:
        return change, robot_beside(robot, ((parameter, change),))
    except DescriptionError as refused:
        try:
            return -change, robot_beside(robot, ((parameter, -change),))
        except DescriptionError:
            raise refused from None
