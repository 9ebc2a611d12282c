# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What looks wrong in a home equilibrium that was found, beside what its description knows of it."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from ..description.robot_description import HomeGuess
from ..errors import DescriptionWarning, first_and_others
from ..lie import roll_pitch_yaw, rotation_log
from ..model.equilibrium import Equilibrium
from ..model.shape import LegShape, leg_shapes

__all__ = ["doubt_home"]

Floats = NDArray[np.float64]

#: Distance from the rough pose to the home found that is no roughness any more, in rod lengths.
_ROUGH = 0.5
#: Angle from the rough orientation to the home found that is no roughness any more, and angle by which
#: nobody mounts a rod wound [rad].
_ROUGH_TURN, _WOUND = 0.5, 1.0
#: Pitch from which on the axes of roll and yaw are hardly apart [rad].
_STEEP = 1.2
#: Points of a rod whose mean tells to which side it bows, and how far they stand out on the other side,
#: in distances between the ends, for that to be told.
_BOW_POINTS, _OTHER_SIDE = 9, 0.02
#: What turns a rod about itself, or a platform, where a description has it wrong.
_DIRECTIONS = "tangent, normal, axis and axis_in_rod from bases to tips"


def doubt_home(guess: HomeGuess, unloaded: Equilibrium, home: Equilibrium) -> None:
    """Compares a home with what was known of it.

    Args:
        guess: What was known.
        unloaded: Home before there are loads.
        home: Home.

    Warns:
        DescriptionWarning: It is far from the rough pose of the platform, single angles that are
            controlled are hardly angles there, or rods bow to the other side or are wound.
    """
    _doubt_distance(guess, home)
    _doubt_turn(guess, home)
    _doubt_angles(home)
    if guess.strain is None:  # else somebody knows how rods are bent and wound
        if any(side is not None for side in guess.bow):
            _doubt_sides(guess, unloaded)
        _doubt_winding(unloaded)


def _doubt_distance(guess: HomeGuess, home: Equilibrium) -> None:
    """Whether the rough pose of the platform was a rough one, and no other."""
    if guess.platform_position is None:
        return
    distance = float(np.linalg.norm(guess.platform_position - home.platform_position))
    if distance > _ROUGH * home.robot.mean_length:
        position = ", ".join(f"{value:.4g}" for value in home.platform_position)
        warnings.warn(
            f"{home.robot.description.source}: home.platform.position: the home equilibrium found is "
            f"{distance:.3g} m from there, at ({position}) m: give a better position, or none",
            DescriptionWarning,
            stacklevel=3,
        )


def _doubt_turn(guess: HomeGuess, home: Equilibrium) -> None:
    """Whether the rough orientation of the platform, if one was written, was a rough one."""
    description = home.robot.description
    if description.point_platform or guess.platform_rotation is None:
        return
    turn = float(np.linalg.norm(rotation_log(guess.platform_rotation.T @ home.platform_rotation)))
    if turn > _ROUGH_TURN:
        quaternion = ", ".join(f"{value:.3g}" for value in home.platform_quaternion)
        warnings.warn(
            f"{description.source}: home.platform.quaternion_wxyz: the home equilibrium "
            f"found is turned by {turn:.3g} rad from there, to ({quaternion}): check {_DIRECTIONS}; "
            "or give a better quaternion, or none",
            DescriptionWarning,
            stacklevel=3,
        )


def _doubt_angles(home: Equilibrium) -> None:
    """Whether angles that are controlled one by one tell turns apart: not at a pitch of pi/2."""
    robot = home.robot
    if not robot.controls_angles:
        return
    pitch = float(roll_pitch_yaw(home.platform_rotation)[1])
    if abs(pitch) > _STEEP:
        warnings.warn(
            f"{robot.description.source}: controlled: at home the platform has a pitch of {pitch:.3g} "
            "rad: near pi/2 roll and yaw turn it about the same axis, and some turns are told by none "
            "of the angles; turn the platform's frame, or control its orientation",
            DescriptionWarning,
            stacklevel=3,
        )


def _doubt_sides(guess: HomeGuess, unloaded: Equilibrium) -> None:
    """Whether legs bow to the sides that were written, before there are loads."""
    description, shapes = unloaded.robot.description, leg_shapes(unloaded, _BOW_POINTS)
    otherwise = [
        leg.name
        for leg, shape, side in zip(description.legs, shapes, guess.bow, strict=True)
        if side is not None and leg.rods and _stands_out(shape, side) < -_OTHER_SIDE
    ]
    if otherwise:
        legs = f"{first_and_others(otherwise)} {'bow' if len(otherwise) > 1 else 'bows'}"
        warnings.warn(
            f"{description.source}: home.bow: {legs} to the other side in the home equilibrium found, "
            "before there are loads: give other motors, the side to which it bows, or strain",
            DescriptionWarning,
            stacklevel=3,
        )


def _stands_out(shape: LegShape, side: Floats) -> float:
    """How far the rods of a leg stand out to a side on average, in distances between their ends."""
    points = shape.position[shape.rod >= 0]
    way, beyond = points[-1] - points[0], np.mean(points - points[0], axis=0)
    across = side - (side @ way) / (way @ way) * way
    size = float(np.linalg.norm(across) * np.linalg.norm(way))
    return float(beyond @ across) / size if size > 0.0 else 0.0


def _doubt_winding(unloaded: Equilibrium) -> None:
    """Whether rods are wound before there are loads, as joints at wrong angles do it."""
    robot, state = unloaded.robot, unloaded.state
    windings: dict[str, float] = {}
    for rod, values, rest in zip(robot.numbers.rods, *robot.curvature_stations, strict=True):
        torsion = values[1:-1, 0] @ state[rod.strain] / rod.stretch(state) - rest[1:-1, 0]
        angle = float(rod.length(state)) * float(robot.grid.weights @ torsion)
        leg = robot.description.legs[rod.leg].name
        windings[leg] = max(windings.get(leg, 0.0), angle, key=abs)
    wound = {leg: abs(angle) for leg, angle in windings.items() if abs(angle) > _WOUND}
    if wound:
        worst = sorted(wound, key=lambda leg: wound[leg], reverse=True)
        warnings.warn(
            f"{robot.description.source}: home: {first_and_others(worst)} is wound by "
            f"{wound[worst[0]]:.3g} rad there, before there are loads: check {_DIRECTIONS}",
            DescriptionWarning,
            stacklevel=3,
        )
