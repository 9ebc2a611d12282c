# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The shape a robot is assembled from: what its description knows of home, joints still open."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ..description.robot_description import HomeGuess
from ..lie import projected_rotation
from ..model.robot import Robot
from ..model.shape import Pose, rod_bases, tip_poses

__all__ = ["rough_platforms", "rough_state"]

Floats = NDArray[np.float64]

#: Turn of a bowed leg from base to tip before it is pulled into its joint [rad].
_BOW = 1.5
#: Steps after which a rotation is as points tell, and no part in a thousand of where it began.
_TURNS = 8


def rough_state(robot: Robot, guess: HomeGuess) -> Floats:
    """State (N,) of motors, passive joints and rods as far as they are known; the rest is at rest.

    Args:
        robot: The robot.
        guess: What is known.
    """
    state = np.zeros(len(robot.kernel_arrays.unit))
    state[robot.motor_indices] = guess.motors
    for joint, index in robot.passive_joints:
        state[index] = guess.joints.get(joint.name, joint.rest)
    nodes, strain = robot.grid.nodes, guess.strain
    rods = [rod.element.rod for rod in robot.numbers.rods]
    if strain is None:
        curvatures = _bowed(robot, guess, state)
    else:
        curvatures = [
            np.column_stack(
                [legendre.legval(2.0 * nodes - 1.0, np.append(s, 0.0)) for s in strain[rod.leg]]
            )
            for rod in robot.numbers.rods
        ]
    for alike in robot.numbers.alike_rods:
        wanted = np.array([curvatures[number] for number in alike.numbers])
        wanted -= [rods[number].rest_beyond_at(alike.modes, nodes) for number in alike.numbers]
        state[alike.strain] = alike.modes.project(wanted, robot.grid)
    return state


def _bowed(robot: Robot, guess: HomeGuess, straight: Floats) -> list[Floats]:
    """Strain at the nodes of every rod, (K, 3) each [1/m].

    The rods of a leg with a side are bent evenly, from base to tip, to that side; others are at rest.

    Args:
        robot: The robot.
        guess: What is known.
        straight: State (N,) with straight rods; multipliers are not read.
    """
    curvatures, nodes = [], robot.grid.nodes
    bases = rod_bases(robot, straight)
    for leg, poses, side in zip(robot.numbers.legs, bases, guess.bow, strict=True):
        for rod, base in zip(leg.rods, poses, strict=True):
            if side is None:
                curvatures.append(rod.element.rod.rest_curvature_at(nodes))
                continue
            # r'' = R (0, kappa_3, -kappa_2) leads away from the bow.
            _, second, third = base.rotation.T @ side
            size = rod.element.rod.length * max(1e-12, math.hypot(second, third))
            bent = _BOW / len(poses) / size * np.array([0.0, third, -second])
            curvatures.append(np.broadcast_to(bent, (len(nodes), 3)))
    return curvatures


def rough_platforms(robot: Robot, guess: HomeGuess, state: Floats) -> Iterator[Pose]:
    """Where the platform may be, the likelier first: where it is said to be, else between the tips.

    Args:
        robot: The robot.
        guess: What is known.
        state: State with the motors (N,); multipliers are not read.
    """
    poses = tip_poses(robot, state)
    tips = np.array([pose.position for pose in poses])
    place = guess.platform_position
    for rotation in _rotations(robot, guess, poses, tips):
        yield Pose(rotation, _between(robot, tips, rotation) if place is None else place)


def _rotations(
    robot: Robot, guess: HomeGuess, poses: Sequence[Pose], tips: Floats
) -> Iterator[Floats]:
    """Rotations the platform may have, the likelier first.

    One that is not said is that of its joints to the bases of their legs, or to the rod tips, or that of
    tips which are fixed to it: how the robot stands in the world, and how the platform's frame lies in
    it, makes no difference. Where joints are known, so are the tips, which are asked first; with the
    shapes of the rods they are all there is to ask. Where none of these leads to a home, it is tried not
    turned.
    """
    if robot.description.point_platform:
        yield np.eye(3)
        return
    fixed = _rotations_of_tips(robot, poses)
    if guess.platform_rotation is not None:
        yield guess.platform_rotation
        yield from fixed
        return
    if guess.strain is not None:
        yield from fixed or [_rotation_to(robot, tips)]
        return
    ends = [np.array([leg.base_position for leg in robot.description.legs]), tips]
    if guess.joints:
        ends.reverse()
    yield from (_rotation_to(robot, points) for points in ends)
    yield from fixed
    yield np.eye(3)


def _rotations_of_tips(robot: Robot, tips: Sequence[Pose]) -> list[Floats]:
    """The rotation nearest to those of the tips that are fixed to the platform, if any are."""
    held = 1 if robot.planar else 3
    turned = [
        pose.rotation @ leg.joint.rotation().T
        for leg, pose in zip(robot.description.legs, tips, strict=True)
        if len(leg.joint.orientation(robot.planar)) == held
    ]
    if not turned:
        return []
    return [projected_rotation(np.mean(turned, axis=0))]


def _rotation_to(robot: Robot, points: Floats) -> Floats:
    """Rotation (3, 3) that brings the joints of the platform nearest to a point of each leg, (n, 3)."""
    joints = np.array([leg.joint.position for leg in robot.description.legs])
    points, joints = points - points.mean(axis=0), joints - joints.mean(axis=0)
    # Where they say nothing it is not turned; in the plane it turns about z only.
    stays = np.diag([1e-3, 1e-3, 1e3 if robot.planar else 1e-3])
    size = max(1e-12, float(np.linalg.norm(points) * np.linalg.norm(joints)))
    rotation, told = np.eye(3), points.T @ joints / size
    for _ in range(_TURNS):
        last, rotation = rotation, projected_rotation(told + rotation @ stays)
        if np.abs(rotation - last).max() < 1e-14:
            break
    return rotation


def _between(robot: Robot, tips: Floats, rotation: Floats) -> Floats:
    joints = np.array([leg.joint.position for leg in robot.description.legs]) @ rotation.T
    return np.mean(tips - joints, axis=0)
