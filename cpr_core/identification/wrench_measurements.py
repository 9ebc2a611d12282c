# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is measured of a robot that something pushes on: motor efforts, the pose of its platform."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..description.controlled_coordinates import numbers_of
from ..description.doubted_requests import quaternion_order_doubt, request_doubt
from ..errors import InvalidRequest, NonFiniteInput
from ..kernels.twist_layout import FIRST_LINEAR
from ..lie import rotation_from_quaternion
from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, kept_with_robot
from ..model.world_response import WorldResponse, effort_units, twist_units
from ..validation import checked_vector
from .effort_doubts import effort_unit_doubt, other_efforts
from .measurement_doubts import plane_doubt
from .measurements import LARGEST_DEVIATION, SMALLEST_DEVIATION
from .residual_kernel import residual_into

__all__ = ["WrenchMeasurements", "wrench_measurements"]

Floats = NDArray[np.float64]

#: What is not measured, of the same types for the kernel: read-only, but for the turn.
_NO_EFFORTS, _NO_PLACE, _NO_TURN = np.zeros(0), np.zeros(3), np.eye(3)
_NO_EFFORTS.flags.writeable = _NO_PLACE.flags.writeable = False
#: Trace of a turn by a right angle: less is farther, and only there an order of numbers is doubted.
_FAR_TRACE = 1.0
#: So many weights are kept: a camera may send other deviations with every pose.
_KEPT = 100
_OF_EFFORTS, _OF_POSE = "N m or N", "m of the position, rad of the rotation"
_POSE = "x y z in the world, qw qx qy qz"


@dataclass(frozen=True, eq=False)
class WrenchWeights:
    """One over the standard deviations of measured numbers: efforts, then platform coordinates; M rows.

    Attributes:
        rows: (M,) [1/(N m), 1/N, 1/rad, 1/m]; 0 for what is not measured, a motor without a sensor.
        natural: The same in natural units, (M,).
        count: How many numbers are measured at all.
    """

    rows: Floats
    natural: Floats
    count: int


@dataclass(frozen=True, eq=False)
class WrenchMeasurements:
    """Measured numbers and what one standard deviation of each weighs; M rows, b platform coordinates.

    Attributes:
        motors: Motor positions, taken as exact, (n,) [rad or m].
        efforts: Motor efforts, (n,) [N m or N]; None: not measured.
        position: Of the platform in the world, (3,) [m]; None: no pose is measured.
        rotation: Of the platform in the world, (3, 3).
        weights: Of efforts and pose, as far as measured.
    """

    motors: Floats
    efforts: Floats | None
    position: Floats | None
    rotation: Floats
    weights: WrenchWeights

    @property
    def rows(self) -> int:
        """M: how many numbers are compared, without weight or not."""
        return len(self.weights.rows)

    def residual(self, equilibrium: Equilibrium) -> Floats:
        """Measured less modelled, in standard deviations, (M,)."""
        residual, robot = np.empty(self.rows), equilibrium.robot
        residual_into(
            _NO_EFFORTS if self.efforts is None else self.efforts,
            _NO_PLACE if self.position is None else self.position,
            self.rotation,
            robot.kernel_arrays.platform_axes,
            self.weights.rows,
            equilibrium.record,
            robot.state_size,
            np.empty((2, 3, 3)),
            residual,
        )
        return residual

    def by_wrench(self, response: WorldResponse) -> Floats:
        """What is modelled, in standard deviations, by a world wrench in natural units, (M, b).

        The rotation's residual is the logarithm of a product. That its own derivative is taken as one
        moves no solution: across the axis of the residual it differs from one, along it does not.
        """
        rows = self._measured(response.efforts_by_wrench, response.twist_by_wrench)
        return np.asarray(rows * self.weights.natural[:, None])

    def by_way(self, response: WorldResponse) -> Floats:
        """What the way from the motors of an equilibrium to the measured ones changes, to first order.

        In standard deviations, (M,).
        """
        start = response.equilibrium
        way = (self.motors - start.motors) / start.robot.motor_units
        efforts, twist = response.by_way(way)
        return self._measured(efforts, twist) * self.weights.natural

    def _measured(self, efforts: Floats, twists: Floats) -> Floats:
        """Of rows of efforts and twists those that are compared."""
        if self.efforts is None:
            return twists
        return efforts if self.position is None else np.concatenate([efforts, twists])

    def doubt(self, equilibrium: Equilibrium) -> str:
        """What looks like other units in the efforts, seen from those of the model; empty: nothing."""
        if self.efforts is None:
            return ""
        return effort_unit_doubt(equilibrium.robot, self._known_efforts, equilibrium.efforts)

    def other_efforts(self, equilibrium: Equilibrium) -> Iterator[tuple[WrenchMeasurements, str]]:
        """The same with efforts that are near those of the model, and what then looks wrong."""
        if self.efforts is None:
            return
        given = self._known_efforts, equilibrium.efforts
        for reading in other_efforts(equilibrium.robot, *given):
            yield replace(self, efforts=reading.factors * self.efforts), reading.doubt

    @property
    def _known_efforts(self) -> Floats:
        """Motor efforts, NaN for motors without a sensor, (n,) [N m or N]; (0,) if none is measured."""
        if self.efforts is None:
            return _NO_EFFORTS
        return np.where(self.weights.rows[: len(self.efforts)] > 0.0, self.efforts, np.nan)


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
        InvalidRequest: Wrong lengths, nothing measured, no standard deviations, a quaternion that is in
            another order, or a pose far out of the plane of a planar robot.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
    """
    if efforts is None and pose is None:
        raise InvalidRequest("efforts", "expected efforts, a pose or both, got neither")
    count = robot.motor_count
    at = checked_vector("motors", motors, count, robot.motor_list)
    pushed = None
    if efforts is not None:
        pushed = checked_vector("efforts", efforts, count, robot.motor_list)
    position, rotation = None, _NO_TURN
    if pose is not None:
        position, rotation = _checked_pose(robot, pose, seen_from)
    of_efforts = of_pose = None
    if efforts is not None:
        of_efforts = _numbers("effort_deviation", effort_deviation, _OF_EFFORTS)
    if pose is not None:
        of_pose = _numbers("pose_deviation", pose_deviation, _OF_POSE)
    weights = _weights(robot, of_efforts, of_pose)
    if robot.planar and of_pose is not None:
        doubt = plane_doubt(robot, position, rotation, float(of_pose[0]), float(of_pose[1]))
        if doubt:
            raise InvalidRequest("pose", doubt)
    return WrenchMeasurements(at, pushed, position, rotation, weights)


def _checked_pose(robot: Robot, pose: ArrayLike, seen_from: Equilibrium) -> tuple[Floats, Floats]:
    """Position and rotation of a pose, unless it looks like other units or another order.

    Raises:
        InvalidRequest: It does, or is no pose.
        InvalidQuaternion: A quaternion far from unit length.
        NonFiniteInput: A NaN or an infinity.
    """
    try:
        given = checked_vector("pose", pose, 7, _POSE)
    except NonFiniteInput:
        raise
    except InvalidRequest as error:
        names = " ".join(numbers_of(robot.description.controlled)) or "none"
        told = f"Equilibrium.pose has the coordinates that this robot controls ({names})"
        meant = "give [*platform_position, *platform_quaternion]"
        raise InvalidRequest("pose", f"{error.problem}; {told}: {meant}") from None
    position, rotation = given[:3], rotation_from_quaternion(given[3:])
    doubt = ""
    if np.vdot(rotation, seen_from.platform_rotation) < _FAR_TRACE:
        doubt = quaternion_order_doubt(given[3:], seen_from.platform_quaternion)
    if math.dist(position.tolist(), seen_from.platform_position.tolist()) > robot.mean_length:
        doubt = doubt or request_doubt(robot.description, None, position)
    if doubt:
        raise InvalidRequest("pose", doubt)
    return position, rotation


def _numbers(name: str, deviation: ArrayLike | None, meaning: str) -> NDArray[Any]:
    """Standard deviations as they are handed in.

    Raises:
        InvalidRequest: None, or no numbers.
    """
    if deviation is None:
        raise InvalidRequest(name, f"expected standard deviations ({meaning}), got none")
    try:
        given = np.asarray(deviation)
    except ValueError:  # rows of different lengths
        given = np.zeros(0, object)
    if given.dtype.kind not in "fiu":
        raise InvalidRequest(name, f"expected numbers ({meaning}), got {deviation!r:.200}")
    return given


def _by_value(of_efforts: NDArray[Any] | None, of_pose: NDArray[Any] | None) -> Hashable:
    """Arrays are others' own: mostly they are equal to those of the sample before."""
    return tuple(
        each is not None and (each.dtype.str, each.shape, each.tobytes())
        for each in (of_efforts, of_pose)
    )


