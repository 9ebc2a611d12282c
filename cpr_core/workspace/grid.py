# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A grid of what is imposed: cells in a slice of the platform's coordinates, or of the motors'."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InvalidRequest
from ..validation import (
    ReadOnlyArrays,
    cached_array,
    cached_property,
    checked_matrix,
    checked_vector,
)

__all__ = ["Grid"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Grid(ReadOnlyArrays):
    """A lattice of imposed coordinates, affine in the numbers along its axes.

    The imposed coordinates are ``origin + a_1 directions[0] + a_2 directions[1] + ...`` with a_k out of
    ``values[k]``.

    Attributes:
        given: Whether platform coordinates or motor positions are imposed.
        names: What the coordinates are called, (C,).
        units: Their units, m or rad, (C,).
        orientation: How three of the coordinates give the orientation of the platform.
        origin: Coordinates where all axes are zero, (C,).
        directions: Change of the coordinates along the axes, (D, C).
        axis_names: Names of the axes, (D,).
        axis_units: Units of the axes, (D,).
        values: Numbers along every axis, increasing, D arrays.
        index: Place of the coordinates among those of the kernels, (C,): x y z and three angles, or the
            motors in their order.
    """

    given: Literal["pose", "motors"]
    names: tuple[str, ...]
    units: tuple[str, ...]
    orientation: str  # the key of an Orientation
    origin: Floats
    directions: Floats
    axis_names: tuple[str, ...]
    axis_units: tuple[str, ...]
    values: tuple[Floats, ...]
    index: Integers

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Cells along every axis."""
        return tuple(len(values) for values in self.values)

    @cached_property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @cached_array
    def steps(self) -> Floats:
        """Mean distance of neighbours along every axis, (D,)."""
        return np.array([np.ptp(values) / (len(values) - 1) for values in self.values])

    def places(self, cells: Integers) -> Floats:
        """Numbers along the axes of cells, (B, D), by their flat numbers (last axis fastest).

        Raises:
            InvalidRequest: No numbers of cells.
        """
        cells = np.asarray(cells)
        whole = cells.ndim == 1 and cells.dtype.kind in "iu"
        if not whole or np.any((cells < 0) | (cells >= self.size)):
            expected = f"whole numbers from 0 to {self.size - 1}"
            raise InvalidRequest("cells", f"expected {expected}, got {cells.tolist()!r:.200}")
        along = np.unravel_index(cells, self.shape)
        return np.stack(
            [values[numbers] for values, numbers in zip(self.values, along, strict=True)], axis=1
        )

    def coordinates(self, places: Floats) -> Floats:
        """Imposed coordinates at places (B, D), (B, C).

        Raises:
            InvalidRequest: No rows of as many numbers as there are axes.
            NonFiniteInput: A NaN or an infinity.
        """
        rows = checked_matrix("places", places, None, len(self.values))
        return self.origin + rows @ self.directions

    def kernel_coordinates(self, places: Floats) -> Floats:
        """The same as the kernels read them: (B, n) motors, or (B, 6) x y z and three angles."""
        coordinates = self.coordinates(places)
        width = len(self.names) if self.given == "motors" else 6
        whole = np.zeros((len(coordinates), width))
        whole[:, self.index] = coordinates
        return whole

    @cached_array
    def neighbours(self) -> Integers:
        """Flat numbers of the neighbours of every cell, (cells, 2 D); -1 where there is none.

        Column 2 k is the neighbour before along axis k, column 2 k + 1 the one after.
        """
        numbers = np.arange(self.size).reshape(self.shape)
        found = np.full((*self.shape, 2 * len(self.shape)), -1, np.int64)
        for axis in range(len(self.shape)):
            view, source = np.moveaxis(found, axis, 0), np.moveaxis(numbers, axis, 0)
            view[1:, ..., 2 * axis] = source[:-1]
            view[:-1, ..., 2 * axis + 1] = source[1:]
        return found.reshape(self.size, -1)

    def nearest(self, place: Floats) -> int:
        """Flat number of the cell nearest to a place, (D,).

        Raises:
            InvalidRequest: Not as many numbers as there are axes.
            NonFiniteInput: A NaN or an infinity.
        """
        numbers = checked_vector("place", place, len(self.values), " ".join(self.axis_names))
        along = [
            int(np.abs(values - number).argmin())
            for values, number in zip(self.values, numbers, strict=True)
        ]
        return int(np.ravel_multi_index(along, self.shape))
