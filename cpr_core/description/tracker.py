# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Who measures the platform: where a camera or another tracker is, and where its marker sits.

A tracker tells where a frame of the marker is in a frame of its own; the platform is in the world. A is
what it tells, X the tracker in the world, B the platform in the world, Y the marker in the platform:
X A = B Y (robot-world and hand-eye calibration; Shah, J. Mechanisms Robotics 5 (3), 031007, 2013).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..description_part import Described, Part
from ..lie import rotation_exp, skew
from ..validation import cached_property

__all__ = ["Tracker"]

Floats = NDArray[np.float64]
Pose = tuple[Floats, Floats]

_NOWHERE = (0.0, 0.0, 0.0)
#: Longest rotation vector [rad]: a turn, and room for differences at it.
_TURN = 2.0 * math.pi + 1e-3


@dataclass(frozen=True, eq=False)
class Tracker(Described):
    """Frames of a tracker and of its marker.

    Attributes:
        position: Of the tracker's frame in the world, (3,) [m].
        rotation_vector: Of the tracker's frame in the world, (3,) [rad].
        marker_position: Of the marker's frame in the platform, (3,) [m].
        marker_rotation_vector: Of the marker's frame in the platform, (3,) [rad].
    """

    position: Floats
    rotation_vector: Floats
    marker_position: Floats
    marker_rotation_vector: Floats

    @classmethod
    def from_description(cls, part: Part) -> Self:
        """The value the part ``tracker`` of a description stands for.

        Raises:
            DescriptionError: A rotation vector of more than a turn.
        """
        return cls(*_frame(part), *_frame(part.part("marker")))

    @cached_property
    def rotation(self) -> Floats:
        """Of the tracker's frame in the world, (3, 3)."""
        return rotation_exp(self.rotation_vector)

    @cached_property
    def marker_rotation(self) -> Floats:
        """Of the marker's frame in the platform, (3, 3)."""
        return rotation_exp(self.marker_rotation_vector)

    def marker_in_tracker(self, platform_position: Floats, platform_rotation: Floats) -> Pose:
        """What the tracker tells of a platform: position, (3,) [m], and rotation, (3, 3), X^-1 B Y.

        Args:
            platform_position: Of the platform in the world, (3,) [m].
            platform_rotation: Of the platform in the world, (3, 3).
        """
        marker_in_world = platform_position + platform_rotation @ self.marker_position
        into = self.rotation.T
        turn = into @ platform_rotation @ self.marker_rotation
        return into @ (marker_in_world - self.position), turn

    def platform_in_world(self, marker_position: Floats, marker_rotation: Floats) -> Pose:
        """The platform of which a tracker tells: position, (3,) [m], and rotation, (3, 3), X A Y^-1.

        Args:
            marker_position: Of the marker in the tracker's frame, (3,) [m].
            marker_rotation: Of the marker in the tracker's frame, (3, 3).
        """
        platform_rotation = self.rotation @ marker_rotation @ self.marker_rotation.T
        marker_in_world = self.position + self.rotation @ marker_position
        return marker_in_world - platform_rotation @ self.marker_position, platform_rotation

    def marker_motions(self, platform_rotation: Floats) -> Floats:
        """What the tracker tells of a moving platform, (6, 6): dx and a turn in its axes, of both.

        Args:
            platform_rotation: Of the platform in the world, (3, 3).
        """
        into, arm = self.rotation.T, platform_rotation @ self.marker_position
        none = np.zeros((3, 3))
        return np.block([[into, -into @ skew(arm)], [none, into]])


def _frame(part: Part) -> tuple[Floats, Floats]:
    """What the fields ``position`` and ``rotation_vector`` of a frame say, (3,) each.

    Also of a planar robot they may be anywhere: cameras hang above the plane.

    Raises:
        DescriptionError: A rotation vector of more than a turn.
    """
    vector = np.array(part.get("rotation_vector", _NOWHERE), float)
    angle = math.hypot(*vector)
    if angle > _TURN:
        problem = "expected an axis times an angle of at most a turn in radians"
        degrees = ": looks like degrees" if 10.0 < angle <= 720.0 else ""
        raise part.fail("rotation_vector", f"{problem}, got {vector.tolist()}{degrees}")
    return np.array(part.get("position", _NOWHERE), float), vector
