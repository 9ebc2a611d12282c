# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements beside predictions: what differs, in standard deviations, and how that changes.

A row compares position, rotation, motors and efforts, in this order, as far as they were measured and
do not drive it: 6 + 2 n numbers at most. A pose is compared in the frame it was measured in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..kernels.problems import ProblemName
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..lie import rotation_log, skew
from ..model.equilibrium import Equilibrium
from ..model.kinemato_statics import kinemato_statics
from ..solving.parameter_derivatives import derivatives
from ..validation import ReadOnlyArrays
from .measurements import Measurement, StandardDeviations, driven_by
from .tracker_rates import of_tracker, tracker_rates

__all__ = ["ComparedRow", "compared_row"]

#: Weights that differ less are the same: an answer moves by less than that part of its deviation.
_SAME_WEIGHTS = 1e-3

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ComparedRow(ReadOnlyArrays):
    """How a measurement is compared with a prediction.

    Attributes:
        measurement: The measurement.
        problem: What drives it.
        places: What is compared, of position, rotation, motors and efforts, (K,).
        deviations: Of these, without what the drive adds, (K,) [m, rad, ...].
        weights: Makes of differences numbers of unit variance that are independent, (K, K).
    """

    measurement: Measurement
    problem: ProblemName
    places: Integers
    deviations: Floats
    weights: Floats

    def differences(self, equilibrium: Equilibrium) -> Floats:
        """Predicted minus measured, (K,) [m, rad in the frame of the pose, motors, efforts]."""
        measured, robot = self.measurement, equilibrium.robot
        position, rotation = measured.predicted_pose(equilibrium)
        whole = np.full(6 + 2 * robot.motor_count, np.nan)
        if measured.position is not None:
            whole[:3] = position - measured.position
        if measured.rotation is not None:
            whole[3:6] = -rotation_log(measured.rotation @ rotation.T)
        if measured.motors is not None:
            whole[6 : 6 + robot.motor_count] = equilibrium.motors - measured.motors
        if measured.efforts is not None:
            whole[6 + robot.motor_count :] = equilibrium.efforts - measured.efforts
        return whole[self.places]

    def residual(self, equilibrium: Equilibrium) -> Floats:
        """Differences in standard deviations, (K,)."""
        found: Floats = self.weights @ self.differences(equilibrium)
        return found

    def weighs_as(self, other: ComparedRow) -> bool:
        """Whether another one has the same weights, to a thousandth."""
        if not len(self.places):
            return True
        between = scipy.linalg.solve_triangular(other.weights, self.weights, lower=True)
        return bool(np.abs(between - np.eye(len(between))).max(initial=0.0) < _SAME_WEIGHTS)

    def rates(self, equilibrium: Equilibrium, paths: Sequence[str]) -> Floats:
        """Derivatives of the residual by parameters, (K, P)."""
        of_robot = [path for path in paths if not of_tracker(path)]
        own = np.isin(paths, of_robot)
        whole = np.zeros((6 + 2 * equilibrium.robot.motor_count, len(paths)))
        if of_robot:
            by = derivatives(equilibrium, of_robot, problem=self.problem)
            whole[:, own] = np.vstack([by.position, by.rotation, by.motors, by.efforts])
        if self.measurement.frame == "tracker":
            whole[:6] = tracker_rates(equilibrium, paths, whole[:6])
        if self.measurement.rotation is not None:
            _, rotation = self.measurement.predicted_pose(equilibrium)
            apart = rotation_log(self.measurement.rotation @ rotation.T)
            whole[3:6] = _log_rate(apart) @ whole[3:6]
        found: Floats = self.weights @ whole[self.places]
        return found


def _log_rate(apart: Floats) -> Floats:
    """Minus the change of ``log(exp(apart) exp(-turn))`` per turn at none, (3, 3)."""
    angle, cross = float(np.linalg.norm(apart)), skew(apart)
    if angle < 1e-4:
        factor = 1.0 / 12.0
    else:
        factor = 1.0 / angle**2 - (1.0 + np.cos(angle)) / (2.0 * angle * np.sin(angle))
    found: Floats = np.eye(3) + 0.5 * cross + factor * cross @ cross
    return found


def compared_row(
    measurement: Measurement, equilibrium: Equilibrium, deviations: StandardDeviations
) -> ComparedRow:
    """How a measurement is compared, with weights as they are at an equilibrium.

    Where what drives the row has a standard deviation, it adds to those of what follows, to first order:
    then what is compared is correlated.

    Raises:
        InvalidRequest: A standard deviation that is needed is not given.
    """
    robot = equilibrium.robot
    problem, count = driven_by(robot, measurement).problem, robot.motor_count
    measured = np.zeros(6 + 2 * count, np.bool_)
    if measurement.position is not None:
        measured[:3] = np.isfinite(measurement.position)
    if measurement.rotation is not None:
        measured[3:6] = True
    for first, values in ((6, measurement.motors), (6 + count, measurement.efforts)):
        if values is not None:
            measured[first : first + count] = np.isfinite(values)
    if measurement.frame == "world":  # in the tracker's frame all of it may move
        moving = (robot.platform_axes + 3) % 6  # twists have rotations first
        measured[:6] &= np.isin(np.arange(6), moving)
    elif robot.description.point_platform:
        measured[3:6] = False
    driving = _driving(equilibrium, problem)
    places = np.flatnonzero(measured & ~driving)
    kinds = ["position"] * 3 + ["rotation"] * 3 + ["motors"] * count + ["efforts"] * count
    each = np.array([deviations.of(kinds[place]) for place in places])
    own = [getattr(deviations, kinds[place]) or 0.0 for place in np.flatnonzero(driving)]
    if not any(own):
        return ComparedRow(measurement, problem, places, each, np.diag(1.0 / each))
    moved = _moved_by_drive(equilibrium, driving)
    if measurement.frame == "tracker":
        moved[:6] = tracker_rates(equilibrium, (), moved[:6])
    moved = moved[places] * own
    lower = scipy.linalg.cholesky(np.diag(each**2) + moved @ moved.T, lower=True)
    weights = scipy.linalg.solve_triangular(lower, np.eye(len(places)), lower=True)
    return ComparedRow(measurement, problem, places, each, weights)


def _driving(equilibrium: Equilibrium, problem: ProblemName) -> NDArray[np.bool_]:
    """What drives an equilibrium, of position, rotation, motors and efforts."""
    robot, count = equilibrium.robot, equilibrium.robot.motor_count
    found = np.zeros(6 + 2 * count, np.bool_)
    if problem == "pose":
        found[(robot.controlled_axes + 3) % 6] = True
    else:
        first = 6 if problem == "motors" else 6 + count
        found[first : first + count] = True
    return found


def _moved_by_drive(equilibrium: Equilibrium, driving: NDArray[np.bool_]) -> Floats:
    """How everything follows what drives, to first order, (6 + 2 n, D)."""
    robot, model = equilibrium.robot, kinemato_statics(equilibrium)
    body = np.zeros((6, robot.motor_count))
    body[robot.platform_axes] = model.jacobian
    turn = equilibrium.platform_rotation
    by_motors = np.vstack(
        [
            turn @ body[LINEAR],
            turn @ body[ANGULAR],
            np.eye(robot.motor_count),
            model.efforts_by_motors,
        ]
    )
    found: Floats = by_motors @ scipy.linalg.pinv(by_motors[driving])
    return found
