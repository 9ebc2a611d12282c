# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The shape a robot is assembled from: what its description knows of home, joints still open."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ..description.robot_description import HomeGuess
from ..model.robot import Robot
from ..model.shape import Pose, rod_bases, tip_poses
from ..model.state_numbers import RodNumbers

__all__ = ["platform_between_tips", "rough_platforms", "rough_state"]

Floats = NDArray[np.float64]

#: Turn of a bowed leg from base to tip before it is pulled into its joint [rad].
_BOW = 1.5


def rough_state(robot: Robot, guess: HomeGuess) -> Floats:
    """State (N,) of motors, passive joints and rods as far as they are known; the rest is at rest.

    Args:
        robot: The robot.
        guess: What is known.
    """
    state = np.zeros(len(robot.arrays.unit))
    state[robot.motor_indices] = guess.motors
    for joint, index in robot.passive_joints:
        state[index] = guess.joints.get(joint.name, joint.rest)
    grid = robot.grid
    for rod in robot.numbers.rods:
        if guess.strain is None:
            curvature = rod.element.rod.rest_curvature_at(grid.nodes)
        else:
            series = [np.append(coefficients, 0.0) for coefficients in guess.strain[rod.leg]]
            curvature = np.column_stack(
                [legendre.legval(2.0 * grid.nodes - 1.0, coefficients) for coefficients in series]
            )
        state[rod.strain] = rod.element.modes.project(curvature, grid)
    if guess.strain is None:
        _bow(robot, guess, state)
    return state


def _bow(robot: Robot, guess: HomeGuess, state: Floats) -> None:
    """Bend the rods of every leg with a side evenly, from base to tip, to that side."""
    straight = state.copy()
    for rod in robot.numbers.rods:
        straight[rod.strain] = 0.0
    bases = rod_bases(robot, straight)
    for leg, poses, side in zip(robot.numbers.legs, bases, guess.bow, strict=True):
        if side is None:
            continue
        for rod, base in zip(leg.rods, poses, strict=True):
            turn = _BOW / len(poses)
            state[rod.strain] = _bowed(robot, rod, base, side, turn)


def _bowed(robot: Robot, rod: RodNumbers, base: Pose, side: Floats, turn: float) -> Floats:
    """Strain of a rod whose middle stands out to a side in the world, (m,)."""
    across = base.rotation.T @ side  # r'' = R (0, kappa_3, -kappa_2) leads away from the bow
    size = max(1e-12, float(np.hypot(*across[1:])))
    across = turn / rod.element.rod.length * across / size
    bent = np.tile([0.0, across[2], -across[1]], (len(robot.grid.nodes), 1))
    return rod.element.modes.project(bent, robot.grid)


def rough_platforms(robot: Robot, guess: HomeGuess, state: Floats) -> tuple[Pose, ...]:
    """Where the platform may be, the likelier first: where it is said to be; else between the tips.

    Then its rotation is not known: it is not turned, or turned to the tips. Where joints are known, so
    are the tips, and they are asked first.

    Args:
        robot: The robot.
        guess: What is known.
        state: State with the motors (N,); multipliers are not read.
    """
    if guess.platform_position is not None:
        return (Pose(guess.platform_rotation, guess.platform_position),)
    rotations = [guess.platform_rotation]
    if not robot.description.point_platform:
        rotations.append(_rotation_to_tips(robot, state))
    if guess.joints:
        rotations.reverse()
    return tuple(
        Pose(rotation, platform_between_tips(robot, state, rotation)) for rotation in rotations
    )


def _rotation_to_tips(robot: Robot, state: Floats) -> Floats:
    """Rotation (3, 3) that brings the joints of the platform nearest to the rod tips (least squares)."""
    tips = np.array([pose.position for pose in tip_poses(robot, state)])
    joints = np.array([leg.joint.position for leg in robot.description.legs])
    tips, joints = tips - tips.mean(axis=0), joints - joints.mean(axis=0)
    # Where they say nothing it is not turned; in the plane it turns about z only.
    stays = np.diag([1e-3, 1e-3, 1e3 if robot.planar else 1e-3])
    size = max(1e-12, float(np.linalg.norm(tips) * np.linalg.norm(joints)))
    left, _, right = np.linalg.svd(tips.T @ joints / size + stays)
    left[:, 2] *= np.linalg.det(left @ right)  # no reflection
    return np.asarray(left @ right)


def platform_between_tips(robot: Robot, state: Floats, rotation: Floats) -> Floats:
    """Platform position (3,) [m] where its joints are on average at the rod tips.

    Args:
        robot: The robot.
        state: State with the motors (N,); multipliers are not read.
        rotation: R_p in the world, (3, 3).
    """
    joints = np.array([leg.joint.position for leg in robot.description.legs]) @ rotation.T
    tips = np.array([pose.position for pose in tip_poses(robot, state)])
    return np.mean(tips - joints, axis=0)
