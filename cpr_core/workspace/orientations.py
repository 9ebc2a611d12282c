# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How three of the coordinates of a grid give the orientation of the platform."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["Orientation"]


class Orientation(IntEnum):
    """How an orientation is imposed, as the kernels number it; grids and files have the key."""

    NONE = 0
    ZYZ = 1  # Rz(phi) Ry(theta) Rz(psi)
    ROLL_PITCH_YAW = 2
    SINGLE_ANGLES = 3  # some of roll, pitch and yaw; the others are what they are
    PLANAR = 4

    @property
    def key(self) -> str:
        """What ``Grid.orientation`` calls it."""
        return self.name.lower()

    @classmethod
    def of(cls, key: str) -> Orientation:
        """The one with a key."""
        return cls[key.upper()]
