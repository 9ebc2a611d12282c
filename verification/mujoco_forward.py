# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From bent legs to equilibrium with MuJoCo's forces, and on to the limit of its pieces."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpr_core.description.joints import Fixed

from .extrapolation import limit_of_powers
from .mujoco_settling import settled
from .mujoco_statics import MujocoRobot
from .placed_robot import PlacedRobot
from .walk import between

__all__ = ["MujocoLimit", "forward_mujoco"]

Floats = NDArray[np.float64]

#: Joints of a rod, and powers of the length of a piece in the error. The cable plugin takes the moment
#: in the frame in front of a joint: of rods that twist as well the error begins with the first power.
BENT = (8, 16, 32), (2, 4)
TWISTED = (8, 12, 16, 24, 32), (1, 2, 3, 4)
#: Steps on the way from bent legs to their joints.
STEPS = 10
#: Steps of time for each of them.
GATHERING = 2


@dataclass(frozen=True, eq=False)
class MujocoLimit:
    """Answers with finer and finer pieces, and where they lead.

    Attributes:
        pieces: Joints of a rod, coarse to fine.
        powers: Of the length of a piece, that were taken out.
        finest: Position [m] and efforts [N m] with the finest, (3 + legs,).
        limit: The same in the limit, (3 + legs,).
        seconds: Time for all of it.
        forward_seconds: Of this, from bent legs to the first equilibrium.
    """

    pieces: tuple[int, ...]
    powers: tuple[int, ...]
    finest: Floats
    limit: Floats
    seconds: float
    forward_seconds: float


def forward_mujoco(robot: PlacedRobot) -> MujocoLimit:
    """The equilibrium at given motors in the limit of short pieces.

    Args:
        robot: The robot at its motors.

    Raises:
        NotPossible: MuJoCo has no such robot.
        NotBalanced: No way is found.
    """
    begin = time.perf_counter()
    twisted = any(isinstance(leg.tip, Fixed) for leg in robot.legs)
    pieces, powers = TWISTED if twisted else BENT
    model = MujocoRobot(robot, pieces[0])
    position = _assembled(model)
    assembled = time.perf_counter()
    answers = [_answer(model, position)]
    for count in pieces[1:]:
        finer = MujocoRobot(robot, count)
        position, model = finer.balance(model.refined(finer, position)), finer
        answers.append(_answer(model, position))
    limit = limit_of_powers(answers, [1.0 / count for count in pieces], powers)
    seconds = time.perf_counter() - begin
    return MujocoLimit(pieces, powers, answers[-1], limit, seconds, assembled - begin)


def _answer(model: MujocoRobot, position: Floats) -> Floats:
    return np.concatenate([model.platform(position).position, model.efforts(position)])


def _assembled(model: MujocoRobot) -> Floats:
    """From bent legs: gather on the platform, let go."""
    position = model.bent()
    begin, end = model.tips(position), model.held
    model.stiffness = 1e4 * model.robot.stiffness
    for part in np.linspace(0.0, 1.0, STEPS + 1)[1:]:
        model.held = [between(*ends, float(part)) for ends in zip(begin, end, strict=True)]
        position = settled(model, position, GATHERING)
    model.stiffness = 0.0
    return settled(model, position)
