# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is measured of a robot that something pushes on: efforts of its motors, the pose of its platform."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.plausibility import quaternion_order_doubt, request_doubt
from ..errors import InvalidRequest, NonFiniteInput
from ..lie import quaternion_from_rotation, rotation_from_quaternion, rotation_log
from ..model.equilibrium import Equilibrium
from ..model.kinemato_statics import KinematoStatics
from ..model.robot import Robot
from ..validation import checked_vector

__all__ = ["WrenchMeasurements", "platform_turn", "wrench_measurements"]

Floats = NDArray[np.float64]

_POSE = "x y z in the world, qw qx qy qz"


@dataclass(frozen=True, eq=False)
class WrenchMeasurements:
    """Measured numbers and what one standard deviation of each weighs; M rows, b platform coordinates.

    Attributes:
        motors: Motor positions, taken as exact, (n,) [rad or m].
        efforts: Motor efforts, (n,) [N m or N]; None: not measured.
        effort_weights: One over their standard deviations, (n,); 0 where a motor has no sensor.
        position: Of the platform in the world, (3,) [m]; None: no pose is measured.
        rotation: Of the platform in the world, (3, 3).
        pose_weights: One over standard deviations of the platform coordinates, (b,).
    """

    motors: Floats
    efforts: Floats | None
    effort_weights: Floats
    position: Floats | None
    rotation: Floats
    pose_weights: Floats

    @property
    def count(self) -> int:
        """How many numbers are measured at all."""
        return int(np.count_nonzero(self.effort_weights) + np.count_nonzero(self.pose_weights))

    def residual(self, equilibrium: Equilibrium) -> Floats:
        """Measured less modelled, in standard deviations, (M,)."""
        if self.efforts is None:
            return self._pose_residual(equilibrium)
        pushed = (self.efforts - equilibrium.efforts) * self.effort_weights
        if self.position is None:
            return pushed
        return np.concatenate([pushed, self._pose_residual(equilibrium)])

    def by_wrench(self, model: KinematoStatics) -> Floats:
        """What is modelled, in standard deviations, by a wrench in world axes, (M, b).

        The rotation's residual is the logarithm of a product. That its own derivative is taken as one
        moves no solution: across the axis of the residual it differs from one, along it does not.
        """
        turn, rows = platform_turn(model.equilibrium), []
        if self.efforts is not None:
            rows.append(self.effort_weights[:, None] * (model.efforts_by_wrench @ turn.T))
        if self.position is not None:
            moved = turn @ model.platform_by_wrench @ turn.T
            rows.append(self.pose_weights[:, None] * moved)
        return rows[0] if len(rows) == 1 else np.vstack(rows)

    def by_way(self, model: KinematoStatics) -> Floats:
        """What the way from the motors of an equilibrium to the measured ones changes, to first order.

        In standard deviations, (M,).
        """
        way, parts = self.motors - model.equilibrium.motors, []
        if self.efforts is not None:
            parts.append(self.effort_weights * (model.efforts_by_motors @ way))
        if self.position is not None:
            twist = platform_turn(model.equilibrium) @ (model.jacobian @ way)
            parts.append(self.pose_weights * twist)
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def doubt(self, equilibrium: Equilibrium) -> str:
        """What looks like other units in the efforts, seen from those of the model; empty: nothing."""
        if self.efforts is None:
            return ""
        measured = float(np.linalg.norm(self.efforts))
        modelled = float(np.linalg.norm(equilibrium.efforts))
        if not modelled > 0.0 or not measured > 0.0:
            return ""
        ratio = measured / modelled
        if 300.0 < ratio < 3000.0:
            seen = "a thousand times those of the model without a wrench: are they in N mm?"
        elif 300.0 < 1.0 / ratio < 3000.0:
            seen = "a thousandth of those of the model without a wrench: are they in kN m?"
        else:
            return ""
        return f"the measured efforts are about {seen} N m and N are expected"

    def _pose_residual(self, equilibrium: Equilibrium) -> Floats:
        error = np.empty(6)
        error[:3] = rotation_log(self.rotation @ equilibrium.platform_rotation.T)
        error[3:] = self.position - equilibrium.platform_position
        return error[equilibrium.robot.platform_axes] * self.pose_weights


