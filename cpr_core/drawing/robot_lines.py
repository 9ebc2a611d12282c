# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is drawn of a robot, whatever draws it: lines of legs and links, places of joints, colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..model.equilibrium import Equilibrium
from ..model.robot import Robot, kept_with_robot
from ..model.shape import LegShape, leg_shapes

__all__ = [
    "POINTS",
    "RobotLines",
    "bending_curvature",
    "equilibrium_lines",
    "platform_outline",
    "robot_lines",
    "segments",
    "shades",
]

Floats = NDArray[np.float64]

#: Points along a rod.
POINTS = 24


@dataclass(frozen=True, eq=False)
class RobotLines:
    """A robot as lines and points in the world [m].

    Attributes:
        rods: Points along every rod, (P, 3) each.
        shades: Their colours by bending curvature, red green blue in [0, 1], (P, 3) each.
        links: Both ends of every rigid piece, (K, 2, 3).
        joints: Joints that are not clamped, (J, 3).
        driven: Which of them a motor moves, (J,).
        platform: Tips around the platform, closed where there are three or more, (T, 3).
    """

    rods: tuple[Floats, ...]
    shades: tuple[Floats, ...]
    links: Floats
    joints: Floats
    driven: NDArray[np.bool_]
    platform: Floats


def equilibrium_lines(equilibrium: Equilibrium) -> RobotLines:
    """An equilibrium as lines."""
    return robot_lines(equilibrium.robot, leg_shapes(equilibrium, POINTS))


def robot_lines(robot: Robot, shapes: Sequence[LegShape]) -> RobotLines:
    """Legs of some shape as lines, in equilibrium or not.

    Curvature is coloured from blue (straight) to red: the largest of the robot now, or half a turn
    per rod length if that is more.
    """
    own = [(shape, shape.rod == rod) for shape in shapes for rod in range(shape.rod.max() + 1)]
    curvatures = [bending_curvature(shape.curvature[along]) for shape, along in own]
    largest = max((float(curvature.max()) for curvature in curvatures), default=0.0)
    reddest = max(np.pi / robot.mean_length, largest)
    links = [pair for shape in shapes for piece in shape.rigid_pieces for pair in pairwise(piece)]
    joints = [joint for shape in shapes for joint in shape.joints if joint.kind != "fixed"]
    tips = np.array([shape.position[-1] for shape in shapes])
    return RobotLines(
        rods=tuple(shape.position[along] for shape, along in own),
        shades=tuple(shades(curvature / reddest) for curvature in curvatures),
        links=np.array(links).reshape(-1, 2, 3),
        joints=np.array([joint.position for joint in joints]).reshape(-1, 3),
        driven=np.array([joint.motor is not None for joint in joints], np.bool_),
        platform=tips[platform_outline(robot)],
    )


@kept_with_robot
def platform_outline(robot: Robot) -> list[int]:
    """Numbers of the legs whose tips go around the platform; the first again at the end of three."""
    legs = robot.description.legs
    if len(legs) < 3:
        return list(range(len(legs)))
    holds = np.array([leg.joint.position for leg in legs])
    holds -= holds.mean(axis=0)
    # Seen along the axis of the platform frame nearest to the normal of the plate.
    seen = np.delete(holds, np.abs(np.linalg.svd(holds)[2][2]).argmax(), axis=1)
    order = np.argsort(np.arctan2(seen[:, 1], seen[:, 0])).tolist()
    return [*order, order[0]]


def bending_curvature(curvature: Floats) -> Floats:
    """Size of the bending part of (torsion, bending, bending), (P, 3) to (P,) [1/m]."""
    return np.hypot(curvature[:, 1], curvature[:, 2])


def shades(fractions: Floats) -> Floats:
    """From blue at 0 over green to red at 1: (P,) to red green blue (P, 3)."""
    value = np.clip(fractions, 0.0, 1.0)
    return np.stack(
        [
            np.maximum(0.0, 2.0 * value - 1.0),
            1.0 - np.abs(2.0 * value - 1.0),
            np.maximum(0.0, 1.0 - 2.0 * value),
        ],
        axis=-1,
    )


def segments(*lines: Floats) -> Floats:
    """Lines of points as pieces: (P, 3) each to (N, 2, 3)."""
    if not lines:
        return np.zeros((0, 2, 3))
    whole = np.concatenate(lines)
    pieces = np.stack([whole[:-1], whole[1:]], axis=1)
    owner = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    return pieces[owner[:-1] == owner[1:]]
