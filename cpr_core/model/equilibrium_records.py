# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Records of equilibria: their memory, and what Newton's method makes of a rough one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.continuation_kernel import UNPREDICTED
from ..kernels.kept_factors import kept_factors
from ..kernels.kernel_arrays import Lanes, LoadArrays
from ..kernels.prepared_robot import continue_prepared
from ..kernels.problems import PROBLEMS
from ..kernels.record_layout import EFFORT, ENERGY, POSITION, RESIDUAL, ROTATION, SIGNS
from ..kernels.square_problem import Configuration, Tolerances
from .robot import Robot

__all__ = ["AS_IT_IS", "corrected_record", "new_record", "record_of"]

Floats = NDArray[np.float64]

#: A rough record is taken for an equilibrium as it is.
AS_IT_IS = Tolerances(residual=np.inf, iterations=0, contraction=1.0)


def new_record(robot: Robot, count: int | None = None) -> Floats:
    """Memory of a record, or of some."""
    return np.empty(robot.record_size if count is None else (count, robot.record_size))


def record_of(robot: Robot, place: Configuration) -> Floats:
    """A record of which only the configuration is known."""
    record, size = np.zeros_like(new_record(robot)), robot.state_size
    record[:size] = place.state
    record[size + ROTATION : size + POSITION] = np.ravel(place.platform_rotation)
    record[size + POSITION : size + ENERGY] = place.platform_position
    return record


def corrected_record(
    robot: Robot, load_arrays: LoadArrays, record: Floats, tolerances: Tolerances
) -> tuple[Floats, Lanes | None]:
    """Newton's method from a rough record at its motors.

    Returns:
        The record where it ended, and the condensed tangent there; None: not within the tolerance, then
        the residual is infinite and no sign is known.
    """
    size, motors = robot.state_size, robot.motor_count
    records, kept = record[None].copy(), kept_factors(robot.kernel_arrays)
    given = record[None, size - motors : size].copy()
    converged = continue_prepared(
        robot.prepared,
        load_arrays,
        PROBLEMS["motors"],
        given,
        UNPREDICTED,
        *tolerances,
        record,
        kept,
        records,
        kept,
    )
    if not converged:
        records[0, size + RESIDUAL] = np.inf
        records[0, size + SIGNS : size + EFFORT] = 0.0
    return records[0], kept if converged else None
