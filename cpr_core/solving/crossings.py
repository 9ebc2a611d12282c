# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether branches cross at a point of a path, and in how many ways they may go on."""

from __future__ import annotations

import math

import numpy as np
import scipy

from .bracketing import LOCATION
from .path import Path, Point

__all__ = ["SINGULAR", "VANISHED", "crossing_ways", "several_cross", "several_meet"]

#: Smallest singular value of a dimensionless problem where branches may cross.
SINGULAR = 1e-4
#: The same at a point that is located: soft robots have smaller ones than the above everywhere.
VANISHED = 1e-6


def several_meet(path: Path, point: Point, next_point: Point) -> bool:
    """Whether several branches meet between two neighbours, on symmetric ways of symmetric robots.

    Two singular values pass zero together, so that no sign tells.
    """
    if path.problem != "pose" or not point.watched.singularity:
        return False

    def nearness(fraction: float) -> float:
        between = path.at(point, fraction)
        return np.inf if between is None else abs(between.watched.singularity[0])

    ends = point.fraction, next_point.fraction
    nearest = scipy.optimize.minimize_scalar(
        nearness, bounds=ends, method="bounded", options={"xatol": LOCATION}
    )
    meeting = path.at(point, float(nearest.x))
    return meeting is not None and several_cross(path, meeting)


def several_cross(path: Path, point: Point, bound: float = SINGULAR) -> bool:
    """Whether more than two branches meet, as on symmetric paths of symmetric robots."""
    return crossing_ways(path, point, bound) > 1


def crossing_ways(path: Path, point: Point, bound: float = SINGULAR) -> int:
    """In how many ways branches may go on at a point, to first order: singular values below a bound."""
    if math.isnan(point.equilibrium.margin):  # what hangs is hardly held anywhere
        return path.bent_ways(point, bound)
    return int(np.sum(path.singular_values(point) < bound))