@partial(kept_with_robot, most=_KEPT, by=_by_value)
def _weights(
    robot: Robot, of_efforts: NDArray[Any] | None, of_pose: NDArray[Any] | None
) -> WrenchWeights:
    """Weights from standard deviations, as far as measured.

    Raises:
        InvalidRequest: Another number of them, one that is not positive or that is too small or too
            large for its square, or all infinite.
        NonFiniteInput: A NaN.
    """
    rows, natural, count = [], [], robot.motor_count
    names = []
    if of_efforts is not None:
        names.append("effort_deviation")
        given = of_efforts if of_efforts.ndim else np.full(count, of_efforts)
        rows.append(_reciprocals("effort_deviation", given, count, _OF_EFFORTS))
        natural.append(rows[-1] * effort_units(robot))
    if of_pose is not None:
        names.append("pose_deviation")
        position, rotation = _reciprocals("pose_deviation", of_pose, 2, _OF_POSE)
        rows.append(np.where(robot.platform_axes < FIRST_LINEAR, rotation, position))
        natural.append(rows[-1] * twist_units(robot))
    joined = np.concatenate(rows)
    measured = int(np.count_nonzero(joined))
    if not measured:
        freedom = (
            ""
            if (robot.platform_axes < FIRST_LINEAR).any()
            else " (a point platform has no rotation)"
        )
        problem = f"expected a finite one at least, all are infinite{freedom}"
        raise InvalidRequest(" and ".join(names), problem)
    return WrenchWeights(joined, np.concatenate(natural), measured)


def _reciprocals(name: str, deviation: NDArray[Any], size: int, meaning: str) -> Floats:
    """One over standard deviations, (size,)."""
    if deviation.shape != (size,):
        checked_vector(name, deviation, size, meaning)  # says what is wrong
    values = deviation.astype(float)
    if not np.all(values > 0.0):
        error = NonFiniteInput if np.any(np.isnan(values)) else InvalidRequest
        raise error(name, f"expected numbers above 0, got {values.tolist()}")
    finite = values[np.isfinite(values)]
    if np.any((finite < SMALLEST_DEVIATION) | (finite > LARGEST_DEVIATION)):
        limits = f"from {SMALLEST_DEVIATION:g} to {LARGEST_DEVIATION:g}"
        problem = f"expected numbers {limits}, infinite for what is not measured"
        raise InvalidRequest(name, f"{problem}, got {values.tolist()}")
    return np.asarray(1.0 / values)
