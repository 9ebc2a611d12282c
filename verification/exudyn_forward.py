# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Exudyn's own way from straight legs to equilibrium, and on to the limit of its elements."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .extrapolation import richardson
from .exudyn_robot import ExudynRobot, NotSettled, Shape
from .exudyn_rods import BEAMS, CABLES, RodKind
from .placed_robot import PlacedRobot
from .walk import bowed, gathered

__all__ = ["Answer", "Limit", "assemble", "forward"]

Floats = NDArray[np.float64]

#: Elements of a rod on the way from straight legs.
FEW = 8
#: Stretch and shear are a thousand times easier there: what is slender makes Newton's steps small.
EASY = 1e-3
STEPS = 30
#: On what resists stretch and shear, for the limit without either: twice as stiff every time.
FACTORS = (1.0, 2.0, 4.0)


@dataclass(frozen=True, eq=False)
class Answer:
    """What a program says of a robot at given motors.

    Attributes:
        position: Of the platform, (3,) [m].
        efforts: Of the motors, (n,) [N m or N].
        seconds: Time of the program for it.
    """

    position: Floats
    efforts: Floats
    seconds: float


@dataclass(frozen=True, eq=False)
class Limit:
    """Answers with finer and finer elements, and where they lead.

    Attributes:
        kind: The elements.
        elements: Numbers of elements of a rod, coarse to fine.
        real: Limit in the elements, with the stiffness of the rods as it is.
        unstretched: Limit without stretch and shear too.
        change: What the last halving of elements changed in it.
        seconds: Time of the program for all of it.
        forward_seconds: Of this, from straight legs to the first equilibrium.
    """

    kind: str
    elements: tuple[int, ...]
    real: Answer
    unstretched: Answer
    change: Floats
    seconds: float
    forward_seconds: float


def assemble(robot: PlacedRobot, kind: RodKind) -> Shape:
    """From straight legs at the given motors to equilibrium: bow, gather on the platform, let go.

    Args:
        robot: The robot at its motors.
        kind: Of what elements.

    Returns:
        The equilibrium with few elements.

    Raises:
        NotSettled: Exudyn's static solver finds no way.
    """
    system = ExudynRobot(robot, kind, FEW, EASY)
    unit = robot.stiffness
    system.hold_platform(1e5 * unit)
    system.settle()
    for part in np.linspace(0.0, 1.0, STEPS + 1)[1:]:
        for number in range(len(robot.legs)):
            system.move_tip(number, bowed(robot, number, float(part)))
        system.settle()
    for part in np.linspace(0.0, 1.0, STEPS + 1)[1:]:
        for number in range(len(robot.legs)):
            system.move_tip(number, gathered(robot, number, float(part)))
        system.settle()
    _let_go(system, 1e4 * unit, 1e-2 * unit)
    return _stiffened(robot, kind, system.shape)


def forward(robot: PlacedRobot, halvings: int = 3) -> Limit:
    """The equilibrium at given motors in the limit of short elements, with stretch and without.

    Args:
        robot: The robot at its motors.
        halvings: How often the elements are halved from eight on.

    Raises:
        NotSettled: Exudyn's static solver finds no way.
    """
    kind: RodKind = CABLES if robot.description.planar else BEAMS
    begin = time.perf_counter()
    shape = assemble(robot, kind)
    assembled = time.perf_counter()
    counts = tuple(FEW * 2**level for level in range(1, halvings + 1))
    limits, changes = [], []
    for factor in FACTORS:
        answers, last = [], shape
        for count in counts:
            last = _halved(robot, kind, last)
            system = _settled(robot, kind, count, factor, last)
            last = system.shape
            answers.append(_answer(system))
        numbers = [np.concatenate(answer) for answer in answers]
        limit, change = richardson(numbers, kind.order)
        limits.append(limit)
        changes.append(change)
    seconds = time.perf_counter() - begin
    stiff, _ = richardson(limits, order=1, step=1)
    real, unstretched = (Answer(found[:3], found[3:], seconds) for found in (limits[0], stiff))
    return Limit(
        kind.name,
        counts,
        real,
        unstretched,
        changes[0],
        seconds,
        assembled - begin,
    )


def _let_go(system: ExudynRobot, begin: float, end: float) -> None:
    """Make the springs that hold the platform softer, as fast as Newton's method follows; then none."""
    stiffness, ratio, last = begin, 0.3, begin
    while stiffness > end:
        system.hold_platform(stiffness)
        try:
            system.settle()
            last, stiffness = stiffness, ratio * stiffness
        except NotSettled:
            ratio = ratio**0.5
            if ratio > 0.98:
                raise
            stiffness = ratio * last
    system.hold_platform(0.0)
    system.settle()


def _stiffened(robot: PlacedRobot, kind: RodKind, shape: Shape) -> Shape:
    """From rods that stretch easily to real ones, as fast as Newton's method follows."""
    factor, ratio, last = 10.0 * EASY, 10.0, EASY
    while last < 1.0:
        try:
            shape = _settled(robot, kind, FEW, factor, shape).shape
            last = factor
        except NotSettled:
            ratio = ratio**0.5
            if ratio < 1.05:
                raise
        factor = min(1.0, ratio * last)
    return shape


def _settled(
    robot: PlacedRobot, kind: RodKind, elements: int, factor: float, shape: Shape
) -> ExudynRobot:
    system = ExudynRobot(robot, kind, elements, factor, shape)
    system.hold_platform(0.0)
    system.settle()
    return system


def _halved(robot: PlacedRobot, kind: RodKind, shape: Shape) -> Shape:
    rods = tuple(
        tuple(kind.halved(nodes, rod.length) for nodes, rod in zip(found, leg.rods, strict=True))
        for found, leg in zip(shape.rods, robot.legs, strict=True)
    )
    return Shape(rods, shape.links, shape.platform)


def _answer(system: ExudynRobot) -> tuple[Floats, Floats]:
    """Position of the platform, (3,) [m], and efforts, (n,) [N m or N]."""
    robot = system.robot
    names = robot.description.motor_names
    efforts = np.zeros(len(names))
    for number, (leg, described) in enumerate(zip(robot.legs, robot.description.legs, strict=True)):
        moment, force = system.clamp_wrench(number)
        motor = next(element.motor for element in described.chain if element.motor is not None)
        efforts[names.index(motor)] += leg.effort(moment, force, robot.description.gravity)
    return system.platform_frame.position, efforts
