# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measurements beside predictions: what differs, in standard deviations, and how that changes.

A row compares what ``KINDS`` names as far as it was measured and does not drive it: M numbers at most.
A pose is compared in the frame it was measured in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from ..kernels.problems import ProblemName
from ..kernels.twist_layout import ANGULAR, LINEAR
from ..lie import rotation_log, vectors_by_turn
from ..model.equilibrium import Equilibrium
from ..model.kinemato_statics import kinemato_statics
from ..model.platform_coordinates import six_components
from ..model.robot import Robot
from ..solving.parameter_derivatives import derivatives
from ..validation import ReadOnlyArrays
from .compared_layout import KINDS, OF_TWIST, POSE, joined, kinds_of
from .measurements import Measurement, StandardDeviations, driven_by
from .tracker_rates import of_tracker, tracker_rates

__all__ = ["ComparedRow", "compared_row", "measured_numbers", "predicted_numbers"]

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
        places: What is compared, of all that may be, (K,).
        kinds: Of which kind that is, (K,).
        deviations: Of these, without what the drive adds, (K,) [m, rad, ...].
        driving: What drives it, of all that may be compared, (D,).
        drive_deviations: Of these, 0 where they are exact, (D,) [m, rad, ...].
        by_drive: How what is compared follows the noise of these in their standard deviations, (K, D).
        noise: What this noise is taken for, in these standard deviations, (D,): the equilibrium of the
            row is the one without it.
        weights: Makes of differences numbers of unit variance that are independent, (K, K).
    """

    measurement: Measurement
    problem: ProblemName
    places: Integers
    kinds: NDArray[np.str_]
    deviations: Floats
    driving: Integers
    drive_deviations: Floats
    by_drive: Floats
    noise: Floats
    weights: Floats

    def as_measured(self) -> ComparedRow:
        """The same row where what drives it is taken as it was measured."""
        return replace(self, noise=np.zeros_like(self.noise))

    def differences(self, equilibrium: Equilibrium) -> Floats:
        """Predicted minus measured, (K,) [m, rad in the frame of the pose, motors, efforts].

        Predicted from what was measured of the drive: what its noise adds is added, to first order.
        """
        predicted = predicted_numbers(self.measurement, equilibrium)
        apart = predicted - measured_numbers(equilibrium.robot, self.measurement)
        found: Floats = apart[self.places] + self.by_drive @ self.noise
        return found

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
        kinds = kinds_of(equilibrium.robot)
        whole = np.zeros((len(kinds), len(paths)))
        if of_robot:
            by = derivatives(equilibrium, of_robot, problem=self.problem)
            whole[:, own] = joined(equilibrium.robot, {kind: getattr(by, kind) for kind in KINDS})
        if self.measurement.frame == "tracker":
            whole[POSE] = tracker_rates(equilibrium, paths, whole[POSE])
        if self.measurement.rotation is not None:
            _, rotation = self.measurement.predicted_pose(equilibrium)
            apart = rotation_log(self.measurement.rotation @ rotation.T)
            whole[kinds == "rotation"] = vectors_by_turn(-apart) @ whole[kinds == "rotation"]
        found: Floats = self.weights @ whole[self.places]
        return found


def measured_numbers(robot: Robot, measurement: Measurement) -> Floats:
    """What was measured, (M,), NaN where nothing was: a rotation as the turn from itself, none."""
    values = {kind: getattr(measurement, kind) for kind in KINDS}
    if measurement.rotation is not None:
        values["rotation"] = np.zeros(3)
    return joined(robot, values)


def predicted_numbers(measurement: Measurement, equilibrium: Equilibrium) -> Floats:
    """The same of an equilibrium, (M,): a rotation as the turn from the one that was measured."""
    position, rotation = measurement.predicted_pose(equilibrium)
    turn = None
    if measurement.rotation is not None:
        turn = -rotation_log(measurement.rotation @ rotation.T)
    pose = {"position": position, "rotation": turn}
    others = {kind: getattr(equilibrium, kind) for kind in KINDS if kind not in pose}
    return joined(equilibrium.robot, pose | others)


def compared_row(
    measurement: Measurement,
    equilibrium: Equilibrium,
    deviations: StandardDeviations,
    noise: Floats | None = None,
) -> ComparedRow:
    """How a measurement is compared, with weights as they are at an equilibrium.

    Where what drives the row has a standard deviation, it adds to those of what follows, to first order:
    then what is compared is correlated.

    Args:
        measurement: The measurement.
        equilibrium: Driven by it, less the noise.
        deviations: Of all measurements.
        noise: Of what drives it, in standard deviations, (D,); default none.

    Raises:
        InvalidRequest: A standard deviation that is needed is not given.
    """
    robot = equilibrium.robot
    problem, kinds = driven_by(robot, measurement).problem, kinds_of(robot)
    measured = np.isfinite(measured_numbers(robot, measurement))
    if measurement.frame == "world":  # in the tracker's frame all of it may move
        measured[POSE] &= np.isin(np.arange(6), OF_TWIST[robot.platform_axes])
    elif robot.description.point_platform:
        measured[kinds == "rotation"] = False
    driving = kinds == problem
    if problem == "pose":
        driving[OF_TWIST[robot.controlled_axes]] = True
    places = np.flatnonzero(measured & ~driving)
    each = np.array([deviations.of(kind) for kind in kinds[places]])
    own = np.array([getattr(deviations, kind) or 0.0 for kind in kinds[driving]])
    if own.any():
        moved = _moved_by_drive(equilibrium, driving)
        if measurement.frame == "tracker":
            moved[POSE] = tracker_rates(equilibrium, (), moved[POSE])
        by_drive = moved[places] * own
        lower = scipy.linalg.cholesky(np.diag(each**2) + by_drive @ by_drive.T, lower=True)
        weights = scipy.linalg.solve_triangular(lower, np.eye(len(places)), lower=True)
    else:
        by_drive, weights = np.zeros((len(places), len(own))), np.diag(1.0 / each)
    return ComparedRow(
        measurement=measurement,
        problem=problem,
        places=places,
        kinds=kinds[places],
        deviations=each,
        driving=np.flatnonzero(driving),
        drive_deviations=own,
        by_drive=by_drive,
        noise=np.zeros(len(own)) if noise is None else noise,
        weights=weights,
    )


def _moved_by_drive(equilibrium: Equilibrium, driving: NDArray[np.bool_]) -> Floats:
    """How everything follows what drives, to first order, (M, D)."""
    robot, model = equilibrium.robot, kinemato_statics(equilibrium)
    body, turn = six_components(robot.platform_axes, model.jacobian), equilibrium.platform_rotation
    by_motors = joined(
        robot,
        {
            "position": turn @ body[LINEAR],
            "rotation": turn @ body[ANGULAR],
            "motors": np.eye(robot.motor_count),
            "efforts": model.efforts_by_motors,
        },
    )
    found: Floats = by_motors @ scipy.linalg.pinv(by_motors[driving])
    return found
