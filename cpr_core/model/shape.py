# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Shapes of the legs, for drawings and checks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..description.robot_description import BasePose
from ..kernels.rotation_kernel import rotation_steps
from ..rods.quadrature import MAGNUS_WEIGHTS, RodGrid, rod_grid
from ..rods.rod import StrainModes
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
    """All legs at once, step by step from base to tip."""
    legs, nominal = robot.description.legs, robot.arrays.legs["length"]
    bases = [base_pose(robot, number, state) for number in range(len(legs))]
    length = np.array([base.length for base in bases])
    grid = _grid(points)
    turns, strain = np.empty((len(legs), len(grid.steps), 3)), []
    for number, leg in enumerate(legs):
        sampled = _sampled(leg.modes, points)
        row = robot.arrays.legs[number]
        coordinates = state[row["strain_index"] :][: leg.modes.total]
        moments = np.ascontiguousarray(sampled.step_moments @ coordinates)
        rotation_steps(moments, nominal[number] * grid.steps, turns[number])
        strain.append(nominal[number] / length[number] * (sampled.values @ coordinates))
    step_turns = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix().reshape(*turns.shape, 3)
    frames = np.empty((len(legs), len(grid.steps) + 1, 3, 3))
    frames[:, 0] = [base.rotation for base in bases]
    for step in range(len(grid.steps)):
        frames[:, step + 1] = frames[:, step] @ step_turns[:, step]
    tangents = frames[:, 1:-1, :, 0]
    beyond = np.vstack([np.zeros_like(grid.weights), grid.integration, grid.weights]) @ tangents
    sigma = np.concatenate([[0.0], grid.nodes, [1.0]])
    return tuple(
        LegShape(
            arc_length=length[number] * sigma,
            position=base.position + length[number] * beyond[number],
            rotation=frames[number],
            curvature=strain[number],
        )
        for number, base in enumerate(bases)
    )


class _Sampled(NamedTuple):
    """Shape functions of a leg where its shape is wanted."""

    step_moments: Floats  # (H, 3, 3, m): moments of the three strain components over rotation steps
    values: Floats  # (P, 3, m)


@cache
def _grid(points: int) -> RodGrid:
    return rod_grid(points - 2)


@lru_cache(maxsize=64)
def _sampled(modes: StrainModes, points: int) -> _Sampled:
    """They are the same for legs of the same modes, and in every configuration."""
    grid, one_hot = _grid(points), np.eye(3)[modes.directions].T
    steps = modes.values(grid.step_points.ravel()).reshape(*grid.step_points.shape, modes.total)
    moments = np.einsum("mk,hkj,cj->hmcj", MAGNUS_WEIGHTS, steps, one_hot)
    sigma = np.concatenate([[0.0], grid.nodes, [1.0]])
    return _Sampled(moments, modes.values(sigma)[:, None, :] * one_hot)
