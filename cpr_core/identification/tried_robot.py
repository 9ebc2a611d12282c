# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots that are only tried: what looks wrong with their numbers stands in nobody's file."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

from ..errors import DescriptionWarning
from ..model.robot import Robot

__all__ = ["tried_robot"]


def tried_robot(robot: Robot, values: Mapping[str, float]) -> Robot:
    """``Robot.with_parameters``, without its warnings.

    Raises:
        DescriptionError: There is no such robot.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DescriptionWarning)
        return robot.with_parameters(values)
