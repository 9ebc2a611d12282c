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
        told: Positions of the marker, (N, 3) [m]; NaN where they were not measured.
        turned: Orientations of the marker, (N, 3, 3); NaN where they were not measured.
        places: Of the platform in the world, (N, 3) [m].
        turns: Of the platform in the world, (N, 3, 3).
        weights: One over the standard deviations of positions and rotations.
    """

    told: Floats
    turned: Floats
    places: Floats
    turns: Floats
    weights: tuple[float, float]

    @cached_property
    def placed(self) -> NDArray[np.bool_]:
        """Which rows have a position, (N,)."""
        return np.asarray(np.isfinite(self.told).all(axis=1))

    @cached_property
    def oriented(self) -> NDArray[np.bool_]:
        """Which rows have an orientation, (N,)."""
        return np.isfinite(self.turned[:, 0, 0])

    def differences(self, tracker: Tracker) -> Floats:
        """Predicted less measured in standard deviations, those that were measured, (M,)."""
        markers = self.places + self.turns @ tracker.marker_position
        apart = ((markers - tracker.position) @ tracker.rotation - self.told)[self.placed]
        return np.concatenate(
            [self.weights[0] * apart.ravel(), self.weights[1] * self._turned_by(tracker).ravel()]
        )

    def rates(self, tracker: Tracker) -> Floats:
        """How they change with the numbers of the tracker, (M, 12), in the order of its fields."""
        into = tracker.rotation.T
        turned = into @ turns_by_vector(tracker.rotation_vector)
        turns = self.turns[self.placed]
        markers = self.places[self.placed] + turns @ tracker.marker_position
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
            @ self.turns[self.oriented]
            @ turns_by_vector(tracker.marker_rotation_vector)
        )
        return np.concatenate(
            [self.weights[0] * places.reshape(-1, 12), self.weights[1] * angles.reshape(-1, 12)]
        )

    def _turned_by(self, tracker: Tracker) -> Floats:
        """Rotation vectors from measured to predicted orientations, of rows that have one, (., 3)."""
        predicted = tracker.rotation.T @ self.turns[self.oriented] @ tracker.marker_rotation
        return rotations_log(predicted @ self.turned[self.oriented].swapaxes(1, 2))
