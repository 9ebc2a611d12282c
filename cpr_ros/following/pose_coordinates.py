# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Differences of platform poses in the coordinates a robot controls. No ROS here."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot
from cpr_core.description.controlled_coordinates import CONTROLLED_COORDINATES, numbers_of
from cpr_core.kernels.twist_layout import ANGULAR, FIRST_LINEAR, LINEAR
from cpr_core.lie import (
    angle_motions,
    quaternion_from_rotation,
    roll_pitch_yaw,
    rotation_exp,
    rotation_from_quaternion,
    turn_between,
)
from cpr_core.model.robot import kept_with_robot

__all__ = ["PoseCoordinates", "pose_coordinates"]

Floats = NDArray[np.float64]

_TURN = 2.0 * math.pi
#: Part of a turn that angles may leave out, and rate of one per rate of the turn (a pitch of 1.47 rad).
_UNTOLD, _FASTEST = 1e-6, 10.0


class PoseCoordinates:
    """Poses as a manifold: numbers in the order of the description, and ways between them.

    A pose has the numbers of :func:`cpr_core.solve_inverse`. A way is what leads from one pose to
    another: the positions [m] and single angles [rad] the pose has, in its order, then the rotation
    vector in the base frame [rad] where the whole orientation is controlled.

    Attributes:
        names: Names of the numbers of a pose; none if the robot controls nothing.
        nowhere: The pose of zeros and no rotation.
    """

    # In lists: numpy takes several times as long on so few numbers when it has not run lately.

    def __init__(self, robot: Robot) -> None:
        """Take the controlled coordinates of a robot."""
        self.names = numbers_of(robot.description.controlled)
        self._length, self._controls_angles = robot.mean_length, robot.controls_angles
        # Place and axis of the numbers that are no quaternion, and the axes of a way.
        self._plain = [
            (place, CONTROLLED_COORDINATES[name].axes[0])
            for place, name in enumerate(self.names)
            if name in CONTROLLED_COORDINATES
        ]
        self._axes = [axis for _, axis in self._plain]
        self._quaternion: slice | None = None
        self.nowhere = np.zeros(len(self.names))
        if "qw" in self.names:
            first = self.names.index("qw")
            self._quaternion = slice(first, first + 4)
            self._axes += range(3)
            self.nowhere[first] = 1.0
        self.nowhere.setflags(write=False)
        self._by_axis = sorted(range(len(self._axes)), key=self._axes.__getitem__)

    def way(self, first: Floats, last: Floats) -> Floats:
        """The way from one pose to another; angles go the short way."""
        before, after, way = first.tolist(), last.tolist(), list[float]()
        for place, axis in self._plain:
            change = after[place] - before[place]
            turns = 0 if axis >= FIRST_LINEAR else round(change / _TURN)
            way.append(change - _TURN * turns)
        if self._quaternion is not None:
            way += turn_between(first[self._quaternion], last[self._quaternion]).tolist()
        return np.array(way)

    def moved(self, pose: Floats, way: Floats) -> Floats:
        """The pose at the end of a way."""
        moved, count = pose.copy(), len(self._plain)
        for (place, _), change in zip(self._plain, way[:count].tolist(), strict=True):
            moved[place] += change
        if self._quaternion is not None:
            rotation = rotation_exp(way[count:]) @ rotation_from_quaternion(pose[self._quaternion])
            moved[self._quaternion] = quaternion_from_rotation(rotation)
        return moved

    def position(self, pose: Floats, others: Floats) -> Floats:
        """Where a pose has the platform, (3,) [m]; what it leaves open is as in others, (3,)."""
        position = others.copy()
        for place, axis in self._plain:
            if axis >= FIRST_LINEAR:
                position[axis - FIRST_LINEAR] = pose[place]
        return position

    def sizes(self, way: Floats) -> tuple[float, float]:
        """Distance [m] and angle [rad] of a way; NaN for what the robot does not control."""
        positions, angles = self._parts(way)
        return (
            math.hypot(*positions) if positions else math.nan,
            math.hypot(*angles) if angles else math.nan,
        )

    def size(self, way: Floats) -> float:
        """Larger one of distance, in rod lengths, and angle [rad]."""
        positions, angles = self._parts(way)
        # Not by squares: those of a pose far beyond all robots are infinite.
        return max(math.hypot(*positions) / self._length, math.hypot(*angles))

    def by_axis(self, way: Floats) -> Floats:
        """A way in the order that ``KinematoStatics.motors_by_pose`` takes it in."""
        return way[self._by_axis]

    def velocity(self, twist: Floats, rotation: Floats) -> Floats:
        """Way per second of a platform with a twist.

        Args:
            twist: [omega; v] in the base frame, (6,) [rad/s, m/s].
            rotation: Of the platform, (3, 3).
        """
        rates = twist
        if self._controls_angles:
            rates = np.concatenate([_angle_rates(twist, rotation)[0], twist[LINEAR]])
        return rates[self._axes]

    def untold(self, twist: Floats, rotation: Floats) -> str:
        """Why single angles do not tell the turn of a twist, in words; empty: they do.

        Arguments as in :meth:`velocity`.
        """
        largest = float(np.abs(twist[ANGULAR]).max())
        if not self._controls_angles or largest == 0.0:
            return ""
        rates, left = _angle_rates(twist / largest, rotation)
        fastest = float(np.abs([rates[axis] for axis in self._axes if axis < FIRST_LINEAR]).max())
        if left <= _UNTOLD and fastest <= _FASTEST:
            return ""
        pitch = float(roll_pitch_yaw(rotation)[1])
        return (
            f"at a pitch of {pitch:.3g} rad the angles that are controlled do not tell this turn: near "
            "pi/2 roll and yaw are about one axis; turn the platform's frame, or control its orientation"
        )

    def _parts(self, way: Floats) -> tuple[list[float], list[float]]:
        """Positions [m] and angles [rad] of a way."""
        positions, angles = list[float](), list[float]()
        for axis, number in zip(self._axes, way.tolist(), strict=True):
            (positions if axis >= FIRST_LINEAR else angles).append(number)
        return positions, angles


def _angle_rates(twist: Floats, rotation: Floats) -> tuple[Floats, float]:
    """Rates of roll, pitch and yaw of a twist, (3,), and how much of its turn they leave out [rad/s]."""
    motions, turn = angle_motions(rotation), twist[ANGULAR]
    # At a pitch of 90 degrees they are not unique.
    rates = np.asarray(np.linalg.lstsq(motions, turn, rcond=None)[0], np.float64)
    return rates, float(np.linalg.norm(motions @ rates - turn))


@kept_with_robot
def pose_coordinates(robot: Robot) -> PoseCoordinates:
    """The coordinates a robot controls, made once for every robot."""
    return PoseCoordinates(robot)
