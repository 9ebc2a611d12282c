# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shapes of the legs, for drawings and checks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..description.robot_description import BasePose
from ..kernels.rotation_kernel import rotation_steps
from ..lie import rotation_exp
from ..rods.quadrature import MAGNUS_WEIGHTS, rod_grid
from ..validation import checked_count
from .equilibrium import Equilibrium
from .robot import Robot

__all__ = ["LegShape", "base_pose", "leg_shapes", "tip_positions"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LegShape:
    """One leg along its arc length, from base to tip.

    Attributes:
        arc_length: s, (P,) [m].
        position: Centre line in the world, (P, 3) [m].
        rotation: Cross-section frames in the world, (P, 3, 3); columns d1 (tangent), d2, d3.
        curvature: Strain (torsion, bending about d2, d3), (P, 3) [1/m].
    """

    arc_length: Floats
    position: Floats
    rotation: Floats
    curvature: Floats


def leg_shapes(equilibrium: Equilibrium, points: int = 32) -> tuple[LegShape, ...]:
    """Shape of every leg at some points, base and tip included.

    Args:
        equilibrium: Where.
        points: Points of a leg, at least 4.

    Raises:
        InvalidRequest: Too few points, or no whole number of them.
    """
    return _shapes(equilibrium.robot, equilibrium.state, checked_count("points", points, 4))


def tip_positions(robot: Robot, state: Floats) -> Floats:
    """Rod tips in the world in any state (N,), in equilibrium or not, (L, 3) [m]."""
    return np.array([shape.position[-1] for shape in _shapes(robot, state, 16)])


def base_pose(robot: Robot, leg: int, state: Floats) -> BasePose:
    """Base of a leg in any state (N,)."""
    described, indices = robot.description.legs[leg], robot.arrays.legs[leg]
    turn, shift = (
        float(state[indices[name]]) if indices[name] >= 0 else 0.0
        for name in ("rotation_index", "translation_index")
    )
    return described.base_pose(turn, shift)


def _shapes(robot: Robot, state: Floats, points: int) -> tuple[LegShape, ...]:
    grid = rod_grid(points - 2)
    sigma = np.concatenate([[0.0], grid.nodes, [1.0]])
    shapes = []
    for number, leg in enumerate(robot.description.legs):
        row = robot.arrays.legs[number]
        rotation, base, length = base_pose(robot, number, state)
        strain = state[row["strain_index"] :][: leg.modes.total]
        one_hot = np.eye(3)[leg.modes.directions]
        nominal = leg.rod.length
        curvature = (leg.modes.values(grid.step_points.ravel()) * strain) @ one_hot
        moments = MAGNUS_WEIGHTS @ curvature.reshape(*grid.step_points.shape, 3)
        vectors = np.empty((len(grid.steps), 3))
        rotation_steps(np.ascontiguousarray(moments), nominal * grid.steps, vectors)
        rotations = [rotation]
        for vector in vectors:
            rotations.append(rotations[-1] @ rotation_exp(vector))
        frames = np.array(rotations)
        tangents = frames[1:-1, :, 0]
        inner = base + length * grid.integration @ tangents
        tip = base + length * grid.weights @ tangents
        shapes.append(
            LegShape(
                arc_length=length * sigma,
                position=np.vstack([base, inner, tip]),
                rotation=frames,
                curvature=nominal / length * (leg.modes.values(sigma) * strain) @ one_hot,
            )
        )
    return tuple(shapes)
