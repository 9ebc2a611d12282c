# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far solutions are from those of continuous rods, as messages tell it."""

from __future__ import annotations

import math

from cpr_msgs.msg import ModelError
from geometry_msgs.msg import Vector3

from cpr_core import CprError, Equilibrium, error_of
from cpr_core.kernels.problems import ProblemName
from cpr_core.solving.chosen_modes import TOLD

__all__ = ["estimated_error", "model_error_message", "warned_error"]


def estimated_error(equilibrium: Equilibrium) -> float:
    """Estimated error of the platform position with the motors held [m]; NaN at a singularity."""
    try:
        return error_of(equilibrium).distance
    except CprError:
        return math.nan


def warned_error(equilibrium: Equilibrium) -> float:
    """From which estimate on the tolerance of the description may not be kept [m]; infinite without."""
    return TOLD * equilibrium.robot.description.tolerance


def model_error_message(equilibrium: Equilibrium, held: ProblemName) -> ModelError:
    """All that continuous rods would change.

    Args:
        equilibrium: The solution.
        held: The problem it is a solution of.
    """
    try:
        found = error_of(equilibrium, held)
    except CprError:
        return ModelError(held=held, distance=math.nan)
    return ModelError(
        held=held,
        distance=found.distance,
        position=Vector3(**dict(zip("xyz", found.position.tolist(), strict=True))),
        rotation=Vector3(**dict(zip("xyz", found.rotation.tolist(), strict=True))),
        motors=found.motors.tolist(),
        efforts=found.efforts.tolist(),
    )
