# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How what a tracker tells changes, with the platform and with the tracker's own numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..description.changed_description import named_parameters, shifted_tracker
from ..description.tracker import Tracker
from ..lie import rotation_log
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, kept_with_robot

__all__ = ["of_tracker", "tracker_rates", "tracker_unit"]

Floats = NDArray[np.float64]

#: Step of central differences [m, rad].
_STEP = 1e-5


def of_tracker(path: str) -> bool:
    """Whether a parameter is a number of the tracker, which moves nothing of the robot."""
    return path.startswith("tracker.")


def tracker_unit(path: str, length: float) -> float:
    """Natural unit of a number of the tracker in a robot with rods of a length [m]; 0 of others."""
    if not of_tracker(path):
        return 0.0
    return 1.0 if "rotation_vector" in path else length


def tracker_rates(equilibrium: Equilibrium, paths: Sequence[str], platform: Floats) -> Floats:
    """Changes of the marker's pose in the tracker's frame, (6, P) [m, rad in that frame].

    Args:
        equilibrium: Of a robot with a tracker.
        paths: Of the parameters; none: only the platform moves.
        platform: Changes of the platform by them in the world, (6, P) [m, rad].
    """
    robot = equilibrium.robot
    tracker = robot.description.tracker
    assert tracker is not None
    found: Floats = tracker.marker_motions(equilibrium.platform_rotation) @ platform
    for column, path in enumerate(paths):
        if of_tracker(path):
            found[:, column] += _by_own_number(equilibrium, path)
    return found


def _by_own_number(equilibrium: Equilibrium, path: str) -> Floats:
    """Change of the marker's pose by a number of the tracker, the platform held, (6,)."""
    pose = equilibrium.platform_position, equilibrium.platform_rotation
    (low, low_turn), (high, high_turn) = (
        tracker.marker_in_tracker(*pose) for tracker in _trackers_beside(equilibrium.robot, path)
    )
    return np.concatenate([high - low, rotation_log(high_turn @ low_turn.T)]) / (2.0 * _STEP)


@kept_with_robot
def _trackers_beside(robot: Robot, path: str) -> list[Tracker]:
    """The tracker with one of its numbers a step less, and a step more: the same for all equilibria."""
    (parameter,) = named_parameters(robot.description, path)
    return [shifted_tracker(robot.description, parameter, step) for step in (-_STEP, _STEP)]
