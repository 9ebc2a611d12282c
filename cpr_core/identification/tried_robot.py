# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots that are only tried: what looks wrong with their numbers stands in nobody's file."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

from ..errors import DescriptionWarning
from ..model.robot import Robot

__all__ = ["free_robot", "tried_robot"]


def tried_robot(robot: Robot, values: Mapping[str, float]) -> Robot:
    """``Robot.with_parameters``, without its warnings and without limits.

    What was measured has happened, whatever limits say: they would end the search where they are met.

    Raises:
        DescriptionError: There is no such robot.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DescriptionWarning)
        return free_robot(robot.with_parameters(values))


def free_robot(robot: Robot) -> Robot:
    """The same robot, with motors and rods that bear everything; its numbers can still be changed."""
    return robot.with_description(robot.description.without_limits())
