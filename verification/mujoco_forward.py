# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From bent legs to equilibrium with MuJoCo's forces, and on to the limit of its pieces."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .extrapolation import richardson
from .mujoco_statics import MujocoRobot, NotBalanced
from .placed_robot import PlacedRobot
from .walk import gathered

__all__ = ["MujocoLimit", "forward_mujoco"]

Floats = NDArray[np.float64]

#: Joints of a rod on the way from straight legs.
FEW = 8
STEPS = 10


@dataclass(frozen=True, eq=False)
class MujocoLimit:
    """Answers with finer and finer pieces, and where they lead.

    Attributes:
        pieces: Joints of a rod, coarse to fine.
        finest: Position [m] and efforts [N m] with the finest, (3 + legs,).
        limit: The same in the limit, (3 + legs,).
        seconds: Time for all of it.
        forward_seconds: Of this, from bent legs to the first equilibrium.
    """

    pieces: tuple[int, ...]
    finest: Floats
    limit: Floats
    seconds: float
    forward_seconds: float


def forward_mujoco(robot: PlacedRobot, halvings: int = 2) -> MujocoLimit:
    """The equilibrium at given motors in the limit of short pieces.

    Args:
        robot: The robot at its motors.
        halvings: How often the pieces are halved from eight joints on.

    Raises:
        NotPossible: MuJoCo has no such robot.
        NotBalanced: No way is found.
    """
    begin = time.perf_counter()
    model = MujocoRobot(robot, FEW)
    position = _assembled(model)
    assembled = time.perf_counter()
    answers, counts = [_answer(model, position)], [FEW]
    for _ in range(halvings):
        finer = MujocoRobot(robot, 2 * model.pieces)
        position = finer.balance(model.halved(finer, position))
        model = finer
        counts.append(model.pieces)
        answers.append(_answer(model, position))
    limit, _ = richardson(answers, order=2)
    seconds = time.perf_counter() - begin
    return MujocoLimit(tuple(counts), answers[-1], limit, seconds, assembled - begin)


def _answer(model: MujocoRobot, position: Floats) -> Floats:
    return np.concatenate([model.platform(position).position, model.efforts(position)])


def _assembled(model: MujocoRobot) -> Floats:
    """From bent legs: gather on the platform, let go."""
    robot, unit = model.robot, model.robot.stiffness
    position, model.stiffness = model.bent(), 1e5 * unit
    for part in np.linspace(0.0, 1.0, STEPS + 1)[1:]:
        model.held = [gathered(robot, number, float(part)) for number in range(len(robot.legs))]
        position = model.balance(position)
    stiffness, ratio, last = 1e4 * unit, 0.3, 1e4 * unit
    while stiffness > 1e-2 * unit:
        model.stiffness, forces = stiffness, model.forces
        try:
            position = model.balance(position)
            last, stiffness = stiffness, ratio * stiffness
        except NotBalanced:
            model.forces, ratio = forces, ratio**0.5
            if ratio > 0.98:
                raise
            stiffness = ratio * last
    model.stiffness = 0.0
    return model.balance(position)
