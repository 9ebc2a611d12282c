# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From bent legs to rest in PyElastica, and on to the limit of its elements."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from .extrapolation import limit_of_powers
from .placed_robot import PlacedRobot
from .pyelastica_robot import PyelasticaRobot

__all__ = ["PyelasticaLimit", "forward_pyelastica"]

Floats = NDArray[np.float64]

#: Elements of a rod.
ELEMENTS = (16, 24, 32, 48, 64)
#: Powers of their length in the error: that of stretch is the second, and the half of an element behind
#: the clamp, which stretches too, makes the third.
POWERS = (2, 3, 4, 5)
#: The spring that first pulls the tips together, in natural units, and how much stiffer the next one is.
SOFT, STIFFER = 5.0, 4.0


@dataclass(frozen=True, eq=False)
class PyelasticaLimit:
    """Answers with finer and finer elements, and where they lead.

    Attributes:
        elements: Elements of a rod, coarse to fine.
        finest: Position [m] and efforts [N m] with the finest, (3 + legs,).
        limit: The same in the limit, (3 + legs,).
        seconds: Time for all of it, its kernels compiled.
        forward_seconds: Of this, from bent legs to the first equilibrium.
    """

    elements: tuple[int, ...]
    finest: Floats
    limit: Floats
    seconds: float
    forward_seconds: float


def forward_pyelastica(robot: PlacedRobot, elements: tuple[int, ...] = ELEMENTS) -> PyelasticaLimit:
    """The equilibrium at given motors in the limit of short elements, which is that without stretch.

    Args:
        robot: The robot at its motors.
        elements: Elements of a rod, coarse to fine.

    Raises:
        NotPossible: It was not built for such a robot.
        NotRelaxed: It does not come to rest.
    """
    PyelasticaRobot(
        robot, elements[0], joint=SOFT * robot.stiffness
    ).settle()  # compiles its kernels
    begin = time.perf_counter()
    built = _assembled(robot, elements[0])
    assembled = time.perf_counter()
    answers, sizes = [built.answer], [built.size]
    for count in elements[1:]:
        built = PyelasticaRobot(robot, count, _resampled(built, count))
        built.settle()
        answers.append(built.answer)
        sizes.append(built.size)
    limit = limit_of_powers(answers, sizes, POWERS)
    seconds = time.perf_counter() - begin
    return PyelasticaLimit(elements, answers[-1], limit, seconds, assembled - begin)


def _assembled(robot: PlacedRobot, elements: int) -> PyelasticaRobot:
    """From bent legs: a spring between the tips, stiffer and stiffer."""
    stiffness = SOFT * robot.stiffness
    built = PyelasticaRobot(robot, elements, joint=stiffness)
    built.settle()
    while stiffness < built.stiffest_joint:
        stiffness = min(STIFFER * stiffness, built.stiffest_joint)
        built = PyelasticaRobot(robot, elements, built.turns, stiffness)
        built.settle()
    return built


def _resampled(built: PyelasticaRobot, elements: int) -> tuple[Floats, ...]:
    """Turns of other elements along the same rods, at their middles [rad]."""
    known = np.arange(built.elements) / (built.elements - 0.5)
    wanted = np.arange(elements) / (elements - 0.5)
    return tuple(CubicSpline(known, turns)(wanted) for turns in built.turns)
