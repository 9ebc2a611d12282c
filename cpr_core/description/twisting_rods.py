# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rods that would twist under load, of descriptions that say nothing of torsion."""

from __future__ import annotations

import math

import numpy as np

from ..description_part import Part
from ..errors import first_and_others
from ..lie import skew
from .leg_description import LegDescription
from .robot_description import RobotDescription

__all__ = ["check_twist"]

#: Difference of the stiffness to two sides, relative, that is none.
_EQUAL = 1e-6


def check_twist(part: Part, description: RobotDescription) -> None:
    """Whether rods that cannot twist are meant to: by default a rod has no modes of torsion.

    Args:
        part: The whole description.
        description: The same.
    """
    if description.planar or math.isfinite(description.tolerance) or _written(part):
        return
    legs = part.parts("legs")
    twisted = {
        leg.name: why
        for own, leg in zip(legs, description.legs, strict=True)
        if not _written(own) and (why := _twisted_by(leg))
    }
    if not twisted:
        return
    named, why = first_and_others(list(twisted)), next(iter(twisted.values()))
    part.warn(
        "strain",
        f"no torsion is written, and 0 is the default, but {named} would twist under load: {why}; "
        "give torsion: 2, a tolerance in place of numbers of modes, or torsion: 0 if that is meant "
        "(error_of tells what it does)",
    )


def _written(part: Part) -> bool:
    """Whether the robot, a leg, or one of its rods has a number of modes of torsion."""
    owners = (part, *part.parts("chain"))
    return any("torsion" in owner.part("strain") for owner in owners)


def _twisted_by(leg: LegDescription) -> str:
    """Why the rods of a leg twist under load, in words; empty: they do not, or may."""
    rods = [element for element in leg.rods if not element.modes.counts[0]]
    if not rods:
        return ""
    along = skew(np.array([1.0, 0.0, 0.0]))
    if any(np.any(constraint @ along) for constraint in leg.joint.orientation(False)):
        return "its tip joint holds them about their tangent"
    for element in rods:
        _, second, third = element.rod.rigidities
        if any(np.any(series) for series in element.rod.rest_curvature[1:]):
            return "it is bent at rest"
        if abs(second - third) > _EQUAL * max(second, third):
            return "its rod is stiffer to one side than to the other"
    return ""
