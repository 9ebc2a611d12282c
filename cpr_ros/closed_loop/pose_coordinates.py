# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Differences of platform poses in the coordinates a robot controls. No ROS here."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpr_core import Robot
from cpr_core.lie import (
    angle_motions,
    quaternion_from_rotation,
    rotation_exp,
    rotation_from_quaternion,
    rotation_log,
)
from cpr_core.solving.requests import pose_meaning

__all__ = ["PoseCoordinates"]

Floats = NDArray[np.float64]

_POSITIONS = ("x", "y", "z")
_ANGLES = ("roll", "pitch", "yaw")


class PoseCoordinates:
    """Poses as a manifold: numbers in the order of the description, and ways between them.

    A pose has the numbers of :func:`cpr_core.solve_inverse`. A way is what leads from one pose to
    another: the positions [m] and single angles [rad] the pose has, in its order, then the rotation
    vector in the base frame [rad] where the whole orientation is controlled.

    Attributes:
        names: Names of the numbers of a pose; none if the robot controls nothing.
        nowhere: The pose of zeros and no rotation.
    """

    def __init__(self, robot: Robot) -> None:
        """Take the controlled coordinates of a robot."""
        self.names = pose_meaning(robot)
        self._length = robot.mean_length
        plain = [name for name in self.names if not name.startswith("q")]
        self._plain = np.array([self.names.index(name) for name in plain], int)
        self._single = np.array([name not in _POSITIONS for name in plain], bool)
        self._quaternion: slice | None = None
        self.nowhere = np.zeros(len(self.names))
        if "qw" in self.names:
            first = self.names.index("qw")
            self._quaternion = slice(first, first + 4)
            self.nowhere[first] = 1.0

    def way(self, first: Floats, last: Floats) -> Floats:
        """The way from one pose to another; angles go the short way."""
        plain = last[self._plain] - first[self._plain]
        turns = np.round(plain / (2.0 * np.pi))
        plain = np.where(self._single, plain - 2.0 * np.pi * turns, plain)
        if self._quaternion is None:
            return plain
        turn = self._rotation(last) @ self._rotation(first).T
        return np.concatenate([plain, rotation_log(turn)])

    def moved(self, pose: Floats, way: Floats) -> Floats:
        """The pose at the end of a way."""
        moved = pose.copy()
        count = len(self._plain)
        moved[self._plain] += way[:count]
        if self._quaternion is not None:
            rotation = rotation_exp(way[count:]) @ self._rotation(pose)
            moved[self._quaternion] = quaternion_from_rotation(rotation)
        return moved

    def sizes(self, way: Floats) -> tuple[float, float]:
        """Distance [m] and angle [rad] of a way; NaN for what the robot does not control."""
        plain, turn = way[: len(self._plain)], way[len(self._plain) :]
        positions, angles = plain[~self._single], np.concatenate([plain[self._single], turn])
        return (
            float(np.linalg.norm(positions)) if len(positions) else np.nan,
            float(np.linalg.norm(angles)) if len(angles) else np.nan,
        )

    def size(self, way: Floats) -> float:
        """Larger one of distance, in rod lengths, and angle [rad]."""
        distance, angle = self.sizes(way)
        return float(np.nanmax([distance / self._length, angle, 0.0]))

    def velocity(self, twist: Floats, rotation: Floats) -> Floats:
        """Way per second of a platform with a twist.

        Args:
            twist: [omega; v] in the base frame, (6,) [rad/s, m/s].
            rotation: Of the platform, (3, 3).
        """
        rates: dict[str, float] = dict(zip(_POSITIONS, twist[3:], strict=True))
        rates["angle"] = twist[2]
        if set(_ANGLES) & set(self.names):  # at a pitch of 90 degrees they are not unique
            angles = np.linalg.lstsq(angle_motions(rotation), twist[:3], rcond=None)[0]
            rates |= dict(zip(_ANGLES, angles, strict=True))
        plain = np.array([rates[self.names[place]] for place in self._plain])
        return plain if self._quaternion is None else np.concatenate([plain, twist[:3]])

    def _rotation(self, pose: Floats) -> Floats:
        return rotation_from_quaternion(pose[self._quaternion])
