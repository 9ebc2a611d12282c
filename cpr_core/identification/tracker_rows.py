# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How far what a tracker told is from what it should tell, and how that changes with its numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.tracker import Tracker
from ..lie import rotations_log, turns_by_vector, vectors_by_turn
from ..validation import cached_property

__all__ = ["TrackerRows"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TrackerRows:
    """What was measured of N rows, and where the platform then should be.

    Attributes:
        marker_positions: In the tracker's frame, (N, 3) [m]; NaN where they were not measured.
        marker_rotations: In the tracker's frame, (N, 3, 3); NaN where they were not measured.
        platform_positions: In the world, (N, 3) [m].
        platform_rotations: In the world, (N, 3, 3).
        position_weight: One over the standard deviation of positions [1/m].
        rotation_weight: One over the standard deviation of rotations [1/rad].
    """

    marker_positions: Floats
    marker_rotations: Floats
    platform_positions: Floats
    platform_rotations: Floats
    position_weight: float
    rotation_weight: float

    @cached_property
    def placed(self) -> NDArray[np.bool_]:
        """Which rows have a position, (N,)."""
        return np.asarray(np.isfinite(self.marker_positions).all(axis=1))

    @cached_property
    def oriented(self) -> NDArray[np.bool_]:
        """Which rows have an orientation, (N,)."""
        return np.isfinite(self.marker_rotations[:, 0, 0])

    def markers(self, tracker: Tracker) -> Floats:
        """Where the marker is in the world as the platform has it, (N, 3) [m]."""
        return self.platform_positions + self.platform_rotations @ tracker.marker_position

    def differences(self, tracker: Tracker) -> Floats:
        """Predicted less measured in standard deviations, those that were measured, (M,)."""
        apart = (
            (self.markers(tracker) - tracker.position) @ tracker.rotation - self.marker_positions
        )[self.placed]
        return np.concatenate(
            [
                self.position_weight * apart.ravel(),
                self.rotation_weight * self._turned_by(tracker).ravel(),
            ]
        )

    def rates(self, tracker: Tracker) -> Floats:
        """How they change with the numbers of the tracker, (M, 12), in the order of its fields."""
        into = tracker.rotation.T
        turned = into @ turns_by_vector(tracker.rotation_vector)
        turns = self.platform_rotations[self.placed]
        markers = self.platform_positions[self.placed] + turns @ tracker.marker_position
        places = np.zeros((len(turns), 3, 12))
        places[:, :, 0:3] = -into
        places[:, :, 3:6] = np.cross(
            ((markers - tracker.position) @ into.T)[:, None], turned.T
        ).swapaxes(1, 2)
        places[:, :, 6:9] = into @ turns
        vectors = vectors_by_turn(self._turned_by(tracker))
        angles = np.zeros((len(vectors), 3, 12))
        angles[:, :, 3:6] = -vectors @ turned
        angles[:, :, 9:12] = (
            vectors
            @ into
            @ self.platform_rotations[self.oriented]
            @ turns_by_vector(tracker.marker_rotation_vector)
        )
        return np.concatenate(
            [
                self.position_weight * places.reshape(-1, 12),
                self.rotation_weight * angles.reshape(-1, 12),
            ]
        )

    def _turned_by(self, tracker: Tracker) -> Floats:
        """Rotation vectors from measured to predicted orientations, of rows that have one, (., 3)."""
        predicted = (
            tracker.rotation.T @ self.platform_rotations[self.oriented] @ tracker.marker_rotation
        )
        return rotations_log(predicted @ self.marker_rotations[self.oriented].swapaxes(1, 2))
