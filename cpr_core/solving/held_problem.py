# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What stays as it is in an equilibrium while something else changes: motors, pose or efforts."""

from __future__ import annotations

from typing import get_args

from ..errors import InvalidRequest
from ..kernels.problems import ProblemName
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..validation import checked_word
from .targets import EffortTarget, MotorTarget, PoseTarget, Target

__all__ = ["checked_problem", "held"]


def checked_problem(robot: Robot, problem: ProblemName) -> None:
    """Whether a robot has a problem with a single solution.

    Raises:
        InvalidRequest: It has not.
    """
    checked_word("problem", problem, get_args(ProblemName))
    if problem == "pose" and (robot.redundancy or not robot.description.controlled):
        raise InvalidRequest(
            "problem", "expected motors or efforts: no single solution holds the pose of this robot"
        )


def held(equilibrium: Equilibrium, problem: ProblemName) -> Target:
    """The problem of which an equilibrium is a solution."""
    if problem == "motors":
        return MotorTarget(equilibrium.motors)
    if problem == "efforts":
        return EffortTarget(equilibrium.efforts)
    position, rotation = equilibrium.platform_position, equilibrium.platform_rotation
    return PoseTarget(rotation, position, equilibrium.motors)
