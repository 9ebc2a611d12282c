# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A wrench on the platform as it was felt, and how well it is known."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from ..description.loads import Loads
from ..lie import turned
from ..model.equilibrium import Equilibrium
from ..validation import ReadOnlyArrays, cached_property
from .felt_directions import FeltDirections

__all__ = ["WrenchEstimate", "consistency_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class WrenchEstimate(ReadOnlyArrays):
    """A wrench on the platform, and how well it is known; b platform coordinates, f of them felt.

    Attributes:
        wrench_world: Moment, then force on the platform at its origin, in world axes, beyond ``loads``;
            of those that explain the measurements equally well the smallest near by, (6,) [N m, N].
        observability: What the measurements tell of the direction that is felt least over what they tell
            of that felt best, in natural units: 1 all alike, 0 where a direction is not felt.
        equilibrium: Where the robot is, at the measured motors under the loads and the wrench.
        chi_square: Sum of the squares of what is left of the measurements, in standard deviations.
        degrees_of_freedom: Measured numbers beyond those the wrench needs: what ``chi_square`` is to be.
        doubt: What looks like another unit in the efforts or, where the measurements contradict each
            other, like the other sign or those behind a gear, in words; empty: nothing.
        loads: What acts beside the wrench.
        directions: What is felt, and what is not.
        unloaded: Where the robot would be without the wrench, at these motors or near.
    """

    wrench_world: Floats
    observability: float
    equilibrium: Equilibrium
    chi_square: float
    degrees_of_freedom: int
    doubt: str
    loads: Loads
    directions: FeltDirections = field(repr=False)
    unloaded: Equilibrium = field(repr=False)

    def __repr__(self) -> str:
        wrench = np.array2string(self.wrench_world, precision=4)
        return f"<WrenchEstimate: {wrench} N m, N in the world; {self.words}>"

    @property
    def covariance(self) -> Floats:
        """Covariance of the wrench in the world, (6, 6) [N^2 m^2, N^2 m, N^2].

        A direction that is not felt has a standard deviation of 1000 natural units (moments E J / l,
        forces E J / l^2) instead of an infinite one, and so have those out of a planar robot's plane.
        """
        return self.directions.covariance

    @property
    def felt(self) -> Floats:
        """Wrenches in the world that are felt, the best first, as rows, (f, 6) [N m, N].

        Their size is 1 N, where moments count over the mean rod length.
        """
        return self.directions.felt

    @property
    def unfelt(self) -> Floats:
        """Wrenches that are not felt, in the same way, (b - f, 6)."""
        return self.directions.unfelt

    @property
    def wrench_body(self) -> Floats:
        """The wrench in the axes of the platform, (6,) [N m, N]."""
        return turned(self.wrench_world, self.equilibrium.platform_rotation.T)

    @cached_property
    def consistency(self) -> float:
        """Probability of a ``chi_square`` as large, had noise alone made it; 1: nothing to tell."""
        return consistency_of(self.chi_square, self.degrees_of_freedom)

    @property
    def words(self) -> str:
        """What is not felt, and what is doubted, in words."""
        return "; ".join(filter(None, [self.directions.words, self.doubt]))


def consistency_of(squares: float, freedom: int) -> float:
    """Probability of a sum of squares as large, had noise alone made it; 1: nothing to tell."""
    if freedom <= 0:
        return 1.0
    return float(scipy.special.gammaincc(0.5 * freedom, 0.5 * squares))
