# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is measured of a robot that something pushes on: motor efforts, the pose of its platform."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.plausibility import quaternion_order_doubt, request_doubt
from ..errors import InvalidRequest, NonFiniteInput
from ..lie import rotation_from_quaternion, rotation_log
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot
from ..model.world_response import WorldResponse, effort_units, twist_units
from ..validation import checked_vector

__all__ = ["WrenchMeasurements", "wrench_measurements"]

Floats = NDArray[np.float64]

_NONE, _NO_TURN = np.zeros(0), np.eye(3)
#: A factor of efforts that looks like a thousand; what such efforts are large and small beside.
_IS_THOUSAND, _LARGE, _SMALL = (200.0, 5000.0), 10.0, 0.01
#: Trace of a turn by a right angle: less is farther, and only there an order of numbers is doubted.
_FAR_TRACE = 1.0
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
        natural_weights: The same of efforts and pose, as far as measured, in natural units, (M,).
        count: How many numbers are measured at all.
    """

    motors: Floats
    efforts: Floats | None
    effort_weights: Floats
    position: Floats | None
    rotation: Floats
    pose_weights: Floats
    natural_weights: Floats
    count: int

    @property
    def rows(self) -> int:
        """M: how many numbers are compared, without weight or not."""
        return len(self.effort_weights) + len(self.pose_weights)

    def residual(self, equilibrium: Equilibrium) -> Floats:
        """Measured less modelled, in standard deviations, (M,)."""
        parts = []
        if self.efforts is not None:
            parts.append((self.efforts - equilibrium.efforts) * self.effort_weights)
        if self.position is not None:
            error = np.empty(6)
            error[:3] = rotation_log(self.rotation @ equilibrium.platform_rotation.T)
            error[3:] = self.position - equilibrium.platform_position
            parts.append(error[equilibrium.robot.platform_axes] * self.pose_weights)
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def by_wrench(self, response: WorldResponse) -> Floats:
        """What is modelled, in standard deviations, by a world wrench in natural units, (M, b).

        The rotation's residual is the logarithm of a product. That its own derivative is taken as one
        moves no solution: across the axis of the residual it differs from one, along it does not.
        """
        rows = self._measured(response.efforts_by_wrench, response.twist_by_wrench)
        return np.asarray(rows * self.natural_weights[:, None])

    def by_way(self, response: WorldResponse) -> Floats:
        """What the way from the motors of an equilibrium to the measured ones changes, to first order.

        In standard deviations, (M,).
        """
        robot = response.equilibrium.robot
        way = (self.motors - response.equilibrium.motors) / robot.motor_units
        rows = self._measured(response.efforts_by_motors @ way, response.twist_by_motors @ way)
        return rows * self.natural_weights

    def _measured(self, efforts: Floats, twists: Floats) -> Floats:
        """Of rows of efforts and twists those that are compared."""
        if self.efforts is None:
            return twists
        return efforts if self.position is None else np.concatenate([efforts, twists])

    def doubt(self, equilibrium: Equilibrium) -> str:
        """What looks like other units in the efforts, seen from those of the model; empty: nothing."""
        if self.efforts is None:
            return ""
        # Torques in E J / l, forces in E J / l^2, so that motors that turn and such that push add up.
        units = effort_units(equilibrium.robot)
        measured = float(np.linalg.norm(self.efforts / units))
        modelled = float(np.linalg.norm(equilibrium.efforts / units))
        if _IS_THOUSAND[0] * modelled < measured < _IS_THOUSAND[1] * modelled and measured > _LARGE:
            seen = "a thousand times those of the model without a wrench: are they in N mm?"
        elif (
            _IS_THOUSAND[0] * measured < modelled < _IS_THOUSAND[1] * measured and modelled > _SMALL
        ):
            seen = "a thousandth of those of the model without a wrench: are they in kN m?"
        else:
            return ""
        return f"the measured efforts are about {seen} N m and N are expected"


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
    pushed, effort_weights = None, _NONE
    if efforts is not None:
        pushed = checked_vector("efforts", efforts, count, robot.motor_list)
        effort_weights = _weights("effort_deviation", effort_deviation, count, "N m or N")
    position, rotation, pose_weights = None, _NO_TURN, _NONE
    if pose is not None:
        given = checked_vector("pose", pose, 7, _POSE)
        position, rotation = given[:3], rotation_from_quaternion(given[3:])
        doubt = ""
        if np.vdot(rotation, seen_from.platform_rotation) < _FAR_TRACE:
            doubt = quaternion_order_doubt(given[3:], seen_from.platform_quaternion)
        if math.dist(position.tolist(), seen_from.platform_position.tolist()) > robot.mean_length:
            doubt = doubt or request_doubt(robot.description, None, position)
        if doubt:
            raise InvalidRequest("pose", doubt)
        two = _weights(
            "pose_deviation", pose_deviation, 2, "m of the position, rad of the rotation"
        )
        pose_weights = np.where(axes < 3, two[1], two[0])
    measured = int(np.count_nonzero(effort_weights) + np.count_nonzero(pose_weights))
    if not measured:
        raise InvalidRequest("effort_deviation", "expected a finite one at least, all are infinite")
    natural = []
    if pushed is not None:
        natural.append(effort_weights * effort_units(robot))
    if position is not None:
        natural.append(pose_weights * twist_units(robot))
    return WrenchMeasurements(
        at,
        pushed,
        effort_weights,
        position,
        rotation,
        pose_weights,
        np.concatenate(natural),
        measured,
    )


def _weights(name: str, deviation: ArrayLike | None, size: int, meaning: str) -> Floats:
    """One over standard deviations, (size,).

    Raises:
        InvalidRequest: None, another number of them, or one that is not positive.
        NonFiniteInput: A NaN.
    """
    if deviation is None:
        raise InvalidRequest(name, f"expected standard deviations ({meaning}), got none")
    if isinstance(deviation, float) and name == "effort_deviation" and deviation > 0.0:
        return np.full(size, 1.0 / deviation)
    given = np.asarray(deviation)
    if given.ndim == 0 and name == "effort_deviation":
        given = np.full(size, given)
    if given.shape == (size,) and given.dtype.kind in "fiu":
        values = given.astype(float)
        numbers = values.tolist()  # of so few quicker than numpy
        if not all(number > 0.0 for number in numbers):
            error = NonFiniteInput if any(map(math.isnan, numbers)) else InvalidRequest
            raise error(name, f"expected numbers above 0, got {numbers}")
        return np.asarray(1.0 / values)
    return checked_vector(name, deviation, size, meaning)  # says what is wrong
