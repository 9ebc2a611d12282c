# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The noise of what drives a row: what it was most likely, and the row without it.

The derivation is in docs/derivations.md, "Calibration".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..description.controlled_coordinates import pose_of
from ..lie import quaternion_from_rotation, rotation_exp
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..solving.not_reached import NotReached
from ..solving.solve_from import solve_from
from .compared import ComparedRow, compared_row
from .compared_layout import kinds_of
from .measurements import StandardDeviations
from .robust_loss import Loss, pull

__all__ = ["weighed_at"]

#: Change of what is compared, in standard deviations, that is none.
_SAME = 1e-3
#: Largest noise of a drive, in standard deviations: more is a mistake, which is not followed.
_LARGEST = 4.0

Floats = NDArray[np.float64]


def weighed_at(
    row: ComparedRow, equilibrium: Equilibrium, deviations: StandardDeviations, loss: Loss
) -> tuple[ComparedRow, Equilibrium, bool]:
    """A row that is driven without the most likely noise, and weighed as it is there.

    Args:
        row: The row as it was compared.
        equilibrium: Of a robot, driven by the row less the noise that was assumed.
        deviations: Of all measurements.
        loss: How residuals count.

    Returns:
        The row, its equilibrium, and whether it compares as before, to a thousandth.
    """
    if not row.by_drive.any():
        return row, equilibrium, True
    fresh, reached = compared_row(row.measurement, equilibrium, deviations, row.noise), equilibrium
    noise = fresh.by_drive.T @ fresh.weights.T @ pull(loss, fresh.residual(equilibrium))
    noise = noise * (_LARGEST / max(_LARGEST, float(np.abs(noise).max())))
    drive = _drive_without(equilibrium.robot, row, noise)
    try:
        reached = solve_from(equilibrium, row.problem, drive)
        fresh = compared_row(row.measurement, reached, deviations, noise)
    except NotReached:  # what is left of it stays carried to first order
        pass
    moved = fresh.residual(reached) - row.residual(equilibrium)
    same = row.weighs_as(fresh) and bool(np.abs(moved).max(initial=0.0) < _SAME)
    return fresh, reached, same


def _drive_without(robot: Robot, row: ComparedRow, noise: Floats) -> Floats:
    """What drives a row less a noise in standard deviations, (D,), as a request has it."""
    measured, kinds = row.measurement, kinds_of(robot)
    whole = np.zeros(len(kinds))
    whole[row.driving] = row.drive_deviations * noise
    if row.problem != "pose":
        drive: Floats = getattr(measured, row.problem) - whole[kinds == row.problem]
        return drive
    position, rotation = measured.position, measured.rotation
    position = np.full(3, np.nan) if position is None else position - whole[kinds == "position"]
    rotation = np.full((3, 3), np.nan) if rotation is None else rotation
    rotation = rotation_exp(-whole[kinds == "rotation"]) @ rotation
    return pose_of(
        robot.description.controlled, position, rotation, lambda: quaternion_from_rotation(rotation)
    )