def platform_turn(equilibrium: Equilibrium) -> Floats:
    """World components of platform twists and wrenches in the axes of the platform, (b, b)."""
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = equilibrium.platform_rotation
    axes = equilibrium.robot.platform_axes
    return turn if len(axes) == 6 else turn[np.ix_(axes, axes)]


def wrench_measurements(
    robot: Robot,
    motors: ArrayLike,
    efforts: ArrayLike | None,
    effort_deviation: ArrayLike | None,
    pose: ArrayLike | None,
    pose_deviation: ArrayLike | None,
    seen_from: Equilibrium,
) -> WrenchMeasurements:
    """Measurements as they are handed in.

    Args:
        robot: The robot.
        motors: Motor positions in motor order, (n,) [rad or m].
        efforts: Motor efforts in motor order, (n,) [N m or N]; None: not measured.
        effort_deviation: Their standard deviations, one for all or (n,); infinite: no sensor.
        pose: x y z qw qx qy qz of the platform in the world, (7,) [m]; None: not measured.
        pose_deviation: Standard deviations of position [m] and rotation [rad], (2,).
        seen_from: Where the robot was before: what the order of a quaternion is doubted from.

    Raises:
        InvalidRequest: Wrong lengths, nothing measured, no standard deviations, or a quaternion that is
            in another order.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
    """
    if efforts is None and pose is None:
        raise InvalidRequest("efforts", "expected efforts, a pose or both, got neither")
    count, axes = robot.motor_count, robot.platform_axes
    at = checked_vector("motors", motors, count, robot.motor_list)
    pushed, effort_weights = None, np.zeros(0)
    if efforts is not None:
        pushed = checked_vector("efforts", efforts, count, robot.motor_list)
        effort_weights = _weights("effort_deviation", effort_deviation, count, "N m or N")
    position, rotation, pose_weights = None, np.eye(3), np.zeros(0)
    if pose is not None:
        given = checked_vector("pose", pose, 7, _POSE)
        position, rotation = given[:3], rotation_from_quaternion(given[3:])
        quaternion = quaternion_from_rotation(rotation)
        doubt = quaternion_order_doubt(quaternion, seen_from.platform_quaternion)
        doubt = doubt or request_doubt(robot.description, None, position)
        if doubt:
            raise InvalidRequest("pose", doubt)
        two = _weights("pose_deviation", pose_deviation, 2, "m of the position, rad of the rotation")
        pose_weights = np.where(axes < 3, two[1], two[0])
    found = WrenchMeasurements(at, pushed, effort_weights, position, rotation, pose_weights)
    if not found.count:
        raise InvalidRequest("effort_deviation", "expected a finite one at least, all are infinite")
    return found


def _weights(name: str, deviation: ArrayLike | None, size: int, meaning: str) -> Floats:
    """One over standard deviations, (size,).

    Raises:
        InvalidRequest: None, another number of them, or one that is not positive.
        NonFiniteInput: A NaN.
    """
    if deviation is None:
        raise InvalidRequest(name, f"expected standard deviations ({meaning}), got none")
    given = np.asarray(deviation)
    if given.ndim == 0 and name == "effort_deviation":
        given = np.full(size, given)
    if given.shape == (size,) and given.dtype.kind in "fiu":
        values = given.astype(float)
        if np.isnan(values).any():
            raise NonFiniteInput(name, f"expected numbers above 0, got {values.tolist()}")
        if not (values > 0.0).all():
            raise InvalidRequest(name, f"expected numbers above 0, got {values.tolist()}")
        return np.asarray(1.0 / values)
    return checked_vector(name, deviation, size, meaning)  # says what is wrong
